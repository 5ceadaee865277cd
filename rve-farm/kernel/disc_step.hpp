#pragma once
// The law of one disc in one sub-step, by component: Newton for the non-affine motion (Eqs. 44-46). One text for a scalar
// component and for a pack of rows, in which each lane is a component of some disc.
#include "rve-farm/physics/real.hpp"

namespace talik::farm {

// Kick with damping: v <- v + dt F_damped / m. `damped` is left for the ledger.
template <class Real, class Physics>
TALIK_HOST_DEVICE Real kicked(const Physics& physics, Real force, Real velocity, Real kick, Real inverse_mass, Real& damped) {
    damped = physics.damping.damped(force, velocity, kick, inverse_mass);
    return velocity + kick * (damped * inverse_mass);
}

// What the damping has taken, per component, W s = J: (F - F_damped) times the mean velocity times the kick.
template <class Real>
TALIK_HOST_DEVICE Real damping_loss(Real force, Real damped, Real velocity, Real next, Real kick) {
    return (force - damped) * ((Real(0.5) * kick) * (velocity + next));
}

// U - I on a vector, one component: `own` and `shear` are the row of the stretch, `value` and `other` the components.
template <class Real>
TALIK_HOST_DEVICE Real stretched(Real own, Real shear, Real value, Real other) {
    return own * value + shear * other;
}

} // namespace talik::farm
