// Heat in a hurry: thaw at a blow, sharp fronts, contrasts, heaters that flicker, ground that moves through a front.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>

#include "tests/hard/hard_case.hpp"
#include "tests/mpm-driver/heat/small_heat.hpp"
#include "tests/support/temporary_file.hpp"

using namespace talik;
using namespace talik::driver;
using namespace talik::driver::tests;
using namespace talik::hard;

namespace {

// Newton's last change is 1e-15 of (|T| + 1 K), of a span of 50 K and more; what nodes pick up in 2e4 steps walks at random.
const Invariant in_range{"temperatures out of the imposed range, of the span", rounding_walk(unit_double, 2e4) + 1e-15,
                         "the discrete maximum principle below b = 2 (Eq. 43), to rounding of 2e4 steps and the inversion's 1e-15"};
const Invariant kept{"heat balance, relative", 1e-12, "what nodes receive points receive: rounding of 2e4 steps"};

// What holds in every case.
void check_range_and_balance(HardCase& hard, const Simulation& simulation, const Invariant& range = in_range, const std::string& variant = "") {
    hard.holds(range, simulation.heat()->books().overshoot() / simulation.heat()->span(), variant);
    hard.holds(kept, balance(simulation), variant);
}

// Another body beside the first one of a scene of heat.
BodySpec& add_box(Scene& scene, const std::string& name, const Vector& low, const Vector& high) {
    BodySpec body = scene.bodies[0];
    body.name = name;
    body.polygon = box(low, high).polygon;
    return scene.bodies.emplace_back(body);
}

// Steps of a table that alternate between two values with each of the solver's own steps.
std::string flicker(double step, int steps, double one, double other) {
    const std::string file = test_file("flicker.csv");
    std::ofstream out(file);
    out.precision(17);
    out << "time_s,value\n";
    for (int k = 0; k < steps; ++k) out << k * step << ',' << (k % 2 ? other : one) << '\n' << (k + 1) * step << ',' << (k % 2 ? other : one) << '\n';
    return file;
}

} // namespace

TEST_CASE("ground that thaws in one step takes exactly its latent heat", "[hard][heat]") {
    HardCase hard("heat", "full thaw within one step", "the step jumps over the phase change and loses its latent heat");
    const Invariant temperature{"temperature against heat over capacities, K", 1e-12, "the enthalpy is inverted exactly: rounding (1e-16) of 1.6e8 J/m3 over 3e6 J/(m3 K), in a hundred sums"};
    Scene scene = heat_scene(soil_material(), {0.4, 0.3}, 0.05, -5.0);
    HeatSourceSpec source;
    source.name = "blow";
    const double dt = 100.0, aim = 20.0; // s, degrees C
    const ThermalMaterial soil(soil_material());
    source.value.constant = (soil.enthalpy({aim, 0.0}) - soil.enthalpy({-5.0, 1.0})) / dt; // W/m^3
    scene.heat->sources = {source};
    scene.step.fixed = dt;
    auto simulation = start_heat(scene);
    take_steps(*simulation, 1);
    double worst = 0.0, ice = 0.0;
    for (std::size_t p = 0; p < simulation->points().count(); ++p) {
        worst = std::max(worst, std::abs(simulation->points().temperature[p] - aim));
        ice = std::max(ice, simulation->points().ice_saturation[p]);
    }
    hard.holds(temperature, worst);
    hard.holds({"ice left, -", 0, "above T0 there is none"}, ice);
    hard.holds(kept, balance(*simulation));
}

TEST_CASE("a wall of 50 C on ground of -20 C with a sharp front stays in range", "[hard][heat]") {
    HardCase hard("heat", "50 C wall on -20 C ground, sharp front", "temperatures beyond the wall's or below the ground's");
    for (const double safety : {0.5, 0.99}) {
        Scene scene = heat_scene(soil_material(), {1.0, 0.1}, 0.025, -20.0);
        scene.heat->boundaries = {held_side("left", 50.0)};
        auto simulation = start_heat(scene);
        const double step = safety * simulation->heat()->limit(simulation->grid(), simulation->points()).step; // of b = 2
        for (int k = 0; k < 3000; ++k) simulation->step(step);
        const std::string variant = safety < 0.6 ? "b = 4" : "0.99 of b = 2";
        check_range_and_balance(hard, *simulation, in_range, variant);
    }
}

TEST_CASE("conductivities of one to ten thousand side by side stay in range", "[hard][heat]") {
    HardCase hard("heat", "conductivity contrast 1e4", "heat piles up at the interface and swings");
    ThermalMaterialSpec good = soil_material(), poor = soil_material();
    good.grain_conductivity = 100.0, good.water_conductivity = good.ice_conductivity = 100.0;
    poor.name = "poor";
    poor.grain_conductivity = 0.01, poor.water_conductivity = poor.ice_conductivity = 0.01;
    Scene scene = heat_scene(good, {0.5, 0.2}, 0.05, -5.0);
    scene.heat->materials.push_back(poor);
    scene.bodies[0].polygon = box({0, 0}, {0.22, 0.2}).polygon; // the interface within a cell
    add_box(scene, "poor", {0.22, 0}, {0.5, 0.2}).material = "poor";
    scene.heat->boundaries = {held_side("left", 30.0), held_side("right", -20.0)};
    auto simulation = start_heat(scene);
    take_steps(*simulation, 20000);
    check_range_and_balance(hard, *simulation);
}

TEST_CASE("a heater that is switched at every step keeps the books and the range", "[hard][heat]") {
    HardCase hard("heat", "a heater switched on and off each step", "held ground takes a rate that is not its own: heat from nothing");
    Scene scene = heat_scene(soil_material(), {0.5, 0.5}, 0.05, -2.0);
    HeaterSpec heater;
    heater.name = "heater";
    heater.box = {{0.2, 0.2}, {0.3, 0.3}};
    heater.value.constant = 0.0;
    scene.heat->heaters = {heater};
    const auto unheated = start_heat(scene);
    const double step = 0.9 * unheated->heat()->limit(unheated->grid(), unheated->points()).step;
    scene.heat->heaters[0].value = {};
    scene.heat->heaters[0].value.file = flicker(step, 4000, 60.0, -30.0);
    scene.step.fixed = step;
    auto simulation = start_heat(scene);
    take_steps(*simulation, 4000);
    check_range_and_balance(hard, *simulation);
}

TEST_CASE("ground carried through a sharp front by 30 cells stays in range and keeps its heat", "[hard][heat]") {
    HardCase hard("heat", "points moving through a front", "differences that nodes cannot see show as heat and cold");
    // Where the ends of a moving body cut cells, nodes have no maximum principle: they may leave the range by a part of what the
    // front's tail has brought there when it arrives. That is D^n after n cells, D = 1/4 the diffusion number of b = 4.
    const Invariant range{"temperatures out of the imposed range, of the span", std::pow(0.25, 10.0), "cut cells at the body's ends see the tail of a front ten cells away: (1/4)^10 at b = 4"};
    Scene scene = heat_scene(soil_material(), {0.5, 0.2}, 0.05, -10.0);
    add_box(scene, "warm", {0.5, 0}, {1.0, 0.2}).temperature = 10.0;
    make_moving(scene, {2.2, 0.6}, 200.0);
    auto simulation = start_heat(scene);
    PrescribedField field;
    field.velocity = Vector(1.5, 0.31) / (200.0 * 2000);
    simulation->prescribe(field);
    take_steps(*simulation, 2000);
    check_range_and_balance(hard, *simulation, range);
}
