#include "mpm-driver/mechanics/step_limit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "mpm-driver/points/soundness.hpp"

namespace talik::driver {

StepLimit mechanical_step_limit(const Grid& grid, const Points& points, const std::vector<double>& half_size) {
    StepLimit limit;
    limit.step = limit.surface_step = limit.safe_step = std::numeric_limits<double>::infinity();
    double numbers = 0.0; // 0, or not a number where a point holds one that is none
    for (std::size_t p = 0; p < points.count(); ++p) {
        // An RVE that has opened may close again within a step: it counts with at least a quarter of its stiffness at the
        // start, half its wave speed.
        const double modulus = std::max(points.p_wave_modulus[p], 0.25 * points.initial_p_wave_modulus[p]);
        const double wave_speed = std::sqrt(modulus / points.density(p)); // c = sqrt(M/rho), m/s
        const double speed = points.velocity[p].norm();
        const double step = grid.cell() / (wave_speed + speed); // Eq. (42): dt <= h / (c + |v|), s
        // A node at a free surface that a point reaches by o has the mass m_p o^2/(4 h l_p) and the gradient o/(2 h l_p):
        // whatever o, it can swing against that point at omega^2 = c^2/(h l_p), so that dt <= 2/omega = 2 sqrt(h l_p)/c.
        const double half = half_size[points.body[p]];
        const double surface_step = 2.0 * std::sqrt(grid.cell() * half) / (wave_speed + speed);
        limit.surface_step = std::min(limit.surface_step, surface_step);
        // No mode of the grid is faster than the fastest of a single point with its share phi m_p of the nodal masses (Irons'
        // bound): omega^2 <= c^2 sum_I |grad phi_I|^2 / phi_I, which for uGIMP is at most 2/(l_p h) + 1/(h (h - l_p)) per axis.
        const double per_axis = 2.0 / (half * grid.cell()) + 1.0 / (grid.cell() * (grid.cell() - half)); // 1/m^2
        limit.safe_step = std::min(limit.safe_step, 2.0 / (std::sqrt(Dim * per_axis) * (wave_speed + speed)));
        numbers += poison(points.p_wave_modulus[p]) + poison(speed) + poison(points.volume[p]) + poison(points.position[p][0] + points.position[p][1]);
        if (!points.enthalpy.empty()) numbers += poison(points.enthalpy[p]); // heat may not look at it for many steps
        if (step < limit.step) {
            limit.step = step;
            limit.point = static_cast<std::uint32_t>(p);
            limit.wave_speed = wave_speed;
            limit.speed = speed;
        }
    }
    if (numbers != 0.0) limit.step = std::numeric_limits<double>::quiet_NaN();
    return limit;
}

std::string describe(const StepLimit& limit, double cell) {
    return fmt::format("{:.4g} s (Eq. 42: wave speed {:.4g} m/s, material speed {:.3g} m/s at point {}, cell {:.4g} m)",
                       limit.step, limit.wave_speed, limit.speed, limit.point, cell);
}

} // namespace talik::driver
