#pragma once
// The largest stable step of the mechanics. Eq. (42): no signal may cross a cell in one step. It is not enough at a free
// surface, where nodes of little mass swing against the outermost points: "auto" heeds that limit, too.
#include <cstdint>
#include <string>

#include "mpm-driver/grid/grid.hpp"
#include "mpm-driver/points/points.hpp"

namespace talik::driver {

struct StepLimit {
    double step = 0.0;           // Eq. (42), s: a larger one is refused
    double safe_step = 0.0;      // s: never unstable, wherever points lie in their cells; a fixed step beyond it is warned of
    double surface_step = 0.0;   // 2 sqrt(h l_p) / (c + |v|), s: the steps of "auto" are cut at safety times this, too
    std::uint32_t point = 0;     // that sets it
    double wave_speed = 0.0;     // c = sqrt(M / rho) there, m/s
    double speed = 0.0;          // |v| there, m/s
};

// half_size: l_p of the points of each body, m.
StepLimit mechanical_step_limit(const Grid& grid, const Points& points, const std::vector<double>& half_size);

// "0.00123 s (wave speed 80.1 m/s, material speed 0.5 m/s at point 17, cell 0.1 m)"
std::string describe(const StepLimit& limit, double cell);

} // namespace talik::driver
