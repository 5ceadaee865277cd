#pragma once
// One macro step of one RVE: the list of phases, repeated for every sub-step.
#include <algorithm>
#include <cmath>

#include "rve-farm/assembly/neighbours.hpp"
#include "rve-farm/assembly/phases.hpp"
#include "rve-farm/assembly/stable_step.hpp"
#include "rve-farm/assembly/answer.hpp"

namespace talik::farm {

struct MacroStep {
    double xx = 0, xy = 0, yx = 0, yy = 0; // displacement-gradient increment dt grad v, fixed axes, -
    double time_increment = 0;             // s
    int substeps = 1;                      // asked for; more are taken where the increment calls for it
    double beta = 1;                       // beta_b of Eq. (8), -
};

// The largest relative change of a length that a sub-step may bring. A branch is about two radii, an overlap at the
// pressures of interest about a hundredth of a diameter: 1e-4 changes an overlap by about 1 %, which the incremental
// tangential law and the trapezoidal work follow to second order.
constexpr double largest_strain_of_a_sub_step = 1e-4;
// An increment beyond this is no step but a fault of whoever asked.
constexpr double largest_strain_of_a_macro_step = 1.0;
// Discs that move by this part of the smallest radius in one sub-step have exploded.
constexpr double largest_displacement_of_a_sub_step = 0.1;

inline int substeps_needed(const MacroStep& step) {
    const double strain = stretch_of(step.xx, step.xy, step.yx, step.yy, 0).largest_strain();
    if (!(strain <= largest_strain_of_a_macro_step) || !std::isfinite(step.xy - step.yx)) return -1;
    return std::max(step.substeps, static_cast<int>(std::ceil(strain / largest_strain_of_a_sub_step * (1 - 1e-12))));
}

// The largest v_f^2, m^2/s^2, in four strands so that it is not one long chain of comparisons; a NaN stays one.
inline double largest_speed_squared(const AssemblyView& s) {
    const auto take = [](double& largest, double value) { // nothing is larger than a NaN, so it stays
        if (value > largest || value != value) largest = value;
    };
    double strand[4] = {0, 0, 0, 0};
    for (int i = 0; i < s.disc_count(); ++i) take(strand[i & 3], s.speed_squared[i]);
    double largest = 0;
    for (double value : strand) take(largest, value);
    return largest;
}

// Keeps the list valid after a move: books the bounds and rebuilds where they are used up. Seam: the fast kernels will
// check once per macro step instead, and roll back to its start if the bound was broken (cheaper, same contacts).
inline Status keep_neighbours(AssemblyView& s, const ColumnChoice& columns) {
    AssemblyNumbers& n = *s.numbers;
    const double displacement = std::sqrt(largest_speed_squared(s)) * s.sub_step;
    if (!(displacement <= largest_displacement_of_a_sub_step * n.smallest_radius)) return Status::not_finite;
    const double strain = s.stretch.largest_strain();
    n.strain_bound += strain;
    n.displacement_bound = n.displacement_bound * (1 + 1.001 * strain) + displacement; // what has moved stretches with the cell
    if (!list_is_spent(n)) return Status::ok;
    return rebuild_neighbours(s, columns);
}

template <class Team, class Physics>
Status advance(const Team& team, AssemblyView& s, const ColumnChoice& columns, const Physics& physics, const MacroStep& step) {
    const int substeps = substeps_needed(step);
    if (substeps < 0) return Status::not_finite;
    const double sub_step = step.time_increment / substeps;
    if (!is_stable(s, physics.contact, sub_step)) return Status::unstable_step;

    AssemblyNumbers& n = *s.numbers;
    if (substeps > step.substeps) ++n.split_steps;
    s.beta = step.beta;
    s.sub_step = sub_step;
    s.stretch = stretch_of(step.xx / substeps, step.xy / substeps, step.yx / substeps, step.yy / substeps, n.frame_angle);
    for (int k = 0; k < substeps; ++k) {
        // Between two sub-steps of different length the forces act for half of each.
        s.kick = n.last_sub_step > 0 ? (n.last_sub_step + sub_step) / 2 : sub_step;
        n.last_sub_step = sub_step;
        team.each(s.disc_count(), [&](int i) { move_disc(s, physics, i); });     // Eqs. (44)-(46)
        team.each(1, [&](int) { move_cell(n, s.stretch); });                     // Eq. (45)
        if (const Status status = keep_neighbours(s, columns); status != Status::ok) return status;
        const Symmetric gained = s.stretch.change_seen_from_the_end();
        team.each(s.contact_count(), [&](int c) { contact_force(s, physics, gained, c); }); // Eqs. (5)-(7)
        s.stretch.turn_with_the_frame();
    }
    return Status::ok;
}

} // namespace talik::farm
