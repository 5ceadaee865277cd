#pragma once
// Figures of RVEs that the hard cases are judged by.
#include <algorithm>
#include <cmath>

#include "tests/support/rve_samples.hpp"

namespace talik::hard {

inline double difference(const farm::Answer& a, const farm::Answer& b) { // Pa
    double largest = 0;
    for (std::size_t k = 0; k < 3; ++k) largest = std::max(largest, std::abs(a.stress[k] - b.stress[k]));
    return largest;
}

inline double largest_stress(const farm::Answer& a) { return difference(a, farm::Answer()); }

inline double largest_tension(const farm::Answer& a) { // principal, Pa
    return (a.stress[0] + a.stress[1]) / 2 + std::hypot((a.stress[0] - a.stress[1]) / 2, a.stress[2]);
}

// What the ledger leaves unexplained, of all that has changed hands.
inline double ledger_residual(const farm::Answer& from, const farm::Answer& to) {
    const double lost = (to.friction_dissipation - from.friction_dissipation) + (to.damping_dissipation - from.damping_dissipation) +
                        (to.bond_dissipation - from.bond_dissipation);
    return std::abs(farm::samples::ledger_error(from, to)) / (std::abs(to.work - from.work) + lost + from.stored_energy + from.kinetic_energy);
}

} // namespace talik::hard
