#pragma once
// Local non-viscous damping (Cundall) of the non-affine motion, per component in co-rotated axes.
#include "rve-farm/physics/real.hpp"

namespace talik::farm {

struct NoDamping {
    static constexpr bool exists = false;
    template <class Real>
    TALIK_HOST_DEVICE Real damped(Real force, Real, Real, Real) const {
        return force;
    }
};

template <class Real>
struct LocalDamping {
    static constexpr bool exists = true;
    Real coefficient; // alpha, -

    // F - alpha |F| sign(v + dt/2 F/m), which is F (1 - alpha sign(F v)): the force is weakened where it drives the motion and strengthened where it
    // brakes it. The velocity is taken at the middle of the kick, which is when the force acts: with the velocity before
    // the kick a disc at rest would be kicked undamped. For spins: torque, moment of inertia, spin.
    TALIK_HOST_DEVICE Real damped(Real force, Real velocity, Real time_step, Real inverse_mass) const {
        const Real middle = velocity + (Real(0.5) * time_step) * (force * inverse_mass);
        return force - with_sign_of(coefficient * force, middle); // alpha |F| against the motion
    }
};

} // namespace talik::farm
