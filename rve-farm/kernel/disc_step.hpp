#pragma once
// The law of one disc in one sub-step: Newton for the non-affine motion (Eqs. 44-46). One text for a scalar, a pack of discs
// side by side, and a thread of a GPU.
#include "rve-farm/assembly/stretch.hpp"
#include "rve-farm/physics/real.hpp"

namespace talik::farm {

// Kick with damping: v <- v + dt F_damped / m. `damped` is left for the ledger.
template <class Real, class Physics>
TALIK_HOST_DEVICE Real kicked(const Physics& physics, Real force, Real velocity, Real kick, Real inverse_mass, Real& damped) {
    const Real change = kick * (force * inverse_mass);      // of v without damping, m/s
    const Real motion = velocity + (velocity + change);     // twice the velocity in the middle of the kick, m/s
    damped = physics.damping.damped(force, motion);         // N; compiled away where no ledger asks for it
    return velocity + physics.damping.damped(change, motion);
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

// What the ledger books of discs in a sub-step.
template <class Sum>
struct DiscLoss {
    Sum damping = Sum(0), fluctuation_work = Sum(0);                   // J
    Sum power_xx = Sum(0), power_yy = Sum(0), twice_power_xy = Sum(0); // of the forces before the kick, W
};

// A whole disc, component by component: v and u (the displacement) are those of x, y and the rotation.
template <bool ledger, class Sum, class Real, class Physics>
TALIK_HOST_DEVICE void disc_step(const Physics& physics, const PlanarStretch<Real>& d, Real kick, Real dt, const Real (&force)[3], const Real (&inverse_mass)[3], Real mass,
                                 Real (&v)[3], Real (&u)[3], DiscLoss<Sum>& loss) {
    const Real old[3] = {v[0], v[1], v[2]};
    for (int a = 0; a < 3; ++a) {
        Real damped;
        v[a] = kicked(physics, force[a], old[a], kick, inverse_mass[a], damped);
        if constexpr (ledger && Physics::with_damping) loss.damping += static_cast<Sum>(damping_loss(force[a], damped, old[a], v[a], kick));
    }
    if constexpr (Physics::with_fluctuation) { // -D v_f, the reaction to the kinetic stress
        const Real lost_x = stretched(d.xx, d.xy, old[0], old[1]), lost_y = stretched(d.yy, d.xy, old[1], old[0]);
        if constexpr (ledger) loss.fluctuation_work -= static_cast<Sum>((Real(0.5) * mass) * (lost_x * (old[0] + v[0] - lost_x) + lost_y * (old[1] + v[1] - lost_y)));
        v[0] = v[0] - lost_x;
        v[1] = v[1] - lost_y;
    }
    const Real x = u[0], y = u[1];
    u[0] = x + (stretched(d.xx, d.xy, x, y) + dt * v[0]); // w <- U w + dt v_f
    u[1] = y + (stretched(d.yy, d.xy, y, x) + dt * v[1]);
    u[2] = u[2] + dt * v[2];
    if constexpr (ledger) {
        loss.power_xx += static_cast<Sum>(force[0] * old[0]);
        loss.power_yy += static_cast<Sum>(force[1] * old[1]);
        loss.twice_power_xy += static_cast<Sum>(force[0] * old[1] + force[1] * old[0]);
    }
}

} // namespace talik::farm
