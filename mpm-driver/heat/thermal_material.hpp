#pragma once
// What a soil does with heat: enthalpy of a temperature and back, Eqs. (1), (9), conductivity of the mixture, Eq. (2).
// Everything refers to a cubic metre of the initial volume, so that the masses of grains and water stay with a point.
#include <string>
#include <vector>

#include "mpm-driver/app/heat_scene.hpp"
#include "mpm-driver/heat/freezing_curve.hpp"

namespace talik::driver {

// Temperature alone does not tell the state of a sharp front: at its top temperature any part of the jump may be frozen.
struct ThermalState {
    double temperature = 0.0; // degrees C
    double frozen = 0.0;      // share of the curve's jump that is frozen, in [0, 1]; counts at the top temperature only
};

class ThermalMaterial {
public:
    explicit ThermalMaterial(const ThermalMaterialSpec& spec);

    const std::string& name() const { return spec_.name; }
    const ThermalMaterialSpec& spec() const { return spec_; }
    const FreezingCurve& curve() const { return curve_; }

    // H(T) = integral of rho c dT - L rho_s theta_s, J/m^3; zero at T0, thawed. At the top: thawed (0+) less what is frozen.
    double enthalpy(const ThermalState& state) const;
    ThermalState state_of(double enthalpy) const; // the exact inverse
    // At rest at a temperature: just at the top, thawed. A start "frozen" must lie below it.
    double frozen_fraction(const ThermalState& state) const; // f, -
    double largest_step(double cell) const;                  // s, stable: Eq. (43) with b = 2
    double latent() const { return latent_; }                // L rho_s theta_s of all its ice, J/m^3
    double capacity_at(double temperature) const;            // dH/dT, J/(m^3 K): sensible and latent, Eq. (A2)

    double thawed_capacity() const { return thawed_capacity_; }  // rho c, J/(m^3 K), Eq. (1)
    double least_capacity() const;                               // sensible: of the thawed or the most frozen state
    double water_volume(double frozen_fraction) const { return water_ * (1.0 - frozen_fraction); } // theta_f, -
    double ice_volume(double frozen_fraction) const { return ice_ * frozen_fraction; }             // theta_s, -
    double ice_saturation(double frozen_fraction) const;         // theta_s / (theta_s + theta_f), -

    // k of the mixture, W/(m K); stretch: present over initial volume (what opens is air); expansion: of water as it freezes, relative,
    // where that opens the ground.
    double conductivity(double frozen_fraction, double stretch = 1.0, double expansion = 0.0) const;
    double conductivity_at(double temperature) const;
    double most_conductivity() const;                            // over all temperatures
    // Theta(T) = integral of k dT from the top, W/m: heat flows as -grad Theta, exactly, however sharp the front.
    double potential(double temperature) const;
    Matrix anisotropy() const;                                   // -
    double largest_anisotropy() const;                           // its largest eigenvalue

    // What the user should know: inconsistent data. Empty = nothing.
    std::string warning() const;

private:
    ThermalState state_in_lines(double enthalpy) const;
    ThermalState state_by_newton(double enthalpy) const;
    void tabulate();

    ThermalMaterialSpec spec_;
    FreezingCurve curve_;
    double grains_ = 0.0, water_ = 0.0, ice_ = 0.0, air_ = 0.0; // volumes: of all water when liquid, of all when frozen
    double thawed_capacity_ = 0.0;  // J/(m^3 K)
    double frozen_change_ = 0.0;    // d(rho c)/df, J/(m^3 K): usually negative
    double latent_ = 0.0;           // L rho_s theta_s at f = 1, J/m^3
    std::vector<double> given_temperature_, given_conductivity_; // of a conductivity by table
    // Of the curve, from the top down: temperature, H just there (at the top: all of the jump frozen), Theta and k.
    std::vector<double> table_temperature_, table_enthalpy_, table_potential_, table_conductivity_;
};

// The common state of several materials that share a node: shares[m] of the volume, sum 1. Enthalpy is theirs together.
ThermalState state_of_mixture(const std::vector<ThermalMaterial>& materials, const double* shares, double enthalpy);

} // namespace talik::driver
