// With mechanics: how far the ice of a point may leap from one step of heat to the next.
#include <algorithm>
#include <cmath>

#include "tests/mpm-driver/heat/small_heat.hpp"
#include "tests/support/catch.hpp"

using namespace talik;
using namespace talik::driver;
using namespace talik::driver::tests;

namespace {

// Frozen ground at rest, thawed by a heater that is switched on after 4000 s. The automatic step of heat is about 500 s,
// so that a mechanical one of 5 s leaves room for steps of heat of any length between.
Scene heated(double ice_step) {
    ThermalMaterialSpec soil = soil_material();
    soil.residual_temperature = -0.5;
    Scene scene = heat_scene(soil, {0.8, 0.4}, 0.1, -1.0);
    HeaterSpec heater;
    heater.name = "heater";
    heater.line = {Vector(0.4, 0.0), Vector(0.4, 0.4)};
    heater.value.constant = 40.0;
    heater.begins = 4000.0;
    scene.heat->heaters = {heater};
    scene.heat->ice_step = ice_step;
    make_moving(scene, {0.0, 0.0}, 5.0);
    return scene;
}

struct Leaps {
    double largest = 0.0; // of a point's ice saturation in a mechanical step
    double steps = 0.0;   // of heat
    double melted = 0.0;  // lowest ice saturation at the end
};

Leaps leaps_of(double ice_step) {
    auto simulation = start_heat(heated(ice_step));
    simulation->prescribe({}); // no motion
    Leaps leaps;
    std::vector<double> before = simulation->points().ice_saturation;
    while (simulation->time() < 40000.0) {
        simulation->step(simulation->next_step());
        const std::vector<double>& now = simulation->points().ice_saturation;
        for (std::size_t p = 0; p < now.size(); ++p) leaps.largest = std::max(leaps.largest, std::abs(now[p] - before[p]));
        before = now;
    }
    leaps.steps = simulation->heat()->steps();
    leaps.melted = *std::min_element(before.begin(), before.end());
    CHECK(balance(*simulation) < 1e-12);
    return leaps;
}

} // namespace

TEST_CASE("no step of heat changes the ice of a point by more than the scene allows, from the heater's first moment on", "[heat][eq8]") {
    const Leaps free = leaps_of(1.0), gentle = leaps_of(0.01), gentler = leaps_of(0.002);
    WARN("largest leap and steps of heat: " << free.largest << ", " << free.steps << "; " << gentle.largest << ", " << gentle.steps << "; "
         << gentler.largest << ", " << gentler.steps);
    CHECK(free.largest > 0.02); // what the stable step alone would send to the bonds
    // Foreseen from the rates of the step before, which grow by little in a step that changes ice by a hundredth.
    CHECK(gentle.largest <= 0.011);
    CHECK(gentler.largest <= 0.0022);
    CHECK(gentler.steps > gentle.steps);
    CHECK(gentle.melted < 0.3); // and ice there was to melt
    CHECK(gentle.melted == Approx(free.melted).margin(0.03));
}

TEST_CASE("where nothing melts steps of heat are as long as they are stable", "[heat]") {
    Scene scene = heated(0.01);
    scene.heat->heaters.clear();
    auto simulation = start_heat(scene);
    simulation->prescribe({});
    for (int k = 0; k < 400; ++k) simulation->step(simulation->next_step()); // 2000 s
    const double stable = simulation->heat()->limit(simulation->grid(), simulation->points()).automatic;
    CHECK(simulation->heat()->steps() <= 2000.0 / stable + 2.0);
}
