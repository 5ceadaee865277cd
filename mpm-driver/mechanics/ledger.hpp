#pragma once
// The balances of a run: mass, momentum, energy. Each entry is booked where it arises and by itself, so that a
// balance that does not close points at a mistake and not at a definition.
//
// Of one step, v^n and v^{n+1} the nodal velocities before and after, vbar their mean (the grid's identity is exact with it):
//   grid      sum m (v^{n+1} - v^n) . vbar = -internal + pressure + gravity + walls (+ prescribed)
//   points    change of kinetic energy = that - transfer - PIC - grid damping - particle damping
//   law       internal work = change of (stored + dissipated + kinetic energy of the RVEs)
#include <string>
#include <vector>

#include "mpm-driver/points/state_column.hpp"

namespace talik::driver {

struct Ledger {
    // Mass, kg
    double initial_mass = 0.0, mass = 0.0, grid_mass = 0.0;

    // Momentum and impulses, cumulative, N s
    double initial_momentum_x = 0.0, initial_momentum_y = 0.0, momentum_x = 0.0, momentum_y = 0.0;
    double wall_impulse_x = 0.0, wall_impulse_y = 0.0;             // true total, confining pressure on the walls included
    double pressure_impulse_x = 0.0, pressure_impulse_y = 0.0;     // of the confining pressure on the free surface
    double gravity_impulse_x = 0.0, gravity_impulse_y = 0.0;
    double damping_impulse_x = 0.0, damping_impulse_y = 0.0;       // of particle and grid damping
    double prescribed_impulse_x = 0.0, prescribed_impulse_y = 0.0; // of a prescribed field
    double impulse_scale = 0.0;                                    // sum of |impulse| over steps and causes

    // Energy, J; works are cumulative and positive when they feed the body
    double initial_kinetic = 0.0, kinetic = 0.0;
    double wall_work = 0.0;       // true total force of the walls times their velocity
    double pressure_work = 0.0;   // of the confining pressure on the free surface: -p dV less its part on the walls
    double gravity_work = 0.0;
    double prescribed_work = 0.0;
    double internal_work = 0.0;   // sum V sigma : D dt, of the grid's forces
    double point_work = 0.0;      // the same, of the increments the laws were asked
    double wall_friction = 0.0;   // dissipated by Coulomb friction at walls
    double wall_impact = 0.0;     // lost where walls changed the grid's velocity abruptly
    double transfer = 0.0;        // lost between points and grid (lumped mass)
    double pic = 0.0;             // lost to alpha_PIC
    double grid_damping = 0.0, particle_damping = 0.0;
    double initial_law_energy = 0.0, law_energy = 0.0; // stored + dissipated + kinetic, of all points' laws
    double stored = 0.0, law_dissipation = 0.0;        // of it

    double input_work() const;      // J, what was put in: kinetic energy at the start and the net work of each boundary, as magnitudes
    double energy_residual() const; // J, what the balance misses
    double mass_error() const;      // relative: of the points' mass since the start, and of the grid's against it
    double momentum_error() const;  // relative to impulse_scale
    double energy_error() const;    // relative to input_work()

    std::vector<StateColumn> state();
};

} // namespace talik::driver
