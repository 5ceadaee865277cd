#pragma once
// Ice takes more room than the water it came from: ground whose pores are full swells on freezing. An effect of its own.
// The swelling is no strain of the skeleton: laws are asked for the increment without it, so that ground which may swell
// carries no stress by it, and ground which may not is compressed by as much.
#include <vector>

#include "mpm-driver/app/scene.hpp"
#include "mpm-driver/points/points.hpp"

namespace talik::driver {

class PhaseChangeStrain {
public:
    PhaseChangeStrain(const Scene& scene, const Points& points);

    // eps_v = ln(1 + max(0, n S (1 + e f) - n)), -: volume of the ground over that with all water liquid. n the porosity, S the
    // saturation of the pores with water and ice, e the relative expansion on freezing, f the part of the water's mass that is
    // frozen, f = S_i / (S_i + (rho_f / rho_s)(1 - S_i)) of the ice saturation S_i = theta_s / (theta_s + theta_f). Air in the
    // pores gives way first.
    double volume_strain(int body, double ice_saturation) const;

    // Before the laws are asked: dt grad v - 1/2 d eps_v I of each point. Half along each axis: plane strain leaves no other way.
    void subtract(const Points& points);
    // V exp(-eps_v), m^3: the volumes that belong to these increments; from the points' present ones.
    void update_volumes(const Points& points);

    const std::vector<Matrix>& increments() const { return increment_; }
    const std::vector<double>& volumes() const { return volume_; }

    std::vector<StateColumn> state();

private:
    struct Pores {
        double porosity, saturation, density_ratio; // n, S, rho_f / rho_s, -
    };
    double expansion_; // e, -
    std::vector<Pores> pores_;     // by body
    std::vector<double> start_;    // eps_v at the start, by point
    std::vector<double> strain_;   // eps_v since the start, by point
    std::vector<Matrix> increment_;
    std::vector<double> volume_;   // m^3
};

} // namespace talik::driver
