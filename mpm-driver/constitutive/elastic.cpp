#include "mpm-driver/constitutive/elastic.hpp"

#include <cmath>

#include "common/base/error.hpp"
#include "mpm-driver/grid/parallel.hpp"
#include "mpm-driver/points/kinematics.hpp"

namespace talik::driver {
namespace {

Stress rotated(const Stress& s, double angle) { // R s R^T
    const double c = std::cos(angle), d = std::sin(angle);
    return {c * c * s[0] + d * d * s[1] - 2.0 * c * d * s[2], d * d * s[0] + c * c * s[1] + 2.0 * c * d * s[2],
            c * d * (s[0] - s[1]) + (c * c - d * d) * s[2]};
}

} // namespace

ElasticLaw::ElasticLaw(const ElasticSpec& spec) : poisson_(spec.poisson) {
    require(spec.young > 0.0, "elastic.young is not positive", "give Young's modulus as a stress above 0");
    require(spec.poisson > -1.0 && spec.poisson < 0.5, "elastic.poisson is not between -1 and 0.5",
            "give a Poisson's ratio below 0.5");
    shear_ = 0.5 * spec.young / (1.0 + spec.poisson);                                          // G, Pa
    lame_ = spec.young * spec.poisson / ((1.0 + spec.poisson) * (1.0 - 2.0 * spec.poisson));   // lambda, Pa
}

double ElasticLaw::energy_density(const Stress& s) const {
    // 1/(4G) (s:s - nu (tr s)^2), s in the plane, plane strain.
    const double trace = s[0] + s[1];
    return (s[0] * s[0] + s[1] * s[1] + 2.0 * s[2] * s[2] - poisson_ * trace * trace) / (4.0 * shear_);
}

void ElasticLaw::begin(std::span<const std::uint32_t> ids, const Points& points, LawAnswer initial) {
    for (const std::uint32_t p : ids) {
        initial.p_wave_modulus[p] = p_wave_modulus();
        const double j = points.volume[p] / points.initial_volume[p]; // J, -
        initial.energy[p].stored = points.initial_volume[p] * energy_density(j * points.stress[p]);
    }
}

void ElasticLaw::submit(const LawRequest& request, LawAnswer answer) {
    each(request.ids.size(), [&](std::size_t k) {
        const std::uint32_t p = request.ids[k];
        const Matrix& increment = request.displacement_gradient_increment[p];
        const Matrix strain = 0.5 * (increment + increment.transpose());
        const double initial_volume = request.initial_volume[p];
        const double j = request.volume[p] / initial_volume, j_after = j * std::exp(strain.trace()); // J, -
        // Half the turn, the strain, half the turn: second order in the increment, and a pure rotation only turns the stress.
        const double half_turn = 0.5 * polar_angle(exponential(increment));
        const Stress before = rotated(j * answer.stress[p], half_turn);
        const double pressure_part = lame_ * strain.trace();
        // Hooke's law in plane strain: dtau = lambda tr(de) I + 2 G de, Pa
        const Stress after = before + Stress(pressure_part + 2.0 * shear_ * strain(0, 0),
                                             pressure_part + 2.0 * shear_ * strain(1, 1), 2.0 * shear_ * strain(0, 1));
        answer.energy[p].stored = initial_volume * energy_density(after); // J
        answer.p_wave_modulus[p] = p_wave_modulus() / j_after;
        answer.stress[p] = rotated(after, half_turn) / j_after;
    });
}

} // namespace talik::driver
