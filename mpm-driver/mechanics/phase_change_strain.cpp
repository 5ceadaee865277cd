#include "mpm-driver/mechanics/phase_change_strain.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/error.hpp"
#include "mpm-driver/grid/parallel.hpp"

namespace talik::driver {

PhaseChangeStrain::PhaseChangeStrain(const Scene& scene, const Points& points)
    : expansion_(scene.phase_change_strain->expansion), strain_(points.count(), 0.0), increment_(points.count(), Matrix::Zero()), volume_(points.volume) {
    for (const BodySpec& body : scene.bodies) {
        const auto& materials = scene.heat->materials;
        const auto material = std::find_if(materials.begin(), materials.end(), [&](const ThermalMaterialSpec& m) { return m.name == body.material; });
        ensure(material != materials.end());
        const double ratio = material->frozen_water == "fills pores" ? 1.0 : material->water_density / material->ice_density;
        pores_.push_back({material->porosity, material->saturation, ratio});
    }
    for (std::size_t p = 0; p < points.count(); ++p) start_.push_back(volume_strain(points.body[p], points.ice_saturation[p]));
}

double PhaseChangeStrain::volume_strain(int body, double ice_saturation) const {
    const Pores& pores = pores_[static_cast<std::size_t>(body)];
    const double frozen = ice_saturation / (ice_saturation + pores.density_ratio * (1.0 - ice_saturation)); // f, -
    const double water = pores.porosity * pores.saturation * (1.0 + expansion_ * frozen);                   // n S (1 + e f), -
    return std::log(1.0 + std::max(0.0, water - pores.porosity));
}

void PhaseChangeStrain::subtract(const Points& points) {
    each(points.count(), [&](std::size_t p) {
        const double now = volume_strain(points.body[p], points.ice_saturation[p]) - start_[p];
        increment_[p] = points.displacement_gradient_increment[p] - 0.5 * (now - strain_[p]) * Matrix::Identity();
        strain_[p] = now;
    });
}

void PhaseChangeStrain::update_volumes(const Points& points) {
    each(points.count(), [&](std::size_t p) { volume_[p] = points.volume[p] * std::exp(-strain_[p]); });
}

std::vector<StateColumn> PhaseChangeStrain::state() {
    return {{"points/phase_change_strain", "-", "volume strain by freezing since the start", {""}, strain_.data(), strain_.size()},
            {"points/phase_change_start", "-", "the same strain when the run began, against all water liquid", {""}, start_.data(), start_.size()}};
}

} // namespace talik::driver
