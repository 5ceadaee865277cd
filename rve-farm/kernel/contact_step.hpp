#pragma once
// The law of one contact in one sub-step, in displacement form: Eqs. (5)-(7) on a branch that has moved from where it was
// at the start of the chunk. One text for a scalar, a pack of lanes, and a thread of a GPU.
#include "rve-farm/kernel/branch_motion.hpp"
#include "rve-farm/physics/contact.hpp"

namespace talik::farm {

// What a contact is at the start of a chunk; constant during it.
template <class Real>
struct ContactStart {
    Real normal_x, normal_y; // n0, from owner to partner
    Real inverse_length;     // 1 / |b0|, 1/m
    Real half_overlap;       // delta0 / 2 = (r_i + r_j - |b0|) / 2, m
    Real tangential;         // f_t0, N
};

// Of its discs: (r_i + r_j) / 2 and (r_i - r_j) / 2, m. The lever arm of f_t on the owner is r_i - delta/2 = |b|/2 + half_difference.
template <class Real>
struct ContactRadii {
    Real half_sum, half_difference;

    TALIK_HOST_DEVICE ContactRadii(Real half_owner, Real half_partner) : half_sum(half_owner + half_partner), half_difference(half_owner - half_partner) {}
};

// What it carries from sub-step to sub-step.
template <class Real>
struct ContactMemory {
    Real double_turn;       // twice the angle of the branch less the rotations of its discs, rad
    Real half_change;       // (|b| - |b0|) / 2, m
    Real tangential_change; // of f_t since the start, less what the difference of the discs' rotations gives, N
};

// Where its ends have gone since the start.
template <class Real>
struct RelativeMotion {
    Real x, y;           // w_j - w_i, non-affine, m
    Real rotation_sum;   // theta_i + theta_j, rad
    Real rotation_difference; // theta_i - theta_j, rad
};

// F - I of the cell since the start of the chunk.
template <class Real>
struct CellMotion {
    Real xx, xy, yx, yy;
};

// What the contact does to its discs, and what the ledger books of it.
template <class Real>
struct ContactAction {
    Real x, y;               // force on the partner, N; the owner gets the opposite
    Real owner_torque, partner_torque; // N m
    Real normal_x, normal_y, half_length; // of the branch now, -, m
    Real tangential;                   // f_t, N
};

// The friction or bond energy that a sub-step has cost, J.
template <class Real>
struct ContactLoss {
    Real friction, bond;
};

// Nothing to hold, nothing to break.
template <class Real>
struct NoBondState {};
template <class Real>
struct BondState {
    Real bonded;         // 1 or 0
    Real smaller_radius; // r of Eqs. (6), (7), m
    Real beta;           // beta_b of Eq. (8), -
};

template <bool ledger, class Real, class Physics, class Bonds>
TALIK_HOST_DEVICE ContactAction<Real> contact_step(const Physics& physics, const CellMotion<Real>& cell, const ContactStart<Real>& start,
                                                   const ContactRadii<Real>& radii, const RelativeMotion<Real>& moved, ContactMemory<Real>& memory, Bonds& bonds,
                                                   Real old_tangential, ContactLoss<Real>& loss) {
    constexpr bool with_bonds = Physics::with_bonds;
    const Real nx = start.normal_x, ny = start.normal_y;
    // (b - b0) / |b0| = (F - I) n0 + (w_j - w_i) / |b0| (Eqs. 44, 45)
    const Real gx = (cell.xx * nx + cell.xy * ny) + moved.x * start.inverse_length;
    const Real gy = (cell.yx * nx + cell.yy * ny) + moved.y * start.inverse_length;
    const BranchMotion<Real> branch(nx * gx + ny * gy, nx * gy - ny * gx);
    const Real half_start = radii.half_sum - start.half_overlap, half_change = half_start * branch.strain; // |b0| / 2, (|b| - |b0|) / 2, m

    // The slip of this sub-step along t, second order: |b| at its middle (the sum of the halves at its ends) times what the
    // branch has turned more than its discs, less what unequal lever arms add: t . db - (r_i - delta/2) dtheta_i -
    // (r_j - delta/2) dtheta_j, m.
    const Real double_turn = branch.twice_the_angle_less(moved.rotation_sum);
    const Real half = half_start + half_change, middle = half + (half_start + memory.half_change);
    const Real kt = physics.contact.tangential_stiffness;
    const Real carried = memory.tangential_change - (Real(0.5) * kt) * (middle * (double_turn - memory.double_turn)); // of f_t, by Eq. (5b), N
    const Real half_overlap = start.half_overlap - half_change, overlap = half_overlap + half_overlap;
    const ContactForce<Real> trial{physics.contact.normal_stiffness * overlap,
                                   start.tangential + (carried + kt * (radii.half_difference * moved.rotation_difference))};
    ContactForce<Real> force = physics.contact.limited(trial); // Eqs. (5a), (5c)
    Real friction_loss = Real(0);
    if constexpr (ledger) friction_loss = physics.contact.friction_loss(old_tangential, trial.tangential, force.tangential);
    if constexpr (with_bonds) {
        const auto held = bonds.bonded > Real(0.5);
        const auto breaks = held & physics.bond.breaks(trial, bonds.smaller_radius, bonds.beta); // Eqs. (6), (7)
        const auto holds = held & !breaks; // what breaks obeys the unbonded law, on the same step
        if constexpr (ledger) {
            const Real opening = Real(2) * (half_change - memory.half_change);
            const Real slip = (old_tangential - trial.tangential) * (Real(2) * physics.contact.half_tangential_compliance);
            loss.bond = choose(breaks, physics.contact.breaking_loss(trial, force, opening, slip), Real(0));
            friction_loss = choose(held, Real(0), friction_loss);
        }
        force.normal = choose(holds, trial.normal, force.normal);
        force.tangential = choose(holds, trial.tangential, force.tangential);
        bonds.bonded = choose(holds, Real(1), Real(0));
    }
    if constexpr (ledger) loss.friction = friction_loss;
    memory.double_turn = double_turn;
    memory.half_change = half_change;
    memory.tangential_change = carried + (force.tangential - trial.tangential);

    ContactAction<Real> action;
    action.normal_x = (nx + gx) * branch.inverse_stretch; // n = (b / |b0|) / (|b| / |b0|)
    action.normal_y = (ny + gy) * branch.inverse_stretch;
    action.half_length = half;
    action.tangential = force.tangential;
    action.x = force.normal * action.normal_x - force.tangential * action.normal_y; // f_n n + f_t t
    action.y = force.normal * action.normal_y + force.tangential * action.normal_x;
    const Real turning = -force.tangential; // on both discs the same way round
    action.owner_torque = turning * (half + radii.half_difference);
    action.partner_torque = turning * (half - radii.half_difference);
    return action;
}

} // namespace talik::farm
