#pragma once
// Local non-viscous damping (Cundall) of the non-affine motion, per component in co-rotated axes.
#include "rve-farm/physics/real.hpp"

namespace talik::farm {

struct NoDamping {
    static constexpr bool exists = false;
    template <class Real>
    TALIK_HOST_DEVICE Real damped(Real push, Real) const {
        return push;
    }
};

template <class Real>
struct LocalDamping {
    static constexpr bool exists = true;
    Real coefficient; // alpha, -

    // F - alpha |F| sign(v), which is F (1 - alpha sign(F v)): the force is weakened where it drives the motion and strengthened
    // where it brakes it. Linear in F for a given motion, so that it serves forces, torques and kicks alike.
    // motion: any number with the sign of the velocity at the middle of the kick, which is when the force acts: with the
    // velocity before the kick a disc at rest would be kicked undamped.
    TALIK_HOST_DEVICE Real damped(Real push, Real motion) const {
        return push - with_sign_of(coefficient * push, motion); // alpha |F| against the motion
    }
};

} // namespace talik::farm
