#pragma once
// Which packing an RVE starts from.
#include <cstdint>
#include <vector>

#include "common/packing/packing.hpp"

namespace talik::driver {

// Which of `packings` each of `count` RVEs starts from: as evenly as it goes, in an order drawn from the seed.
std::vector<int> deal_packings(int count, int packings, std::uint64_t seed);

// How many snapshots of one K0 path stand behind one another in a list of packings; 1 where there is no such path.
int k0_levels(const std::vector<Packing>& packings);

// The same deal among packings kept as snapshots of K0 paths: a seed's path is dealt to each RVE, and of it the snapshot
// whose vertical stress is nearest to that of the RVE's depth. vertical_stress: of each RVE, Pa, compression positive.
std::vector<int> deal_packings_by_depth(const std::vector<Packing>& packings, const std::vector<double>& vertical_stress, std::uint64_t seed);

} // namespace talik::driver
