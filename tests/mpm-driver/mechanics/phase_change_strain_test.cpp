// Ground that freezes swells, and is compressed where it may not.
#include "mpm-driver/mechanics/phase_change_strain.hpp"

#include <cmath>

#include "tests/mpm-driver/mechanics/small_scenes.hpp"
#include "tests/support/catch.hpp"

using namespace talik;
using namespace talik::driver;
using namespace talik::driver::tests;

namespace {

constexpr double porosity = 0.4, expansion = 0.09, duration = 0.5; // -, -, s

// A block of saturated soil at 0.5 degrees above freezing, cooled through all of its curve by a uniform sink of heat.
Scene freezing_block() {
    Scene scene = elastic_scene(box({0.0, 0.0}, {0.2, 0.2}), {-0.1, -0.1}, {0.4, 0.4});
    scene.bodies[0].material = "soil";
    scene.bodies[0].temperature = 0.5;
    HeatSpec heat;
    ThermalMaterialSpec soil;
    soil.name = "soil";
    soil.porosity = porosity;
    soil.grain_heat_capacity = 800.0;
    soil.grain_conductivity = 3.0;
    soil.residual_temperature = -1.0;
    heat.materials = {soil};
    HeatSourceSpec sink;
    sink.name = "sink";
    // Latent heat 333e3 J/kg of 400 kg/m^3 and about 3 MJ/(m^3 K) over 2 K: 1.39e8 J/m^3; a tenth more in `duration`.
    heat.time_scale = 1e7; // so that heat's step, 2500 s at this cell, is not longer than the mechanical one
    sink.value.constant = -1.5e8 / (duration * heat.time_scale);
    heat.sources = {sink};
    scene.heat = heat;
    scene.phase_change_strain = PhaseChangeStrainSpec{expansion};
    scene.stages[0].duration = duration;
    scene.stages[0].particle_damping = 100.0;
    return scene;
}

void run(Simulation& simulation) {
    while (!simulation.finished()) take_steps(simulation, 1);
    for (const double saturation : simulation.points().ice_saturation) REQUIRE(saturation > 1.0 - 1e-9); // rounding of the map to the nodes
}

const double swelling = std::log(1.0 + porosity * expansion); // eps_v of all water frozen

} // namespace

TEST_CASE("water fills its pores, ice more than that: the strain is n e of the saturated soil, and air gives way first", "[phase_change_strain]") {
    Scene scene = freezing_block();
    auto& soil = scene.heat->materials[0];
    Points points;
    CHECK(PhaseChangeStrain(scene, points).volume_strain(0, 0.0) == 0.0);
    CHECK(PhaseChangeStrain(scene, points).volume_strain(0, 1.0) == Approx(swelling));
    CHECK(PhaseChangeStrain(scene, points).volume_strain(0, 0.5) == Approx(std::log(1.0 + 0.5 * porosity * expansion)));
    soil.saturation = 0.95; // 1.09 of it is 1.0355 of the pores
    CHECK(PhaseChangeStrain(scene, points).volume_strain(0, 1.0) == Approx(std::log(1.0 + 0.0355 * porosity)));
    soil.saturation = 0.9; // 0.981 of the pores: nothing to swell
    CHECK(PhaseChangeStrain(scene, points).volume_strain(0, 1.0) == 0.0);
    soil.saturation = 1.0;
    soil.ice_density = 1000.0 / 1.09; // half of the volume of ice and water is less than half of the mass
    CHECK(PhaseChangeStrain(scene, points).volume_strain(0, 0.5) == Approx(std::log(1.0 + porosity * expansion / 2.09)));
}

TEST_CASE("ground that may swell does so by the volume of the ice, alike along both axes, and carries no stress by it", "[phase_change_strain]") {
    auto simulation = start(freezing_block());
    run(*simulation);
    const Points& points = simulation->points();
    double volume = 0.0;
    for (const double v : points.volume) volume += v;
    CHECK(std::log(volume / 0.04) == Approx(swelling).epsilon(1e-4)); // what still swings at 100 1/s after 0.5 s
    for (std::size_t p = 0; p < points.count(); ++p) CHECK(std::abs(std::log(points.deformation[p](0, 0)) - 0.5 * swelling) < 0.02 * swelling); // edges lag by uGIMP's gaps
    CHECK(largest_stress(*simulation) < 0.01 * young * swelling); // confined it would be 1.4 young * swelling
}

TEST_CASE("ground that may not swell is compressed by as much, and the ledger books the work of the ice", "[phase_change_strain][ledger]") {
    Scene scene = freezing_block();
    scene.walls = {wall("left", 0.0), wall("right", 0.2), wall("bottom", 0.0), wall("top", 0.2)};
    auto simulation = start(scene);
    run(*simulation);
    const Points& points = simulation->points();
    // sigma = (lambda + G) tr(eps) in the plane where both strains are equal, as Kirchhoff stress on the volume without ice:
    // tau = -(lambda + G) eps_v, sigma = tau V_0 / V_mechanical = tau exp(eps_v).
    const double shear = young / 2.4, lame = p_wave - 2.0 * shear;
    const double expected = -(lame + shear) * swelling * std::exp(swelling);
    for (std::size_t p = 0; p < points.count(); ++p) {
        CHECK(points.volume[p] == Approx(0.0025).epsilon(1e-6)); // held on all sides
        CHECK(points.stress[p][0] == Approx(expected).epsilon(1e-3));
        CHECK(points.stress[p][1] == Approx(expected).epsilon(1e-3));
    }
    const Ledger& ledger = simulation->ledger();
    CHECK(ledger.phase_change < 0.0);                     // it feeds the ground
    CHECK(-ledger.phase_change == Approx(ledger.law_stored).epsilon(0.05)); // all of it is stored; the stress acts on volumes 3.5 % apart
    CHECK(ledger.energy_error() < 1e-3);                  // second order in the step
}

TEST_CASE("a restart in the middle of freezing goes on with the same bits", "[phase_change_strain][restart]") {
    auto through = start(freezing_block()), restarted = start(freezing_block());
    take_steps(*through, 1000); // 0.2 s of 0.5
    REQUIRE(through->points().ice_saturation[0] > 0.1);
    const auto from = through->state(), to = restarted->state();
    for (std::size_t c = 0; c < from.size(); ++c) std::copy_n(from[c].data, from[c].size(), to[c].data);
    restarted->restored();
    take_steps(*through, 300), take_steps(*restarted, 300);
    const auto a = through->state(), b = restarted->state();
    for (std::size_t c = 0; c < a.size(); ++c) {
        INFO(a[c].name);
        CHECK(std::equal(a[c].data, a[c].data + a[c].size(), b[c].data));
    }
}
