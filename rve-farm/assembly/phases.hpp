#pragma once
// The phases of one sub-step: what a contact does, what a disc does, what the cell does. Index i writes only slot i.
// Leapfrog: positions at whole, velocities at half sub-steps. Forces are those of the present positions when a sub-step
// begins and when it ends, so the stress of a macro step belongs to the configuration it ends in.
#include <cmath>

#include "rve-farm/assembly/columns.hpp"
#include "rve-farm/physics/contact.hpp"

namespace talik::farm {

// The non-affine force and torque on a disc, summed in list order: first what it owns, then what comes in.
struct DiscForce {
    double x = 0, y = 0, torque = 0; // N, N, N m
};

TALIK_HOST_DEVICE inline DiscForce gather_forces(const AssemblyView& s, int i) {
    DiscForce sum;
    const double radius = s.radius[i];
    for (int c = s.owned_begin[i]; c < s.owned_begin[i + 1]; ++c) {
        sum.x -= s.force_x[c];
        sum.y -= s.force_y[c];
        sum.torque -= s.tangential_force[c] * (radius - s.half_overlap[c]);
    }
    for (int k = s.incoming_begin[i]; k < s.incoming_begin[i + 1]; ++k) {
        const int c = s.incoming[k];
        sum.x += s.force_x[c];
        sum.y += s.force_y[c];
        sum.torque -= s.tangential_force[c] * (radius - s.half_overlap[c]);
    }
    return sum;
}

// One component: kick with damping, v <- v + dt F_damped / m; what the damping has taken is booked, J.
template <class DampingLaw>
TALIK_HOST_DEVICE double kicked(const DampingLaw& damping, double force, double velocity, double kick, double inverse_mass,
                                double& dissipated) {
    const double damped = damping.damped(force, velocity, kick, inverse_mass);
    const double next = velocity + kick * damped * inverse_mass;
    if constexpr (DampingLaw::exists) dissipated += (force - damped) * (velocity + next) / 2 * kick;
    return next;
}

// Newton for the non-affine motion (Eqs. 44-46): kick the velocity, stretch the position with the cell, drift.
template <class Physics>
TALIK_HOST_DEVICE void move_disc(const AssemblyView& s, const Physics& physics, int i) {
    const DiscForce force = gather_forces(s, i);
    const Symmetric d = s.stretch.change();
    const double inverse_mass = 1 / s.mass[i];
    const double inverse_inertia = 2 * inverse_mass / (s.radius[i] * s.radius[i]); // 1 / (m r^2 / 2), 1/(kg m^2)
    const double vx = s.velocity_x[i], vy = s.velocity_y[i];
    double dissipated = 0;
    double next_x = kicked(physics.damping, force.x, vx, s.kick, inverse_mass, dissipated);
    double next_y = kicked(physics.damping, force.y, vy, s.kick, inverse_mass, dissipated);
    s.spin[i] = kicked(physics.damping, force.torque, s.spin[i], s.kick, inverse_inertia, dissipated);
    if constexpr (decltype(physics.fluctuation)::exists) { // -D v_f, the reaction to the kinetic stress
        const double lost_x = d.xx * vx + d.xy * vy, lost_y = d.xy * vx + d.yy * vy; // dt D v_f, m/s
        s.fluctuation_work[i] -= s.mass[i] * (lost_x * (vx + next_x - lost_x) + lost_y * (vy + next_y - lost_y)) / 2;
        next_x -= lost_x;
        next_y -= lost_y;
    }
    if constexpr (decltype(physics.damping)::exists) s.damping_dissipation[i] += dissipated;
    s.velocity_x[i] = next_x;
    s.velocity_y[i] = next_y;
    s.speed_squared[i] = next_x * next_x + next_y * next_y;
    const double x = s.x[i], y = s.y[i];
    s.x[i] = x + (d.xx * x + d.xy * y) + s.sub_step * next_x; // U x + dt v_f, m
    s.y[i] = y + (d.xy * x + d.yy * y) + s.sub_step * next_y;
}

// Kahan's sum: value += change, with the rounding error kept for the next time. A constant small change added to a
// larger number is rounded the same way every time: 1e5 sub-steps would turn the frame by 1e-11 too little.
TALIK_HOST_DEVICE inline void add_exactly(double& value, double& lost, double change) {
    const double corrected = change - lost;
    const double sum = value + corrected;
    lost = (sum - value) - corrected;
    value = sum;
}

// H' <- U' H', theta <- theta + angle of R (Eq. 45).
TALIK_HOST_DEVICE inline void move_cell(AssemblyNumbers& n, const Stretch& stretch) {
    const Symmetric d = stretch.change();
    const double xx = n.cell_xx, xy = n.cell_xy, yx = n.cell_yx, yy = n.cell_yy;
    add_exactly(n.cell_xx, n.lost_xx, d.xx * xx + d.xy * yx);
    add_exactly(n.cell_yx, n.lost_yx, d.xy * xx + d.yy * yx);
    add_exactly(n.cell_xy, n.lost_xy, d.xx * xy + d.xy * yy);
    add_exactly(n.cell_yy, n.lost_yy, d.xy * xy + d.yy * yy);
    add_exactly(n.frame_angle, n.lost_angle, stretch.rotation);
}

// Eqs. (5)-(7): the force of one candidate contact after the discs have moved; `gained` is I - U^-1 of this sub-step.
template <class Physics>
TALIK_HOST_DEVICE void contact_force(const AssemblyView& s, const Physics& physics, const Symmetric& gained, int c) {
    constexpr bool with_bonds = decltype(physics.bond)::exists;
    const int i = s.first[c], j = s.second[c];
    const AssemblyNumbers& n = *s.numbers;
    const double image_x = s.image_x[c], image_y = s.image_y[c];
    const double bx = s.x[j] - s.x[i] + (n.cell_xx * image_x + n.cell_xy * image_y); // branch, m
    const double by = s.y[j] - s.y[i] + (n.cell_yx * image_x + n.cell_yy * image_y);
    const double ri = s.radius[i], rj = s.radius[j];
    const double distance_squared = bx * bx + by * by;
    bool bonded = false;
    if constexpr (with_bonds) bonded = s.bonded[c] != 0;
    const double old_x = s.force_x[c], old_y = s.force_y[c];
    // An open candidate that carried nothing carries nothing: most of the skin ends here, without a square root.
    if (distance_squared >= (ri + rj) * (ri + rj) && !bonded && old_x == 0 && old_y == 0) return;

    const double distance = std::sqrt(distance_squared);
    const double inverse = 1 / distance;
    const double nx = bx * inverse, ny = by * inverse;
    const double overlap = ri + rj - distance; // delta, m
    // Displacement of `second` relative to `first` in this sub-step: affine part D b dt, and v_f dt (Eq. 44).
    const double gx = s.sub_step * (s.velocity_x[j] - s.velocity_x[i]);
    const double gy = s.sub_step * (s.velocity_y[j] - s.velocity_y[i]);
    const double affine_x = gained.xx * (bx - gx) + gained.xy * (by - gy);
    const double affine_y = gained.xy * (bx - gx) + gained.yy * (by - gy);
    const double opening = nx * (affine_x + gx) + ny * (affine_y + gy);
    // Along t at the middle of the sub-step (second order), less what the spins roll at the contact point, whose lever
    // arms r - delta/2 add up to |b|: the same that turn f_t into torques, so power and torque agree.
    const double slip = (nx * (affine_y + gy) - ny * (affine_x + gx)) * (1 + opening * inverse / 2) -
                        s.sub_step * ((ri - overlap / 2) * s.spin[i] + (rj - overlap / 2) * s.spin[j]);

    const double old_tangential = s.tangential_force[c];
    const ContactForce<double> trial = physics.contact.elastic(overlap, old_tangential, slip);
    ContactForce<double> force = trial;
    if (!bonded) {
        force = physics.contact.limited(trial);
        s.friction_dissipation[c] += physics.contact.friction_loss(old_tangential, trial.tangential, force.tangential);
    }
    if constexpr (with_bonds) {
        if (bonded && physics.bond.breaks(trial, ri < rj ? ri : rj, s.beta)) {
            force = physics.contact.limited(trial); // the unbonded law, on the same step
            s.bonded[c] = 0;
            s.bond_dissipation[c] += physics.contact.breaking_loss(trial, force, opening, slip);
        }
    }
    const double fx = force.normal * nx - force.tangential * ny;
    const double fy = force.normal * ny + force.tangential * nx;
    // V sigma : D dt of this contact, -(f_old + f_new)/2 . (D b) dt: the trapezoid that leapfrog conserves.
    s.work[c] -= ((old_x + fx) * affine_x + (old_y + fy) * affine_y) / 2;
    s.force_x[c] = fx;
    s.force_y[c] = fy;
    s.tangential_force[c] = force.tangential;
    s.half_overlap[c] = overlap / 2;
}

} // namespace talik::farm
