// Stages of a run: gravity that grows, rest that lasts, warnings where it did not come.
#include <algorithm>

#include "tests/mpm-driver/fault_text.hpp"
#include "tests/mpm-driver/mechanics/small_scenes.hpp"
#include "tests/support/catch.hpp"

using namespace talik;
using namespace talik::driver;
using namespace talik::driver::tests;

namespace {

// A column that rests on its base, 0.4 m high: 2000 kg/m^3, P-waves of 74.5 m/s, slowest period 4 H / c = 21 ms.
Scene column() {
    Scene scene = elastic_scene(box({0.0, 0.0}, {0.2, 0.4}), {-0.1, -0.1}, {0.4, 0.7});
    scene.walls = {wall("left", 0.0), wall("right", 0.2), wall("bottom", 0.0)};
    scene.stages[0].gravity = {0.0, -10.0};
    return scene;
}

double weight_on_base(const Simulation& simulation) { return simulation.walls()[2].reaction().force.y(); }

constexpr double weight = 2000.0 * 0.2 * 0.4 * 10.0; // N, of 1 m thickness

} // namespace

TEST_CASE("gravity that grows over many periods keeps a column in equilibrium all the way, without damping", "[stage]") {
    Scene scene = column();
    scene.stages[0].gravity_ramp = 0.2; // ten periods
    scene.stages[0].duration = 0.3;
    auto simulation = start(scene);
    double worst = 0.0;
    while (!simulation->finished()) {
        take_steps(*simulation, 1);
        const double part = std::min(1.0, (simulation->time() - 1e-4) / 0.2); // at the middle of the step
        worst = std::max(worst, std::abs(weight_on_base(*simulation) - part * part * (3.0 - 2.0 * part) * weight) / weight);
    }
    // Suddenly applied, gravity would swing the base's force between 0 and 2 weights. A smooth ramp of duration T leaves
    // swings of the order of the ramp's second derivative over omega^2: 6 / T^2 / (2 pi / 21 ms)^2 = 0.2 %, at each end and
    // in several modes: 2 % is an upper bound that a linear ramp (1 / (omega T) = 1.7 % each end, plus nodes) just misses.
    CHECK(worst < 0.02);
    CHECK(weight_on_base(*simulation) == Approx(weight).epsilon(0.02));
}

TEST_CASE("a stage of fixed steps ends on time: the last step is cut, and a whole number of steps stays whole", "[stage]") {
    Scene scene = column();
    scene.step.fixed = 2e-4;
    scene.stages[0].duration = 0.0305; // 152.5 steps
    scene.stages.push_back(scene.stages[0]);
    scene.stages[1].duration = 0.03; // 150, though no multiple of the step is exact in binary
    auto simulation = start(scene);
    while (simulation->stage() == 0) take_steps(*simulation, 1);
    CHECK(simulation->steps_done() == 153);
    CHECK(simulation->time() == Approx(0.0305).epsilon(1e-12));
    while (!simulation->finished()) take_steps(*simulation, 1);
    CHECK(simulation->steps_done() == 303);
    CHECK(simulation->time() == Approx(0.0605).epsilon(1e-12));
}

TEST_CASE("a ramp begins at the gravity the stage before has left", "[stage]") {
    Scene scene = column();
    scene.stages[0].particle_damping = 50.0;
    scene.stages[0].duration = 0.3; // 0.3 s at 50 1/s: e^-7 is left of the swing
    scene.stages.push_back(scene.stages[0]);
    scene.stages[1].gravity = {0.0, -20.0};
    scene.stages[1].gravity_ramp = 0.2;
    auto simulation = start(scene);
    while (simulation->stage() == 0) take_steps(*simulation, 1);
    const double before = weight_on_base(*simulation);
    take_steps(*simulation, 1);
    CHECK(std::abs(weight_on_base(*simulation) - before) < 0.01 * weight); // s^2 of a thousandth of the ramp, and what still swings
    while (!simulation->finished()) take_steps(*simulation, 1);
    CHECK(weight_on_base(*simulation) == Approx(2.0 * weight).epsilon(0.01));
}

TEST_CASE("a swinging column that stands still for a moment has not come to rest", "[stage]") {
    Scene scene = column(); // undamped: kinetic energy is nearly zero twice per period
    scene.stages[0].energy_ratio = 0.01;
    scene.stages[0].duration = 0.2; // ten periods
    auto simulation = start(scene);
    while (!simulation->finished()) take_steps(*simulation, 1);
    CHECK(simulation->time() == Approx(0.2));
}

TEST_CASE("a stage that ends at its latest time instead of at rest leaves a warning with both ratios", "[stage]") {
    Scene scene = column();
    scene.stages[0].energy_ratio = 1e-9;
    scene.stages[0].duration = 0.02;
    auto simulation = start(scene);
    while (!simulation->finished()) take_steps(*simulation, 1);
    REQUIRE(simulation->warnings().size() == 1);
    CHECK(says(simulation->warnings()[0], "stage \"only\" ended at its latest time before it came to rest"));
    CHECK(says(simulation->warnings()[0], "asked for were 1e-09"));
}

TEST_CASE("what a stage warned of is known after a restart too", "[stage][restart]") {
    Scene scene = column();
    scene.stages[0].energy_ratio = 1e-9;
    scene.stages[0].duration = 0.02;
    scene.stages.push_back(scene.stages[0]);
    scene.stages[1].energy_ratio.reset();
    auto through = start(scene), restarted = start(scene);
    while (through->stage() == 0) take_steps(*through, 1);
    const auto from = through->state(), to = restarted->state();
    for (std::size_t c = 0; c < from.size(); ++c) std::copy_n(from[c].data, from[c].size(), to[c].data);
    REQUIRE(through->warnings().size() == 1);
    CHECK(restarted->warnings() == through->warnings());
}

TEST_CASE("a restart in the middle of a ramped stage goes on with the same bits, through the end of the stage at rest", "[stage][restart]") {
    Scene scene = column();
    scene.stages[0].particle_damping = 50.0;
    scene.stages[0].gravity_ramp = 0.05;
    scene.stages[0].energy_ratio = 1e-4;
    scene.stages[0].duration = 1.0;
    scene.stages.push_back(scene.stages[0]);
    scene.stages[1].gravity = {0.0, -20.0};
    scene.stages[1].duration = 0.1;
    auto through = start(scene), restarted = start(scene);
    while (through->time() < 0.03) take_steps(*through, 1); // in the ramp
    REQUIRE(through->stage() == 0);
    const auto from = through->state(), to = restarted->state();
    for (std::size_t c = 0; c < from.size(); ++c) std::copy_n(from[c].data, from[c].size(), to[c].data);
    while (through->stage() == 0) take_steps(*through, 1), take_steps(*restarted, 1);
    CHECK(restarted->stage() == 1);
    take_steps(*through, 50), take_steps(*restarted, 50); // into the second ramp, which begins at the first one's gravity
    const auto a = through->state(), b = restarted->state();
    for (std::size_t c = 0; c < a.size(); ++c) {
        INFO(a[c].name);
        CHECK(std::equal(a[c].data, a[c].data + a[c].size(), b[c].data));
    }
}
