#pragma once
// The two clocks: a macro step dt is run as n equal DEM sub-steps of dt/n, so that both show the same time.
#include <algorithm>
#include <cmath>

#include "common/base/error.hpp"
#include "common/physics/rve_parameters.hpp"

namespace talik {

// n = ceil(dt / dt_DEM), dt_DEM the largest sub-step, s; unless the scene fixes n. Not one more for the last bit of a
// quotient such as 1e-3 / 1e-5.
inline int substeps_of(const RveParameters& parameters, double time_increment) {
    if (parameters.substeps > 0) return parameters.substeps;
    const double count = std::ceil(time_increment / parameters.time_step * (1.0 - 1e-9));
    require(count <= 1e9, "too many DEM sub-steps in one macro step: its length over rve.time_step is above 1e9", "give a larger rve.time_step"); // an int holds no more
    return std::max(1, static_cast<int>(count));
}

// By what local damping alpha shortens the largest stable DEM step, 2/omega_max of the contact network: a force that brakes counts
// 1 + alpha times, as a spring so much stiffer would. At 2/omega_max itself a heap damped by 0.9 never comes to rest (tests/hard).
inline double shortening_by_damping(double damping) { return std::sqrt(1.0 + damping); } // -

} // namespace talik
