#pragma once
// Points to grid, forces, and back: the method itself, uGIMP with lumped mass. Eqs. (17)-(23), (26), (34), (35).
#include <functional>
#include <string>
#include <cstdint>

#include "mpm-driver/app/scene.hpp"
#include "mpm-driver/grid/grid.hpp"
#include "mpm-driver/mechanics/supports.hpp"
#include "mpm-driver/points/points.hpp"

namespace talik::driver {

// m_I = sum phi m_p and v_I^n = sum phi m_p v_p / m_I.
void points_to_grid(const Points& points, const Supports& supports, Grid& grid);

// Internal force and the force of a unit pressure on the free surface; then all forces but the walls'.
// stress: of each point, as the nodes are to feel it.
void nodal_forces(const Points& points, const std::vector<Stress>& stress, const Supports& supports, double confining_pressure, const Vector& gravity, Grid& grid);

// v_I^{n+1} = v_I^n + dt f_I / m_I, before the walls.
void advance_grid(Grid& grid, double dt);

// The displacement-gradient increments dt grad v^{n+1} of the points.
void strain_increments(const Grid& grid, const Supports& supports, double dt, Points& points);

struct TransferRates { // of the present stage
    double pic = 0.0;              // alpha_PIC, per step
    double particle_damping = 0.0; // alpha_p, 1/s
    double grid_damping = 0.0;     // alpha_g, 1/s
};

// What the points' update did to energy and momentum, of one step. J, N s, kg m/s
struct PointUpdateBooks {
    double kinetic = 0.0;   // of the points afterwards
    double flip_work = 0.0; // of the grid's acceleration
    double pic = 0.0, grid_damping = 0.0, particle_damping = 0.0; // dissipated
    Vector momentum = Vector::Zero();
    Vector damping_impulse = Vector::Zero();
};

// New velocities and positions of the points.
PointUpdateBooks grid_to_points(const Grid& grid, const Supports& supports, const TransferRates& rates, double dt, Points& points);

// F <- exp(dt L) F and V = det(F) V_0, as the RVEs' cells deform. A point turned inside out is named and stops the run;
// hint: what else the user is told to do then.
void update_deformation(Points& points, std::int64_t step, double time, const std::function<std::string()>& hint);

} // namespace talik::driver
