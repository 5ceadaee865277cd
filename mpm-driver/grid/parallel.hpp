#pragma once
// Loops over points and nodes on all threads. Index i writes only slot i, and sums are taken block by block in a fixed
// order, so the bits do not depend on the number of threads.
#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace talik::driver {

// Below this many indices a loop costs less than waking the threads.
constexpr std::ptrdiff_t worth_threads = 512;

template <class Body>
void each(std::size_t count, Body&& body) {
    const auto n = static_cast<std::ptrdiff_t>(count);
#pragma omp parallel for schedule(static) if (n >= worth_threads)
    for (std::ptrdiff_t i = 0; i < n; ++i) body(static_cast<std::size_t>(i));
}

// Several sums over all indices at once: add(i, sums) adds what index i contributes.
template <std::size_t Sums, class Add>
std::array<double, Sums> ordered_sums(std::size_t count, Add&& add) {
    constexpr std::size_t block_size = 256, stride = 64; // up to 64 blocks per round: on the stack, nothing is allocated
    std::array<double, Sums> total{};
    for (std::size_t round = 0; round < count; round += block_size * stride) {
        std::array<std::array<double, Sums>, stride> blocks{};
        const std::size_t here = std::min(stride, (count - round + block_size - 1) / block_size);
        const auto n = static_cast<std::ptrdiff_t>(here);
#pragma omp parallel for schedule(static) if (n > 2)
        for (std::ptrdiff_t b = 0; b < n; ++b) {
            const std::size_t begin = round + static_cast<std::size_t>(b) * block_size;
            const std::size_t end = std::min(begin + block_size, count);
            for (std::size_t i = begin; i < end; ++i) add(i, blocks[static_cast<std::size_t>(b)]);
        }
        for (std::size_t b = 0; b < here; ++b)
            for (std::size_t k = 0; k < Sums; ++k) total[k] += blocks[b][k];
    }
    return total;
}

} // namespace talik::driver
