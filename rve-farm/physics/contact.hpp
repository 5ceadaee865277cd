#pragma once
// The contact of two discs without a bond, Eqs. (5a)-(5c) of the paper.
#include "rve-farm/physics/real.hpp"

namespace talik::farm {

// The force of a contact on its `second` disc, along n (from first to second) and t = (-n_y, n_x).
template <class Real>
struct ContactForce {
    Real normal = Real(0);     // f_n, N; positive pushes the discs apart
    Real tangential = Real(0); // f_t, N
};

template <class Real>
struct ContactLaw {
    Real normal_stiffness;     // k_n, N/m
    Real tangential_stiffness; // k_t, N/m
    Real friction;             // mu, -
    // 1 / (2 k_n), 1 / (2 k_t), m/N: once per chunk instead of a division per contact.
    Real half_normal_compliance = Real(0.5) / normal_stiffness;
    Real half_tangential_compliance = Real(0.5) / tangential_stiffness;

    // Both springs at work and nothing lost: f_n = k_n delta (Eq. 5a), f_t = f_t,old - k_t du_t (Eq. 5b).
    // overlap: delta, m. slip_increment: du_t, relative displacement of `second` along t in this sub-step, m.
    TALIK_HOST_DEVICE ContactForce<Real> elastic(Real overlap, Real old_tangential, Real slip_increment) const {
        return {normal_stiffness * overlap, old_tangential - tangential_stiffness * slip_increment};
    }

    // What a contact without bond can bear: no tension, and |f_t| scaled back to mu f_n (Eq. 5c).
    TALIK_HOST_DEVICE ContactForce<Real> limited(ContactForce<Real> trial) const {
        const Real normal = larger(trial.normal, Real(0));
        const Real limit = friction * normal; // mu f_n, N
        return {normal, within(limit, trial.tangential)};
    }

    // Energy stored in the two springs, J: f_n^2 / 2 k_n + f_t^2 / 2 k_t.
    TALIK_HOST_DEVICE Real stored_energy(ContactForce<Real> force) const {
        return force.normal * force.normal * half_normal_compliance + force.tangential * force.tangential * half_tangential_compliance;
    }

    // Friction work of a sub-step, J: (f_t,old + f_t)/2 times the slip of the slider, (f_t,trial - f_t)/k_t. In steady
    // sliding mu f_n times the slip. The mean of old and new force, because that is what the trapezoidal work of leapfrog
    // puts into the contact: so the ledger closes.
    TALIK_HOST_DEVICE Real friction_loss(Real old_tangential, Real trial_tangential, Real tangential) const {
        return (old_tangential + tangential) * (trial_tangential - tangential) * half_tangential_compliance;
    }

    // Energy lost when a bond breaks and the trial force falls to the actual one, at the end of a sub-step in which the
    // discs moved apart by `opening` and past one another by `slip_increment`, J. The second term is again the difference
    // to the trapezoidal work.
    TALIK_HOST_DEVICE Real breaking_loss(ContactForce<Real> trial, ContactForce<Real> actual, Real opening,
                                         Real slip_increment) const {
        return stored_energy(trial) - stored_energy(actual) +
               ((trial.normal - actual.normal) * opening + (trial.tangential - actual.tangential) * slip_increment) * Real(0.5);
    }
};

} // namespace talik::farm
