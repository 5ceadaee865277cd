#pragma once
// What an RVE starts from and is made of, as a scene or a test asks for it.
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/physics/rve_parameters.hpp"

namespace talik {

// Snapshots along one K0 compression (no lateral strain) of each packing, at rest at vertical stresses between two ends.
struct K0Spec {
    int levels = 8;
    std::string spacing = "linear";              // of the stresses, or "geometric"
    std::optional<double> stress_min, stress_max; // Pa, compression positive; empty = those of the scene's depths

    std::vector<double> stresses() const; // Pa, ascending; both ends must be known
};

// Where packings come from: a file of `rve-farm pack`, CSV, or a specification (prepared at the first run and cached).
struct PackingSpec {
    std::string file;                              // HDF5; empty = by CSV or specification
    std::string particles, contacts;               // CSV; empty = by file or specification
    int discs = 400;
    double radius_min = 2.5e-3, radius_max = 5e-3; // m, uniform by number
    double void_ratio = 0.0;                       // target, -; area based
    double void_ratio_tolerance = 1e-3;            // -
    double pressure = 1e5;                         // Pa, compression positive
    std::uint64_t seed = 1;
    int count = 1;                                 // packings of seeds seed, seed+1, ...; dealt out in a seeded random order
    std::optional<K0Spec> k0;                      // each at the stresses of depth, one after the other in the file

    bool by_specification() const { return file.empty() && particles.empty(); }
};

struct RveSpec {
    PackingSpec packing;
    RveParameters parameters;
};

} // namespace talik
