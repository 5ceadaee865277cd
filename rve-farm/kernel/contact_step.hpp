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
    Real overlap;            // delta0 = r_i + r_j - |b0|, m
};

// Of its discs, m.
template <class Real>
struct ContactRadii {
    Real owner, partner;
};

// What it carries from sub-step to sub-step; besides, of its force, the tangential change: of f_t since the start, less what the
// difference of the discs' rotations gives, N.
template <class Real>
struct ContactMemory {
    Real turn;              // the angle of the branch less the mean rotation of its discs, rad
    Real elongation;        // |b| - |b0|, m
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

// Where its branch is now, and what it has done in this sub-step.
template <class Real>
struct ContactMotion {
    Real normal_x, normal_y;       // n, -
    Real overlap;                  // delta, m
    Real slip;                     // along t in this sub-step, of branch and mean rotation, m
    Real double_roll;              // twice the slip since the start that unequal arms add, m
    Real opening;                  // of this sub-step, m; for the ledger of bonds
};

// The lever arms of f_t, r_i - delta/2 and r_j - delta/2, m: the point of contact halves the overlap.
template <class Real>
struct ContactArms {
    Real owner, partner;

    TALIK_HOST_DEVICE ContactArms(const ContactRadii<Real>& radii, Real overlap) : owner(radii.owner - Real(0.5) * overlap), partner(radii.partner - Real(0.5) * overlap) {}
};

// What the contact does to its discs, and what the ledger books of it.
template <class Real>
struct ContactAction {
    Real x, y;                         // force on the partner, N; the owner gets the opposite
    Real owner_torque, partner_torque; // N m
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
    Real bonded; // 1 or 0
    Real beta;   // beta_b of Eq. (8), -
};

// How the branch moves.
template <class Real>
TALIK_HOST_DEVICE ContactMotion<Real> contact_motion(const CellMotion<Real>& cell, const ContactStart<Real>& start, const ContactRadii<Real>& radii,
                                                     const RelativeMotion<Real>& moved, ContactMemory<Real>& memory) {
    const Real nx = start.normal_x, ny = start.normal_y;
    // (b - b0) / |b0| = (F - I) n0 + (w_j - w_i) / |b0| (Eqs. 44, 45)
    const Real gx = (cell.xx * nx + cell.xy * ny) + moved.x * start.inverse_length;
    const Real gy = (cell.yx * nx + cell.yy * ny) + moved.y * start.inverse_length;
    const BranchMotion<Real> branch(nx * gx + ny * gy, nx * gy - ny * gx);
    const Real length_at_start = (radii.owner + radii.partner) - start.overlap, elongation = length_at_start * branch.strain; // |b0|, |b| - |b0|, m

    // The slip of this sub-step along t, second order: |b| at its middle times what the branch has turned more than its discs, less
    // what unequal lever arms add: t . db - (r_i - delta/2) dtheta_i - (r_j - delta/2) dtheta_j, m.
    const Real turn = branch.angle_less_half(moved.rotation_sum);
    const Real middle = length_at_start + Real(0.5) * (elongation + memory.elongation);

    ContactMotion<Real> motion;
    motion.normal_x = (nx + gx) * branch.inverse_stretch; // n = (b / |b0|) / (|b| / |b0|)
    motion.normal_y = (ny + gy) * branch.inverse_stretch;
    motion.overlap = start.overlap - elongation;
    motion.slip = middle * (turn - memory.turn);
    motion.double_roll = (radii.owner - radii.partner) * moved.rotation_difference;
    motion.opening = elongation - memory.elongation;
    memory.turn = turn;
    memory.elongation = elongation;
    return motion;
}

// What its springs answer, Eqs. (5)-(7). tangential_start: f_t0, N.
template <bool ledger, class Real, class Physics, class Bonds>
TALIK_HOST_DEVICE ContactAction<Real> contact_force(const Physics& physics, const ContactMotion<Real>& motion, const ContactRadii<Real>& radii, Real tangential_start,
                                                    Real& tangential_change, Bonds& bonds, Real old_tangential, ContactLoss<Real>& loss) {
    constexpr bool with_bonds = Physics::with_bonds;
    const Real kt = physics.contact.tangential_stiffness;
    const Real carried = tangential_change - kt * motion.slip; // of f_t, by Eq. (5b), N
    const ContactForce<Real> trial{physics.contact.normal_stiffness * motion.overlap, tangential_start + (carried + (Real(0.5) * kt) * motion.double_roll)};
    ContactForce<Real> force = physics.contact.limited(trial); // Eqs. (5a), (5c)
    Real friction_loss = Real(0);
    if constexpr (ledger) friction_loss = physics.contact.friction_loss(old_tangential, trial.tangential, force.tangential);
    if constexpr (with_bonds) {
        const Real smaller_radius = smaller(radii.owner, radii.partner); // r of Eqs. (6), (7)
        const auto held = bonds.bonded > Real(0.5);
        const auto breaks = held & physics.bond.breaks(trial, smaller_radius, bonds.beta); // Eqs. (6), (7)
        const auto holds = held & !breaks; // what breaks obeys the unbonded law, on the same step
        if constexpr (ledger) {
            const Real slip = (old_tangential - trial.tangential) * (Real(2) * physics.contact.half_tangential_compliance);
            loss.bond = choose(breaks, physics.contact.breaking_loss(trial, force, motion.opening, slip), Real(0));
            friction_loss = choose(held, Real(0), friction_loss);
        }
        force.normal = choose(holds, trial.normal, force.normal);
        force.tangential = choose(holds, trial.tangential, force.tangential);
        bonds.bonded = choose(holds, Real(1), Real(0));
    }
    if constexpr (ledger) loss.friction = friction_loss;
    tangential_change = carried + (force.tangential - trial.tangential);

    ContactAction<Real> action;
    action.tangential = force.tangential;
    action.x = force.normal * motion.normal_x - force.tangential * motion.normal_y; // f_n n + f_t t
    action.y = force.normal * motion.normal_y + force.tangential * motion.normal_x;
    const Real turning = -force.tangential; // on both discs the same way round
    const ContactArms<Real> arm(radii, motion.overlap);
    action.owner_torque = turning * arm.owner;
    action.partner_torque = turning * arm.partner;
    return action;
}

// Sum of f x b over contacts, J.
template <class Sum>
struct ContactVirial {
    Sum xx = Sum(0), yy = Sum(0), twice_xy = Sum(0);

    template <class Real>
    TALIK_HOST_DEVICE void add(const ContactMotion<Real>& motion, const ContactRadii<Real>& radii, const ContactAction<Real>& action) {
        const Real length = (radii.owner + radii.partner) - motion.overlap, bx = length * motion.normal_x, by = length * motion.normal_y;
        xx += static_cast<Sum>(action.x * bx);
        yy += static_cast<Sum>(action.y * by);
        twice_xy += static_cast<Sum>(action.x * by + action.y * bx);
    }
};

} // namespace talik::farm
