#pragma once
// A team of the size of a thread block, on the CPU. A program for blocks is a sequence of phases: team.phase(body) runs
// body(thread) in every thread and ends at a barrier; in a phase a thread writes what no other thread reads or writes in it.
// What a thread keeps to itself from phase to phase (registers, on a GPU) is a Privates<T>. Here the threads of a phase are
// visited one after the other, in scrambled order: same bits for every order, or a race.
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "common/team/cpu_team.hpp"

#if defined(__CUDACC__)
#define TALIK_BLOCK __device__ __forceinline__
#define TALIK_SHORT_LOOP _Pragma("unroll 1")
#else
#define TALIK_BLOCK inline
#define TALIK_SHORT_LOOP _Pragma("GCC unroll 1")
#endif
// Before a loop that goes round two or three times: unrolled sixteenfold it costs more than it does.

namespace talik {

#if !defined(__CUDACC__)
class CpuBlockTeam {
public:
    // seed 0: in order.
    CpuBlockTeam(int threads, std::uint64_t seed) : order_(static_cast<std::size_t>(threads)), state_(seed), scrambled_(seed != 0) {
        std::iota(order_.begin(), order_.end(), 0);
    }

    int threads() const { return static_cast<int>(order_.size()); }

    template <class T>
    class Privates {
    public:
        explicit Privates(const CpuBlockTeam& team) : values_(team.order_.size()) {}
        T& operator()(int thread) { return values_[static_cast<std::size_t>(thread)]; }

    private:
        std::vector<T> values_;
    };

    template <class Body>
    void phase(Body&& body) const {
        if (scrambled_) scramble();
        for (int thread : order_) body(thread);
    }

protected:
    void scramble() const {
        for (std::size_t i = order_.size() - 1; i > 0; --i) std::swap(order_[i], order_[draw() % (i + 1)]);
    }
    std::uint64_t draw() const { // splitmix64
        std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        return z ^ (z >> 31);
    }
    mutable std::vector<int> order_;
    mutable std::uint64_t state_;
    bool scrambled_;
};
#endif

} // namespace talik
