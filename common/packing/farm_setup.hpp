#pragma once
// What a farm must know before the first step: material, packings, and which RVE starts from which packing. The driver
// makes it from the scene and sends it with the exchange's `configure` message; a farm reads no scene.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/packing/packing.hpp"
#include "common/physics/rve_parameters.hpp"

namespace talik {

struct FarmSetup {
    RveParameters parameters;
    std::vector<Packing> packings;
    std::vector<int> packing_of_rve; // index into packings, by the farm's RVE
    // Of several farms each has a share of the RVEs, counted from 0 on in its messages; these are their ids in the run, under
    // which they stand in checkpoints. Empty: the same.
    std::vector<std::uint32_t> ids;
};

std::vector<std::byte> encode(const FarmSetup& setup);
FarmSetup decode_farm_setup(std::span<const std::byte> bytes); // a malformed payload is an Error

} // namespace talik
