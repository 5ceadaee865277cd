#include "mpm-driver/mechanics/transfer.hpp"

#include <fmt/format.h>

#include "common/base/error.hpp"
#include "mpm-driver/grid/parallel.hpp"
#include "mpm-driver/points/kinematics.hpp"

namespace talik::driver {

void points_to_grid(const Points& points, const Supports& supports, Grid& grid) {
    each(grid.mass.size(), [&](std::size_t node) {
        double mass = 0.0;                 // m_I = sum_p phi_Ip m_p, Eq. (26), kg
        Vector momentum = Vector::Zero();  // sum_p phi_Ip m_p v_p, Eq. (19), kg m/s
        supports.each_point_of(node, [&](std::uint32_t p, double phi, const Vector&) {
            mass += phi * points.mass[p];
            momentum += phi * points.mass[p] * points.velocity[p];
        });
        grid.mass[node] = mass;
        grid.velocity_before[node] = mass > 0.0 ? Vector(momentum / mass) : Vector::Zero();
    });
}

void nodal_forces(const Points& points, const std::vector<Stress>& stress, const Supports& supports, double pressure, const Vector& gravity, Grid& grid) {
    each(grid.mass.size(), [&](std::size_t node) {
        Vector internal = Vector::Zero(), unit_pressure = Vector::Zero();
        supports.each_point_of(node, [&](std::uint32_t p, double, const Vector& gradient) {
            const Stress& s = stress[p];
            const double volume = points.volume[p];
            // f_I^int = -sum_p V_p sigma_p . grad phi_Ip, Eq. (22), N
            internal -= volume * Vector(s[0] * gradient[0] + s[2] * gradient[1], s[2] * gradient[0] + s[1] * gradient[1]);
            // A pressure p on the whole surface is the force -p sum_p V_p grad phi_Ip (divergence theorem): together the
            // internal force of sigma + p I, so a body in the uniform stress -p I rests exactly, whatever its outline.
            unit_pressure -= volume * gradient;
        });
        grid.internal_force[node] = internal;
        grid.unit_pressure_force[node] = unit_pressure;
        // f_I^ext = sum_p phi_Ip m_p g + tractions, Eq. (23), N
        grid.force[node] = internal + pressure * unit_pressure + grid.mass[node] * gravity;
    });
}

void advance_grid(Grid& grid, double dt) {
    each(grid.mass.size(), [&](std::size_t node) {
        // a_I = f_I / m_I, Eq. (29), m/s^2; v_I^{n+1} = v_I^n + dt a_I, Eq. (30), m/s
        grid.velocity[node] = grid.mass[node] > 0.0 ? Vector(grid.velocity_before[node] + dt / grid.mass[node] * grid.force[node])
                                                    : Vector::Zero();
    });
}

void strain_increments(const Grid& grid, const Supports& supports, double dt, Points& points) {
    each(points.count(), [&](std::size_t p) {
        Matrix gradient_of_velocity = Matrix::Zero(); // L_p = sum_I v_I^{n+1} (x) grad phi_Ip, 1/s
        supports.each_node_of(p, [&](std::size_t node, double, const Vector& gradient) {
            gradient_of_velocity += grid.velocity[node] * gradient.transpose();
        });
        points.displacement_gradient_increment[p] = dt * gradient_of_velocity;
    });
}

PointUpdateBooks grid_to_points(const Grid& grid, const Supports& supports, const TransferRates& rates, double dt, Points& points) {
    const double alpha_pic = rates.pic, alpha_p = rates.particle_damping * dt, alpha_g = rates.grid_damping * dt; // -
    const auto sums = ordered_sums<9>(points.count(), [&](std::size_t p, std::array<double, 9>& sum) {
        Vector mapped = Vector::Zero(); // vbar_p = sum_I phi_Ip v_I^n, m/s
        Vector gained = Vector::Zero(); // dt a_p = sum_I phi_Ip (v_I^{n+1} - v_I^n), walls included, m/s
        supports.each_node_of(p, [&](std::size_t node, double phi, const Vector&) {
            mapped += phi * grid.velocity_before[node];
            gained += phi * (grid.velocity[node] - grid.velocity_before[node]);
        });
        // Eq. (34): v_p' = v_p + dt a_p + (alpha_PIC - alpha_g) vbar_p - (alpha_p + alpha_PIC) v_p, by cause, m/s
        const Vector old = points.velocity[p];
        const Vector by_pic = alpha_pic * (mapped - old), by_grid = -alpha_g * mapped, by_point = -alpha_p * old;
        const Vector velocity = old + gained + by_pic + by_grid + by_point;
        points.velocity[p] = velocity;
        // Eq. (35), with a minus before its (alpha_PIC - alpha_g) term: x_p' = x_p + dt (vbar_p + (v_p' - v_p) / 2), m
        points.position[p] += dt * (mapped + 0.5 * (velocity - old));

        const double m = points.mass[p];
        const Vector mean = 0.5 * (old + velocity); // with it, each cause's energy adds up to the change exactly
        sum[0] += 0.5 * m * velocity.squaredNorm();
        sum[1] += m * gained.dot(mean);
        sum[2] -= m * by_pic.dot(mean);
        sum[3] -= m * by_grid.dot(mean);
        sum[4] -= m * by_point.dot(mean);
        sum[5] += m * velocity[0];
        sum[6] += m * velocity[1];
        sum[7] += m * (by_grid[0] + by_point[0]);
        sum[8] += m * (by_grid[1] + by_point[1]);
    });
    return {sums[0], sums[1], sums[2], sums[3], sums[4], {sums[5], sums[6]}, {sums[7], sums[8]}};
}

void update_deformation(Points& points, std::int64_t step, double time, const std::function<std::string()>& hint) {
    for (std::size_t p = 0; p < points.count(); ++p) {
        // To first order the step maps a line element by I + dt L; where that turns the material inside out, the
        // velocity field is no longer one. Written so that a NaN is caught.
        const double ratio = (Matrix::Identity() + points.displacement_gradient_increment[p]).determinant();
        if (!(ratio > 0.0)) // numbers that are none were found before
            fail(ExitCode::failed,
                 fmt::format("point {} at ({:.4g}, {:.4g}) m is turned inside out in step {} at t = {:.6g} s: the step changes its volume by a factor {:.3g}",
                             p, points.position[p][0], points.position[p][1], step, time, ratio),
                 "use a smaller step, more damping, or look at the fields before it" + hint());
    }
    each(points.count(), [&](std::size_t p) {
        points.deformation[p] = exponential(points.displacement_gradient_increment[p]) * points.deformation[p];
        points.volume[p] = points.deformation[p].determinant() * points.initial_volume[p];
    });
}

} // namespace talik::driver
