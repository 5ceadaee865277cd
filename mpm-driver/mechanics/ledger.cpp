#include "mpm-driver/mechanics/ledger.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "mpm-driver/grid/parallel.hpp"

namespace talik::driver {

double stress_power(const Points& points) { return stress_power(points, points.displacement_gradient_increment, points.volume); }

double stress_power(const Points& points, const std::vector<Matrix>& increments, const std::vector<double>& volumes) {
    return ordered_sums<1>(points.count(), [&](std::size_t p, std::array<double, 1>& sum) {
        const Stress& s = points.stress[p];
        const Matrix& e = increments[p];
        sum[0] += volumes[p] * (s[0] * e(0, 0) + s[1] * e(1, 1) + s[2] * (e(0, 1) + e(1, 0)));
    })[0];
}

void Ledger::sum_law_energy(const Points& points) {
    if (!points.mechanical) return;
    const auto sums = ordered_sums<2>(points.count(), [&](std::size_t p, std::array<double, 2>& sum) {
        sum[0] += points.energy[p].total();
        sum[1] += points.energy[p].stored;
    });
    law_energy = sums[0];
    law_stored = sums[1];
    double still = 0.0; // kinetic energy of the RVEs is neither stored elastically nor lost
    for (const LawEnergy& energy : points.energy) still += energy.kinetic;
    law_dissipation = law_energy - law_stored - still;
}

void Ledger::open(const Points& points) {
    *this = Ledger();
    for (std::size_t p = 0; p < points.count(); ++p) {
        initial_mass += points.mass[p];
        if (!points.mechanical) continue;
        initial_momentum += points.mass[p] * points.velocity[p];
        impulse_scale += points.mass[p] * points.velocity[p].norm();
        initial_kinetic += 0.5 * points.mass[p] * points.velocity[p].squaredNorm();
    }
    mass = grid_mass = initial_mass;
    momentum = initial_momentum;
    kinetic = initial_kinetic;
    sum_law_energy(points);
    initial_law_energy = law_energy;
}

void Ledger::book_grid(const Grid& grid, double dt, double pressure, const Vector& gravity, const std::vector<Wall>& walls,
                       bool prescribed) {
    const auto sums = ordered_sums<10>(grid.mass.size(), [&](std::size_t n, std::array<double, 10>& sum) {
        if (grid.mass[n] <= 0.0) return;
        const Vector gained = grid.velocity[n] - grid.velocity_before[n];
        const Vector mean = 0.5 * (grid.velocity[n] + grid.velocity_before[n]);
        const Vector constraint = grid.mass[n] * gained - dt * grid.force[n]; // impulse of walls or prescription, N s
        sum[0] += grid.mass[n];
        sum[1] += grid.mass[n] * gained.dot(mean);                // change of the grid's kinetic energy, J
        sum[2] -= dt * grid.internal_force[n].dot(mean);          // internal work, J
        sum[3] += dt * pressure * grid.unit_pressure_force[n].dot(mean); // -p dV, J
        sum[4] += dt * grid.mass[n] * gravity.dot(mean);
        sum[5] += constraint.dot(mean);
        sum[6] += constraint[0];
        sum[7] += constraint[1];
        sum[8] += dt * pressure * grid.unit_pressure_force[n].norm(); // N s
        sum[9] += dt * grid.internal_force[n].norm();                 // N s
    });
    grid_mass = sums[0];
    internal_work += sums[2];
    internal_impulse += sums[9];
    gravity_work += sums[4];
    transfer += sums[1]; // less what reaches the points: book_points
    const Vector weight = dt * sums[0] * gravity; // N s
    gravity_impulse += weight;
    impulse_scale += weight.norm() + std::abs(sums[8]); // the pressure on a closed surface adds up to nothing, but rounds

    double pressure_on_walls = 0.0; // work, J
    if (prescribed) {
        prescribed_work += sums[5];
        prescribed_impulse += Vector(sums[6], sums[7]);
        impulse_scale += std::hypot(sums[6], sums[7]);
    } else {
        double true_work = 0.0, through_pic = 0.0, friction = 0.0;
        for (const Wall& wall : walls) {
            const WallReaction& r = wall.reaction();
            const Vector total = dt * r.force, by_pressure = total - r.impulse; // N s
            wall_impulse += total;
            pressure_impulse -= by_pressure;
            impulse_scale += total.norm() + by_pressure.norm();
            pressure_on_walls += by_pressure[wall.axis()] * wall.velocity();
            true_work += r.work;
            through_pic += r.pic_work;
            friction += r.friction_dissipation;
        }
        wall_work += true_work + pressure_on_walls;
        wall_friction += friction;
        wall_impact += true_work - through_pic - friction - sums[5];
        pic += through_pic; // the points' PIC term, booked with them, already contains it as a gain
    }
    pressure_work += sums[3] - pressure_on_walls;
}

void Ledger::book_points(const Points& points, const PointUpdateBooks& books, double work) {
    mass = 0.0;
    for (const double m : points.mass) mass += m;
    momentum = books.momentum;
    damping_impulse += books.damping_impulse;
    impulse_scale += books.damping_impulse.norm();
    kinetic = books.kinetic;
    transfer -= books.flip_work;
    pic += books.pic;
    grid_damping += books.grid_damping;
    particle_damping += books.particle_damping;
    point_work += work;
    strain_transfer = internal_work - point_work;
    sum_law_energy(points);
}

double Ledger::dissipation() const {
    return wall_friction + wall_impact + transfer + strain_transfer + pic + grid_damping + particle_damping;
}

double Ledger::input_work() const {
    return initial_kinetic + std::max(wall_work, 0.0) + std::max(pressure_work, 0.0) + std::max(gravity_work, 0.0) + std::max(prescribed_work, 0.0) + std::max(-phase_change, 0.0) + std::max(-internal_work, 0.0);
}

double Ledger::energy_scale() const {
    return std::max({input_work(), kinetic, told_from_rounding * std::abs(initial_law_energy), told_from_rounding * std::abs(law_energy)});
}

double Ledger::energy_residual() const {
    const double fed = wall_work + pressure_work + gravity_work + prescribed_work;
    return initial_kinetic + fed - kinetic - dissipation() - phase_change - (law_energy - initial_law_energy);
}

double Ledger::numerical_loss() const {
    const double scale = energy_scale();
    return scale > 0.0 ? (std::abs(transfer) + std::abs(strain_transfer) + std::abs(wall_impact)) / scale : 0.0;
}

double Ledger::mass_error() const {
    return std::max(std::abs(mass - initial_mass), std::abs(grid_mass - mass)) / initial_mass;
}

double Ledger::momentum_error() const {
    const Vector fed = wall_impulse + pressure_impulse + gravity_impulse + damping_impulse + prescribed_impulse;
    const double scale = std::max(impulse_scale, told_from_rounding * internal_impulse);
    return scale > 0.0 ? (momentum - initial_momentum - fed).norm() / scale : 0.0;
}

double Ledger::energy_error() const {
    const double scale = energy_scale();
    return scale > 0.0 ? std::abs(energy_residual()) / scale : 0.0;
}

std::vector<StateColumn> Ledger::state() {
    std::vector<StateColumn> columns;
    const auto scalar = [&](const char* name, const char* unit, const char* meaning, double& value) {
        columns.push_back({std::string("ledger/") + name, unit, meaning, {""}, &value, 1});
    };
    const auto vector = [&](const char* name, const char* unit, const char* meaning, Vector& value) {
        columns.push_back({std::string("ledger/") + name, unit, meaning, {"x", "y"}, value.data(), 1});
    };
    scalar("initial_mass", "kg", "mass of the points at the start", initial_mass);
    scalar("mass", "kg", "mass of the points", mass);
    scalar("grid_mass", "kg", "mass of the nodes", grid_mass);
    vector("initial_momentum", "N s", "momentum at the start", initial_momentum);
    vector("momentum", "N s", "momentum of the points", momentum);
    vector("wall_impulse", "N s", "impulse of the walls", wall_impulse);
    vector("pressure_impulse", "N s", "impulse of the confining pressure on the free surface", pressure_impulse);
    vector("gravity_impulse", "N s", "impulse of gravity", gravity_impulse);
    vector("damping_impulse", "N s", "impulse of particle and grid damping", damping_impulse);
    vector("prescribed_impulse", "N s", "impulse of a prescribed velocity field", prescribed_impulse);
    scalar("impulse_scale", "N s", "sum of the magnitudes of all impulses, and of the points' momenta at the start", impulse_scale);
    scalar("internal_impulse", "N s", "sum of the magnitudes of the internal forces' impulses on the nodes", internal_impulse);
    scalar("initial_kinetic", "J", "kinetic energy at the start", initial_kinetic);
    scalar("kinetic", "J", "kinetic energy of the points", kinetic);
    scalar("wall_work", "J", "work of the walls", wall_work);
    scalar("pressure_work", "J", "work of the confining pressure on the free surface", pressure_work);
    scalar("gravity_work", "J", "work of gravity", gravity_work);
    scalar("prescribed_work", "J", "work of a prescribed velocity field", prescribed_work);
    scalar("internal_work", "J", "work of the stresses, by the grid's forces", internal_work);
    scalar("point_work", "J", "work of the stresses, by the increments asked of the laws", point_work);
    scalar("wall_friction", "J", "dissipated by friction at walls", wall_friction);
    scalar("wall_impact", "J", "lost in impacts on walls", wall_impact);
    scalar("transfer", "J", "lost between points and grid", transfer);
    scalar("strain_transfer", "J", "lost between the grid's forces and the points' strains", strain_transfer);
    scalar("pic", "J", "lost to the PIC fraction", pic);
    scalar("grid_damping", "J", "dissipated by grid damping", grid_damping);
    scalar("particle_damping", "J", "dissipated by particle damping", particle_damping);
    scalar("phase_change", "J", "taken by the swelling of freezing ground", phase_change);
    scalar("initial_law_energy", "J", "energy booked by the laws at the start", initial_law_energy);
    scalar("law_energy", "J", "energy booked by the laws: stored, dissipated, kinetic", law_energy);
    scalar("law_stored", "J", "elastic energy stored in the laws", law_stored);
    scalar("law_dissipation", "J", "dissipated in the laws", law_dissipation);
    return columns;
}

} // namespace talik::driver
