#pragma once
// A periodic packing of discs, as prepared by `rve-farm pack`, kept in a file and carried by the exchange.
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/math/matrix.hpp"

namespace talik {

struct PackedContact {
    int first = 0, second = 0;         // discs; the branch is x_second + H image - x_first
    std::array<int, 2> image = {0, 0}; // in multiples of the cell's columns
    double tangential_force = 0.0;     // N: component along t = (-n_y, n_x), n from first to second, of the force on `second`
    bool bonded = false;
};

struct Packing {
    Matrix cell = Matrix::Identity(); // columns are the basis vectors H, m
    double thickness = 0.1;           // m
    double grain_density = 2650.0;    // kg/m^3
    std::vector<double> x, y, radius; // m
    std::vector<double> velocity_x, velocity_y, spin; // non-affine velocity m/s, spin 1/s (empty = at rest)
    std::vector<PackedContact> contacts;
    double pressure = 0.0;            // Pa it was prepared at (compression positive), for information
    double vertical_stress = 0.0;     // Pa, compression positive: of a snapshot along a K0 path; 0 = isotropic, at `pressure`
    double lateral_stress = 0.0;      // Pa, compression positive: measured in that snapshot
    std::uint64_t seed = 0;
    double stiffness = 0.0;           // Pa: P-wave modulus of the contacts (upper bound), for information; 0 = not known
    double stable_step = 0.0;         // s: 2/omega_max of the contact network, for information; 0 = not known

    int disc_count() const { return static_cast<int>(radius.size()); }
    double void_ratio() const; // area based: A_cell / sum(pi r^2) - 1
};

} // namespace talik
