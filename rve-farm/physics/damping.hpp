#pragma once
// Local non-viscous damping (Cundall) of the non-affine motion, per component in co-rotated axes.
#include "common/team/cpu_team.hpp"

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

    // F (1 - alpha sign(F (v + dt/2 F/m))): the force is weakened where it drives the motion and strengthened where it
    // brakes it. The velocity is taken at the middle of the kick, which is when the force acts: with the velocity before
    // the kick a disc at rest would be kicked undamped. For spins: torque, moment of inertia, spin.
    TALIK_HOST_DEVICE Real damped(Real force, Real velocity, Real time_step, Real inverse_mass) const {
        const Real power = force * (velocity + time_step / 2 * force * inverse_mass);
        const Real sign = static_cast<Real>((power > 0) - (power < 0));
        return force * (1 - coefficient * sign);
    }
};

} // namespace talik::farm
