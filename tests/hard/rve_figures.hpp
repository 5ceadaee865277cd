#pragma once
// Figures of RVEs that the hard cases are judged by.
#include <algorithm>
#include <cmath>

#include "tests/hard/hard_case.hpp"
#include "tests/support/rve_samples.hpp"

namespace talik::hard {

// Contacts open, close, slip and break anywhere within a sub-step, which costs energy of the first order in it at least.
const Invariant closed_ledger{"ledger's residual, of what was turned over", 1e-3,
                              "events fall within a sub-step: 1e-3 at a quarter of the critical one, 1e-4 at an eighth of that, tests [energy]"};

// Forces known to a rounding of single leave velocities of that part of what they could make: its square in energy.
const Invariant at_rest{"kinetic over stored energy at rest", 4 * unit_single * unit_single, "the square of single's rounding (6e-8) in the force of each of a disc's four contacts"};

// The same discs, each moved by up to so many metres: how far their answer scatters is the error of a reference that rounds so.
inline Packing moved(Packing packing, double distance) {
    std::uint64_t seed = 17;
    for (double& x : packing.x) x += distance * farm::samples::draw(seed);
    for (double& y : packing.y) y += distance * farm::samples::draw(seed);
    return packing;
}

// First law: what an RVE holds, over what it held and the work done on it since.
inline double held_over_fed(const farm::Answer& from, const farm::Answer& to) {
    return (to.stored_energy + to.kinetic_energy) / (from.stored_energy + from.kinetic_energy + std::max(to.work - from.work, 0.0));
}
const Invariant first_law{"stored and kinetic energy over that of the start and the work since", 1 + 1e-3, "first law: nothing else feeds it; to the ledger's 1e-3"};

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
