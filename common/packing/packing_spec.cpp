#include "common/packing/packing_spec.hpp"

#include <cmath>

#include "common/base/error.hpp"

namespace talik {

std::vector<double> K0Spec::stresses() const {
    ensure(stress_min && stress_max && levels >= 1);
    std::vector<double> all;
    for (int k = 0; k < levels; ++k) {
        const double part = levels > 1 ? static_cast<double>(k) / (levels - 1) : 1.0;
        all.push_back(spacing == "geometric" ? *stress_min * std::pow(*stress_max / *stress_min, part) : *stress_min + part * (*stress_max - *stress_min));
    }
    return all;
}

} // namespace talik
