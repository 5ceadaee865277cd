// Fronts against exact solutions of Stefan and Neumann.
#include <cmath>

#include "tests/mpm-driver/heat/small_heat.hpp"
#include "tests/support/catch.hpp"

using namespace talik;
using namespace talik::driver;
using namespace talik::driver::tests;

namespace {

constexpr double pi = 3.14159265358979323846;

// A root of a falling or rising function between two signs, by halving.
template <class F>
double root(F&& f, double low, double high) {
    const bool rising = f(high) > f(low);
    for (int i = 0; i < 200; ++i) {
        const double middle = 0.5 * (low + high);
        ((f(middle) > 0.0) == rising ? high : low) = middle;
    }
    return 0.5 * (low + high);
}

// X / sqrt(t) of one-phase melting (Neumann): sqrt(pi) lambda e^{lambda^2} erf(lambda) = Ste.
double one_phase(double ste, double diffusivity) {
    return 2.0 * std::sqrt(diffusivity) * root([&](double l) { return std::sqrt(pi) * l * std::exp(l * l) * std::erf(l) - ste; }, 1e-6, 3.0);
}

// X / sqrt(t) of two-phase freezing of a half space at +t1 from a wall at -t1, by the balance of heat at the front.
double two_phase(const ThermalMaterial& m, double t1, double latent) {
    const double kf = m.conductivity(1.0), ku = m.conductivity(0.0), af = kf / m.capacity_at(-50.0), au = ku / m.thawed_capacity();
    return 2.0 * root([&](double b) {
        return kf * t1 * std::exp(-b * b / af) / (std::sqrt(pi * af) * std::erf(b / std::sqrt(af)))
             - ku * t1 * std::exp(-b * b / au) / (std::sqrt(pi * au) * std::erfc(b / std::sqrt(au))) - latent * b;
    }, 1e-7, 1e-2);
}

double thawed_length(const Simulation& s, double width) { return s.heat()->water_volume(s.points()) / width; } // Xeq, m, of n = 1

} // namespace

TEST_CASE("a sharp front thaws ground as Neumann's exact solution says, for both Stefan numbers, with 100 cells", "[eq50][eq43][many-steps]") {
    for (const double ste : {0.1, 1.0}) {
        Scene scene = heat_scene(unit_material(ste), {2.0, 0.02}, 0.02, 0.0);
        scene.bodies[0].frozen = true;
        scene.heat->boundaries = {held_side("left", 1.0)};
        auto simulation = start_heat(scene);
        const double exact = one_phase(ste, 0.1 / ste);
        double worst = 0.0;
        while (simulation->time() < 10.0) {
            simulation->step(simulation->next_step());
            if (simulation->time() > 2.5) // 31 cells and more: the front advances node by node, which shows in the first cells
                worst = std::max(worst, std::abs(thawed_length(*simulation, 0.02) / (exact * std::sqrt(simulation->time())) - 1.0));
        }
        WARN("Stefan, Ste " << ste << ": front off by at most " << worst << " of the exact one");
        CHECK(worst < 0.002); // the project's bound
        CHECK(balance(*simulation) < 1e-12);
        CHECK(simulation->heat()->books().overshoot() <= 1e-9); // rounding of the inversion
    }
}

TEST_CASE("the quasi-steady front of Eq. (50) is the limit of small Stefan numbers", "[eq50]") {
    Scene scene = heat_scene(unit_material(0.01), {2.0, 0.05}, 0.05, 0.0);
    scene.bodies[0].frozen = true;
    scene.heat->boundaries = {held_side("left", 1.0)};
    auto simulation = start_heat(scene);
    while (simulation->time() < 5.0) simulation->step(simulation->next_step());
    // X = sqrt(2 k dT t / (L rho n)) = 1 m after 5 s; sensible heat takes Ste/6 = 0.17 % of it, the grid 0.2 %
    CHECK(thawed_length(*simulation, 0.05) == Approx(std::sqrt(2.0 * 0.1 * 5.0)).epsilon(0.004));
}

TEST_CASE("water and soil freeze from a cold wall as the two-phase solution of Neumann says", "[eq10][eq20][eq29][many-steps]") {
    ThermalMaterialSpec water = soil_material();
    water.porosity = 1.0;
    for (const ThermalMaterialSpec& spec : {water, soil_material()}) {
        const double h = 2e-3 * (spec.porosity < 1.0 ? 1.6 : 1.0);
        Scene scene = heat_scene(spec, {250 * h, h}, h, 5.0);
        scene.heat->boundaries = {held_side("left", -5.0)};
        auto simulation = start_heat(scene);
        const ThermalMaterial material(spec);
        const double exact = two_phase(material, 5.0, spec.porosity * 333e6);
        if (spec.porosity == 1.0) CHECK(exact == Approx(2.40700718e-4).epsilon(1e-8)); // the published figures
        else CHECK(exact == Approx(3.70268452e-4).epsilon(1e-8));
        double worst = 0.0;
        while (simulation->time() < 12 * 3600.0) {
            simulation->step(simulation->next_step());
            if (simulation->time() < 6 * 3600.0) continue; // from 17 cells on
            const double front = simulation->heat()->ice_volume(simulation->points()) / (spec.porosity * h);
            worst = std::max(worst, std::abs(front / (exact * std::sqrt(simulation->time())) - 1.0));
        }
        WARN("two-phase Neumann, n = " << spec.porosity << ": front off by at most " << worst);
        CHECK(worst < 0.005); // the project's bound
        CHECK(balance(*simulation) < 1e-12);
        CHECK(simulation->heat()->books().overshoot() < 1e-9);
    }
}

TEST_CASE("the capacity form loses latent heat where steps jump over the ramp: the enthalpy form never", "[eqA2][eq36][eq37]") {
    const auto error = [](const std::string& form, double stability) {
        ThermalMaterialSpec spec = unit_material();
        spec.residual_temperature = -0.1;
        Scene scene = heat_scene(spec, {2.0, 0.05}, 0.05, 1.0);
        scene.heat->formulation = form;
        scene.heat->stability = stability;
        scene.heat->boundaries = {held_side("left", -1.0)};
        auto simulation = start_heat(scene);
        while (simulation->time() < 1.0) simulation->step(simulation->next_step());
        const HeatSolver& heat = *simulation->heat();
        return std::abs(heat.content(simulation->points()) - heat.books().initial() - heat.books().entered()) / std::abs(heat.books().entered());
    };
    const double coarse = error("capacity", 4.0), fine = error("capacity", 100.0);
    WARN("freezing with a ramp of 0.1 K: the capacity form misses " << coarse << " of the boundary's heat at b = 4, " << fine << " at b = 100");
    CHECK(coarse > 0.005);
    CHECK(fine < 0.5 * coarse); // it vanishes with the step
    CHECK(error("enthalpy", 4.0) < 1e-12);
}
