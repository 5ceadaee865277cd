#pragma once
// From a specification to packings at a target void ratio and pressure (rve-farm pack).
#include <functional>
#include <string>
#include <vector>

#include "common/packing/packing.hpp"
#include "common/packing/packing_spec.hpp"

namespace talik::farm {

// One packing of spec.packing: random discs are compacted under a preparation friction; the friction is found so that the
// void ratio of the packing at rest, with its final friction, is the target. The same seed gives the same bits.
// Out of reach: an Error that names the reachable range; not found within a bounded number of sub-steps: one that says how
// far it came. `note`: how the search stands, now and then.
Packing prepare_packing(const RveSpec& spec, std::uint64_t seed, const std::function<void(const std::string&)>& note = {});

// Packings of seeds seed, seed + 1, ..., spread over threads (0 = all); with [k0], of each seed its snapshots. Where the specification names CSV files: discs with
// contacts are taken as they are, discs alone are brought to the pressure under the final friction.
std::vector<Packing> prepare_packings(const RveSpec& spec, int threads, const std::function<void(int done, const std::string& note)>& progress = {});

} // namespace talik::farm
