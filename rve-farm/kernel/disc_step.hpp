#pragma once
// The law of one disc in one sub-step, by component: Newton for the non-affine motion (Eqs. 44-46). One text for a scalar
// component and for a pack of rows, in which each lane is a component of some disc.
#include "rve-farm/assembly/stretch.hpp"
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

// U - I of a sub-step, in the number of the kernel.
template <class Real>
struct PlanarStretch {
    Real xx, yy, xy;
};

// What the ledger books of a disc in a sub-step.
struct DiscLoss {
    double damping = 0, fluctuation_work = 0; // J
    Symmetric power;                          // of the forces before the kick, W
};

// A whole disc, component by component: v and u (the displacement) are those of x, y and the rotation.
template <bool ledger, class Real, class Physics>
TALIK_HOST_DEVICE void disc_step(const Physics& physics, const PlanarStretch<Real>& d, Real kick, Real dt, const Real (&force)[3], const Real (&inverse_mass)[3], Real mass,
                                 Real (&v)[3], Real (&u)[3], DiscLoss& loss) {
    const Real old[3] = {v[0], v[1], v[2]};
    for (int a = 0; a < 3; ++a) {
        Real damped;
        v[a] = kicked(physics, force[a], old[a], kick, inverse_mass[a], damped);
        if constexpr (ledger) loss.damping += static_cast<double>(damping_loss(force[a], damped, old[a], v[a], kick));
    }
    if constexpr (Physics::with_fluctuation) { // -D v_f, the reaction to the kinetic stress
        const Real lost_x = stretched(d.xx, d.xy, old[0], old[1]), lost_y = stretched(d.yy, d.xy, old[1], old[0]);
        if constexpr (ledger) loss.fluctuation_work -= static_cast<double>(mass * (lost_x * (old[0] + v[0] - lost_x) + lost_y * (old[1] + v[1] - lost_y)) / 2);
        v[0] -= lost_x;
        v[1] -= lost_y;
    }
    const Real x = u[0], y = u[1];
    u[0] = x + (stretched(d.xx, d.xy, x, y) + dt * v[0]); // w <- U w + dt v_f
    u[1] = y + (stretched(d.yy, d.xy, y, x) + dt * v[1]);
    u[2] += dt * v[2];
    if constexpr (ledger) {
        loss.power.xx += static_cast<double>(force[0] * old[0]);
        loss.power.yy += static_cast<double>(force[1] * old[1]);
        loss.power.xy += static_cast<double>(force[0] * old[1] + force[1] * old[0]) / 2;
    }
}

} // namespace talik::farm
