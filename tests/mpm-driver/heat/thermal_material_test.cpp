#include "mpm-driver/heat/thermal_material.hpp"

#include <cmath>

#include "tests/mpm-driver/heat/small_heat.hpp"
#include "tests/support/catch.hpp"

using namespace talik;
using namespace talik::driver;
using namespace talik::driver::tests;

namespace {

// One of each curve.
std::vector<ThermalMaterial> all_curves() {
    std::vector<ThermalMaterial> out;
    ThermalMaterialSpec spec = soil_material();
    out.emplace_back(spec); // sharp
    spec.residual_temperature = -0.1;
    out.emplace_back(spec); // ramp
    spec.curve = "fine";
    out.emplace_back(spec);
    spec.water_content = 0.25; // less than the pores hold: a part freezes at T0 at once
    out.emplace_back(spec);
    spec.curve = "saturation";
    spec.residual_saturation = 0.05;
    out.emplace_back(spec);
    spec.saturation = 0.6;
    spec.ice_density = 917.0;
    out.emplace_back(spec);
    return out;
}

} // namespace

TEST_CASE("temperature and ice follow from the enthalpy exactly, for every curve", "[eq9]") {
    for (const ThermalMaterial& m : all_curves()) {
        CAPTURE(m.spec().curve);
        for (double t = -20.0; t < 10.0; t += 0.0371) {
            const ThermalState back = m.state_of(m.enthalpy({t, 0.0}));
            // Rounding of H (1.4e8 J/m^3 * 2e-16 / 2e6 J/(m^3 K) = 1e-14 K), a hundredfold
            REQUIRE(std::abs(back.temperature - t) < 1e-12 * (1.0 + std::abs(t)));
        }
        const double jump = m.enthalpy({m.curve().top(), 0.0}) - m.enthalpy({m.curve().top(), 1.0});
        if (jump > 0.0) { // a third of the jump is frozen
            const ThermalState part = m.state_of(m.enthalpy({m.curve().top(), 0.0}) - jump / 3.0);
            CHECK(part.temperature == m.curve().top());
            CHECK(part.frozen == Approx(1.0 / 3.0).epsilon(1e-9));
        }
    }
}

TEST_CASE("the equivalent heat capacity is the slope of the enthalpy", "[eqA2]") {
    for (const ThermalMaterial& m : all_curves())
        for (double t : {-7.3, -0.73, -0.031, 3.0}) {
            const double d = 1e-5; // K: the difference's rounding is 1e8 * 1e-16 / 1e-5 = 1e-3 of 1e6
            CHECK(m.capacity_at(t) == Approx((m.enthalpy({t + d, 0.0}) - m.enthalpy({t - d, 0.0})) / (2 * d)).epsilon(1e-5));
        }
}

TEST_CASE("heat capacity and conductivity of the mixture are those of the published cases", "[eq1][eq2]") {
    ThermalMaterialSpec th2;
    th2.porosity = 0.37;
    th2.grain_heat_capacity = 835.0;
    th2.grain_conductivity = 9.0;
    th2.water_conductivity = 0.6;
    CHECK(ThermalMaterial(th2).conductivity(0.0) == Approx(3.304).margin(5e-4)); // thawed, geometric
    th2.conductivity_mean = "arithmetic";
    CHECK(ThermalMaterial(th2).conductivity(0.0) == Approx(5.892).margin(5e-4));
    th2.conductivity_mean = "harmonic";
    CHECK(ThermalMaterial(th2).conductivity(0.0) == Approx(1.0 / (0.63 / 9.0 + 0.37 / 0.6)));
    CHECK(ThermalMaterial(th2).thawed_capacity() == Approx(0.63 * 2650 * 835 + 0.37 * 1000 * 4180));
    th2.saturation = 0.5;
    CHECK(ThermalMaterial(th2).conductivity(0.0) == Approx(1.0 / (0.63 / 9.0 + 0.185 / 0.6 + 0.185 / 0.025)));
}

TEST_CASE("water and ice keep their mass together: where ice fills the pores, their volume", "[eq3]") {
    ThermalMaterialSpec spec = soil_material();
    spec.ice_density = 917.0;
    const ThermalMaterial mass(spec);
    spec.frozen_water = "fills pores";
    const ThermalMaterial pores(spec);
    for (double f : {0.0, 0.3, 1.0}) {
        CHECK(1000.0 * mass.water_volume(f) + 917.0 * mass.ice_volume(f) == Approx(430.0));
        CHECK(pores.water_volume(f) + pores.ice_volume(f) == Approx(0.43));
    }
}

TEST_CASE("the heat potential's slope is the conductivity", "[eq10]") {
    for (const ThermalMaterial& m : all_curves())
        for (double t : {-40.0, -7.3, -0.73, -0.031, 3.0}) {
            const double d = 1e-6;
            CHECK((m.potential(t + d) - m.potential(t - d)) / (2 * d) == Approx(m.conductivity_at(t)).epsilon(1e-6));
        }
}

TEST_CASE("materials that share a node have one temperature, and their enthalpies add up", "[eq9]") {
    const std::vector<ThermalMaterial> all = all_curves();
    const double shares[6] = {0.1, 0.3, 0.2, 0.15, 0.2, 0.05};
    for (double h = -2.5e8; h < 3e7; h += 1.7e6) {
        const ThermalState state = state_of_mixture(all, shares, h);
        double sum = 0.0;
        for (std::size_t m = 0; m < all.size(); ++m) sum += shares[m] * all[m].enthalpy(state);
        REQUIRE(sum == Approx(h).margin(1e-6)); // 1e-14 of the latent heat
    }
}

TEST_CASE("data that would give negative ice at T0 are told, with the value that fits", "[eq4]") {
    ThermalMaterialSpec spec = soil_material();
    spec.porosity = 0.427;
    spec.curve = "fine";
    CHECK(ThermalMaterial(spec).warning() == "");
    spec.water_content = 0.285;
    CHECK(ThermalMaterial(spec).warning().find("theta_s = -0.00576 at T0 (set to 0 there); the consistent w0 is 0.2812") != std::string::npos);
}

TEST_CASE("ice that takes more room than its water takes it from the air first, and opened ground is filled by it", "[eq2][eq3]") {
    ThermalMaterialSpec spec = soil_material();
    spec.porosity = 0.45;
    spec.saturation = 0.6;
    spec.ice_density = 917.0;
    spec.conductivity_mean = "arithmetic";
    const ThermalMaterial material(spec);
    const double ice = 0.27 * 1000.0 / 917.0, air = 0.45 - ice; // of the volume; all frozen
    CHECK(material.conductivity(1.0) == Approx(0.55 * spec.grain_conductivity + ice * spec.ice_conductivity + air * spec.air_conductivity).epsilon(1e-12));
    // Saturated ground, swollen by just what its water grows by: no air in it.
    spec.saturation = 1.0;
    spec.ice_density = 1000.0;
    const ThermalMaterial wet(spec);
    const double grown = 1.09 * 0.45, all = 0.55 + grown;
    CHECK(wet.conductivity(1.0, all, 0.09) == Approx((0.55 * spec.grain_conductivity + grown * spec.ice_conductivity) / all).epsilon(1e-12));
}
