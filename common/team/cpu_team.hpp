#pragma once
// A team works through phases: team.each(count, body) runs body(i) for all i and ends at a barrier, so that nobody
// writes a barrier. In a phase, index i writes only slot i and reads only what earlier phases wrote.
// On the CPU an assembly belongs to one core and a phase is a plain loop; on CUDA it will be a strided loop over a thread
// block. The rules compile when broken, so ShuffledTeam visits every phase in scrambled order: same bits, or a race.
#include <cstdint>
#include <vector>

#if defined(__CUDACC__)
#define TALIK_HOST_DEVICE __host__ __device__ __forceinline__
#else
// Always inlined: kernel files are compiled for several instruction levels, and an out-of-line copy made for a newer machine
// could be the one the linker keeps for all.
#define TALIK_HOST_DEVICE __attribute__((always_inline)) inline
#endif

namespace talik {

struct SerialTeam {
    template <class Body>
    void each(int count, Body&& body) const {
        for (int i = 0; i < count; ++i) body(i);
    }
};

// Visits every phase in another pseudo-random order. For tests.
class ShuffledTeam {
public:
    explicit ShuffledTeam(std::uint64_t seed) : state_(seed * 2 + 1) {}

    template <class Body>
    void each(int count, Body&& body) const {
        order_.resize(static_cast<std::size_t>(count));
        for (int i = 0; i < count; ++i) order_[static_cast<std::size_t>(i)] = i;
        for (int i = count - 1; i > 0; --i)
            std::swap(order_[static_cast<std::size_t>(i)], order_[next() % static_cast<std::uint64_t>(i + 1)]);
        for (int i : order_) body(i);
    }

private:
    std::uint64_t next() const { // splitmix64
        std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        return z ^ (z >> 31);
    }
    mutable std::uint64_t state_;
    mutable std::vector<int> order_;
};

} // namespace talik
