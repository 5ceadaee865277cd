#pragma once
// The balances of a run: mass, momentum, energy. Each entry is booked where it arises and by itself, so that a
// balance that does not close points at a mistake and not at a definition.
//
// Of one step, v^n and v^{n+1} the nodal velocities before and after, vbar their mean (the grid's identity is exact with it):
//   grid      sum m (v^{n+1} - v^n) . vbar = -internal + pressure + gravity + walls (+ prescribed)
//   points    change of kinetic energy = that - transfer - PIC - grid damping - particle damping
//   strains   internal work = work of the stresses on the increments asked of the laws + strain transfer
//   law       that work = change of (stored + dissipated + kinetic energy of the RVEs)
#include <string>
#include <vector>

#include "mpm-driver/boundary/wall.hpp"
#include "mpm-driver/grid/grid.hpp"
#include "mpm-driver/mechanics/transfer.hpp"
#include "mpm-driver/points/points.hpp"

namespace talik::driver {

struct Ledger {
    // Mass, kg
    double initial_mass = 0.0, mass = 0.0, grid_mass = 0.0;

    // Momentum and impulses, cumulative, N s
    Vector initial_momentum = Vector::Zero(), momentum = Vector::Zero();
    Vector wall_impulse = Vector::Zero();       // true total, the confining pressure on the walls included
    Vector pressure_impulse = Vector::Zero();   // of the confining pressure on the free surface
    Vector gravity_impulse = Vector::Zero();
    Vector damping_impulse = Vector::Zero();    // of particle and grid damping
    Vector prescribed_impulse = Vector::Zero(); // of a prescribed field
    double impulse_scale = 0.0;                 // sum of |impulse| over steps and causes (of the pressure also over nodes), and of the points' |m v| at the start

    double internal_impulse = 0.0;              // sum of |impulse| of the internal forces, over steps and nodes

    // Energy, J; works are cumulative, and positive when they feed the body
    double initial_kinetic = 0.0, kinetic = 0.0;
    double wall_work = 0.0;       // true total force of the walls times their velocity
    double pressure_work = 0.0;   // of the confining pressure on the free surface: -p dV less the walls' part
    double gravity_work = 0.0;
    double prescribed_work = 0.0;
    double internal_work = 0.0;   // sum V sigma : D dt, by the grid's forces
    double point_work = 0.0;      // the same, by the increments that the laws were asked
    double wall_friction = 0.0;   // dissipated by Coulomb friction at walls
    double wall_impact = 0.0;     // lost where walls changed the grid's velocity abruptly
    double transfer = 0.0;        // lost between points and grid (lumped mass)
    double strain_transfer = 0.0; // lost because the points strain with v^{n+1}, which the next map from the points alters
    double pic = 0.0;             // lost to alpha_PIC
    double grid_damping = 0.0, particle_damping = 0.0;
    double phase_change = 0.0;    // taken by the swelling of freezing ground: V sigma : d eps_v / 2 I (negative: fed by it)
    double initial_law_energy = 0.0, law_energy = 0.0; // stored + dissipated + kinetic, of all points' laws
    double law_stored = 0.0, law_dissipation = 0.0;    // of it

    void open(const Points& points);
    void book_grid(const Grid& grid, double dt, double confining_pressure, const Vector& gravity,
                   const std::vector<Wall>& walls, bool prescribed);
    void book_points(const Points& points, const PointUpdateBooks& books, double work);

    double input_work() const;      // J: kinetic energy at the start and the works that feed the body (not those it does), what the ground itself gives back included
    double dissipation() const;     // J: all the numerical and boundary losses above, without the laws'
    double energy_residual() const; // J: what the balance misses
    double mass_error() const;      // relative: of the points' mass since the start, and of the grid's against it
    double momentum_error() const;  // relative to impulse_scale
    double energy_error() const;    // relative to input_work(), or the kinetic energy where that is more
    double numerical_loss() const;  // |transfer| + |strain transfer| + |impact|, relative to input_work(): booked, but not physics

    std::vector<StateColumn> state();

private:
    // Nothing moves the body, or next to nothing: what a millionth of its stored energy, or of its internal impulses, feeds it with is
    // not told from the rounding of these, and balances relative to less would look broken.
    static constexpr double told_from_rounding = 1e-6;
    double energy_scale() const; // J

    void sum_law_energy(const Points& points);
};

// sum_p V sigma : (dt D), J, of the present stress, volume and increment.
double stress_power(const Points& points);
// The same with other increments and volumes: those that the laws were asked with.
double stress_power(const Points& points, const std::vector<Matrix>& increments, const std::vector<double>& volumes);

} // namespace talik::driver
