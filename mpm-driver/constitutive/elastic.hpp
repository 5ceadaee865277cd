#pragma once
// Linear elasticity in plane strain, for tests and for bodies without RVEs. Hooke's law between the increment's symmetric
// part and the Kirchhoff stress tau = J sigma; the increment's rotation turns it. With tau the work per initial volume is
// tau : D dt, and 1/2 tau : C^-1 : tau is an energy of the state, however large the strain.
#include <string>
#include <vector>

#include "mpm-driver/app/scene.hpp"
#include "mpm-driver/constitutive/law.hpp"

namespace talik::driver {

class ElasticLaw : public Law {
public:
    explicit ElasticLaw(const ElasticSpec& spec);

    std::string name() const override { return "elastic"; }
    // The bodies' initial stress is already in the points: it is taken as it is.
    void begin(std::span<const std::uint32_t> ids, const Points& points, LawAnswer initial) override;
    void submit(const LawRequest& request, LawAnswer answer) override;
    void collect() override {}

    double p_wave_modulus() const { return lame_ + 2.0 * shear_; } // M = lambda + 2 G, Pa

    // The energy 1/2 sigma : C^-1 : sigma of a Kirchhoff stress, J per m^3 of initial volume
    // (out-of-plane stress nu (sxx + syy) included).
    double energy_density(const Stress& stress) const;

private:
    double shear_, lame_, poisson_;
};

} // namespace talik::driver
