#pragma once
// The start of every prepared packing: discs of random size at random places, none touching.
#include <cstdint>

#include "common/packing/packing_spec.hpp"
#include "common/packing/packing.hpp"

namespace talik::farm {

// splitmix64: a few lines, the same numbers with every compiler and library.
class RandomNumbers {
public:
    explicit RandomNumbers(std::uint64_t seed) : state_(seed) {}
    double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; } // in [0, 1)

private:
    std::uint64_t next();
    std::uint64_t state_;
};

// Radii uniform by number in [radius_min, radius_max]; a square cell of void ratio `void_ratio`. `attempt` gives other draws
// of the same seed.
Packing random_discs(const RveSpec& spec, std::uint64_t seed, int attempt, double void_ratio);

} // namespace talik::farm
