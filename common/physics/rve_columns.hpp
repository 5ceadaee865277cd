#pragma once
// The catalogue of the quantities an RVE can be sent and asked for. Tension positive, SI. Energies are of one whole RVE
// (J, its volume = cell area * thickness) and cumulative since the start of the run, so that a lost answer loses nothing.
#include <vector>

#include "common/base/column.hpp"

namespace talik::rve_columns {

// To the RVE.
inline const Column displacement_gradient_increment{"displacement_gradient_increment", 4, "1",
    "dt grad v of the step, xx xy yx yy (row-major: component ij is d v_i / d x_j * dt)"};
inline const Column ice_saturation{"ice_saturation", 1, "1", "S_i of Eq. (8), in [0, 1], scales the bonds' strengths"};

// From the RVE.
inline const Column stress{"stress", 3, "Pa", "homogenised Cauchy stress of Eq. (49): xx yy xy, tension positive"};
inline const Column status{"status", 1, "1", "0 = sound; else the farm's number of what went wrong in this RVE"};
inline const Column stiffness{"stiffness", 1, "Pa", "upper bound of the P-wave modulus, for the step limit of Eq. (42)"};
inline const Column coordination_number{"coordination_number", 1, "1", "2 N_c / N over contacts that carry force"};
inline const Column broken_bonds{"broken_bonds", 1, "1", "bonds broken since the start"};
inline const Column bonds{"bonds", 1, "1", "bonds that hold"};
inline const Column stored_energy{"stored_energy", 1, "J", "elastic energy of the contacts"};
inline const Column kinetic_energy{"kinetic_energy", 1, "J", "of the non-affine motion and the spins"};
inline const Column friction_dissipation{"friction_dissipation", 1, "J", "lost by sliding, >= 0"};
inline const Column damping_dissipation{"damping_dissipation", 1, "J", "lost by local damping, >= 0"};
inline const Column bond_dissipation{"bond_dissipation", 1, "J", "released by breaking bonds, >= 0"};
inline const Column work{"work", 1, "J", "done on the RVE by the imposed strain: sum of V sigma : d eps"};
inline const Column cell_area{"cell_area", 1, "m^2", "of the periodic cell"};
inline const Column void_ratio{"void_ratio", 1, "1", "cell area / area of the discs - 1"};
inline const Column split_steps{"split_steps", 1, "1", "steps that were repeated in smaller pieces since the start"};
inline const Column retaken_chunks{"retaken_chunks", 1, "1", "chunks of sub-steps taken again, shorter or on a new list, since the start"};

inline std::vector<Column> requests() { return {displacement_gradient_increment, ice_saturation}; }

inline std::vector<Column> answers() {
    return {stress, status, stiffness, coordination_number, broken_bonds, bonds, stored_energy, kinetic_energy,
            friction_dissipation, damping_dissipation, bond_dissipation, work, cell_area, void_ratio, split_steps, retaken_chunks};
}

} // namespace talik::rve_columns
