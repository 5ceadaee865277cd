#include "mpm-driver/mechanics/step_limit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace talik::driver {

StepLimit mechanical_step_limit(const Grid& grid, const Points& points, const std::vector<double>& half_size) {
    StepLimit limit;
    limit.step = limit.surface_step = std::numeric_limits<double>::infinity();
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
        if (step < limit.step) {
            limit.step = step;
            limit.point = static_cast<std::uint32_t>(p);
            limit.wave_speed = wave_speed;
            limit.speed = speed;
        }
    }
    return limit;
}

std::string describe(const StepLimit& limit, double cell) {
    return fmt::format("{:.4g} s (Eq. 42: wave speed {:.4g} m/s, material speed {:.3g} m/s at point {}, cell {:.4g} m)",
                       limit.step, limit.wave_speed, limit.speed, limit.point, cell);
}

} // namespace talik::driver
