#include <cmath>
#include <cstring>

#include <omp.h>

#include "tests/mpm-driver/fault_text.hpp"
#include "tests/mpm-driver/mechanics/small_scenes.hpp"
#include "tests/support/catch.hpp"

using namespace talik;
using namespace talik::driver;
using namespace talik::driver::tests;

namespace {

// Something of everything: friction, a moving plate, pressure, gravity, PIC and damping.
Scene busy_scene(double cell) {
    Scene scene = elastic_scene(box({0.4, 0.3}, {1.2, 1.1}), {0, 0}, {1.6, 1.5}, cell);
    scene.bodies[0].stress = {-1e4, -1e4, 0.0};
    scene.confining_pressure = 1e4;
    scene.walls = {wall("bottom", 0.3, "fixed"), wall("top", 1.1, "roller", -0.5)};
    scene.walls[1].friction = 0.2;
    scene.walls[1].separates = true;
    scene.walls[1].ramp = 0.05;
    scene.stages[0].gravity = {0.0, -10.0};
    scene.stages[0].duration = 0.01;
    scene.stages[0].pic = 0.01;
    scene.stages[0].particle_damping = 2.0;
    scene.stages.push_back(scene.stages[0]);
    scene.stages[1].moves = {"top"};
    scene.stages[1].duration = 1.0;
    scene.step.fixed.reset();
    return scene;
}

bool same_bits(Simulation& a, Simulation& b) {
    const auto left = a.state(), right = b.state();
    bool same = left.size() == right.size();
    for (std::size_t k = 0; same && k < left.size(); ++k)
        same = left[k].size() == right[k].size() && std::memcmp(left[k].data, right[k].data, left[k].size() * sizeof(double)) == 0;
    return same;
}

} // namespace

TEST_CASE("one thread and two give the same bits") {
    auto one = start(busy_scene(0.05), 1); // 1024 points and 1155 nodes: enough for the loops to be shared out
    take_steps(*one, 30);
    auto two = start(busy_scene(0.05), 2);
    take_steps(*two, 30);
    omp_set_num_threads(1);
    CHECK(one->points().count() > 512);
    CHECK(same_bits(*one, *two));
    take_steps(*two, 1);
    CHECK(!same_bits(*one, *two)); // the comparison can fail
}

TEST_CASE("a simulation filled with the state of another goes on with the same bits") {
    auto through = start(busy_scene(0.1));
    take_steps(*through, 150); // in the second stage, the plate moving
    REQUIRE(through->stage() == 1);
    auto restarted = start(busy_scene(0.1));
    const auto from = through->state(), to = restarted->state();
    REQUIRE(from.size() == to.size());
    for (std::size_t k = 0; k < from.size(); ++k) {
        REQUIRE(from[k].name == to[k].name);
        std::memcpy(to[k].data, from[k].data, from[k].size() * sizeof(double));
    }
    CHECK(same_bits(*through, *restarted));
    take_steps(*through, 150);
    take_steps(*restarted, 150);
    CHECK(same_bits(*through, *restarted));
    CHECK(restarted->steps_done() == 300);
}

TEST_CASE("a step beyond the limit is refused, with the limit in the message", "[eq42]") {
    Scene scene = elastic_scene(box({0.3, 0.3}, {0.7, 0.7}), {0, 0}, {1, 1});
    auto simulation = start(scene);
    const double limit = simulation->stable_step().step;
    CHECK(limit == Approx(0.1 / std::sqrt(p_wave / 2000.0)).epsilon(1e-12)); // h / c, at rest
    const std::string fault = fault_of([&] { simulation->step(1.01 * limit); });
    CHECK(says(fault, "beyond the largest stable one, 0.001342 s (Eq. 42: wave speed 74.54 m/s"));
    CHECK(says(fault, "use step.fixed = \"auto\""));
    CHECK(fault_of([&] { simulation->step(0.99 * limit); }).empty());
}

TEST_CASE("automatic steps are stable for any number of points per cell, with free surfaces anywhere in the grid", "[eq42]") {
    const int per_cell = GENERATE(1, 4, 9, 16);
    const double corner = GENERATE(0.3, 0.337, 0.36);
    Scene scene = elastic_scene(box({corner, corner}, {corner + 0.6, corner + 0.4}, per_cell), {0, 0}, {1.4, 1.2});
    scene.step.fixed.reset();
    auto simulation = start(scene);
    Points& points = simulation->points();
    double kinetic = 0.0;
    for (std::size_t p = 0; p < points.count(); ++p) {
        points.velocity[p] = 1e-6 * Vector(std::sin(37.0 * p), std::cos(53.0 * p)); // noise, m/s
        kinetic += 0.5 * points.mass[p] * points.velocity[p].squaredNorm();
    }
    take_steps(*simulation, 2000);
    const Ledger& l = simulation->ledger();
    INFO(per_cell << " points per cell: energy " << (l.kinetic + l.law_energy) / kinetic << " of the first");
    CHECK(l.kinetic + l.law_energy < 1.01 * kinetic); // an unstable mode would have grown by orders of magnitude in 2000 steps
}

TEST_CASE("a point that leaves the domain is named") {
    Scene scene = elastic_scene(box({0.3, 0.3}, {0.5, 0.5}), {0, 0}, {1, 1});
    scene.bodies[0].velocity = {10.0, 0.0};
    auto simulation = start(scene);
    const std::string fault = fault_of([&] { take_steps(*simulation, 1000); });
    CHECK(says(fault, "of body 'body' leaves the domain at (1"));
    CHECK(says(fault, "in step 263")); // the foremost point, at 0.475 m, needs 0.525 m / (10 m/s * 2e-4 s) = 262.5 steps
}

TEST_CASE("a point turned inside out is named, and stops the run") {
    Scene scene = elastic_scene(box({0.3, 0.3}, {0.5, 0.5}), {0, 0}, {1, 1});
    auto simulation = start(scene);
    PrescribedField field;
    field.velocity_gradient << -6000.0, 0.0, 0.0, 0.0; // 1/s: I + dt L turns negative at 2e-4 s
    field.centre = {0.4, 0.4};
    simulation->prescribe(field);
    CHECK(says(fault_of([&] { take_steps(*simulation, 1); }), "is turned inside out in step 1"));
}

TEST_CASE("a stage ends after its duration or once kinetic energy falls below its part of the internal work") {
    Scene scene = elastic_scene(box({0.0, 0.0}, {0.2, 0.4}), {-0.1, -0.1}, {0.4, 0.7});
    scene.walls = {wall("left", 0.0), wall("right", 0.2), wall("bottom", 0.0)};
    scene.stages[0].gravity = {0.0, -10.0};
    scene.stages[0].particle_damping = 50.0;
    scene.stages[0].energy_ratio = 1e-6;
    scene.stages.push_back(scene.stages[0]);
    scene.stages[1].energy_ratio.reset();
    scene.stages[1].duration = 0.1;
    auto simulation = start(scene);
    while (simulation->stage() == 0) take_steps(*simulation, 1);
    CHECK(simulation->ledger().kinetic < 1e-6 * simulation->ledger().internal_work);
    CHECK(simulation->time() > 0.05); // not at its very start, when nothing had moved
    const auto steps = simulation->steps_done();
    while (!simulation->finished()) take_steps(*simulation, 1);
    CHECK(simulation->steps_done() - steps == 500); // 0.1 s of 2e-4 s
}

TEST_CASE("a scene that asks for what it does not have is refused by name") {
    Scene scene = elastic_scene(box({0.3, 0.3}, {0.5, 0.5}), {0, 0}, {1, 1});
    scene.stages[0].moves = {"plate"};
    CHECK(says(fault_of([&] { start(scene); }), "moves the wall 'plate'"));
    scene.stages[0].moves = {};
    scene.stages[0].activates = {"bonds"};
    CHECK(says(fault_of([&] { start(scene); }), "activates 'bonds'"));
    scene.stages[0].activates = {};
    scene.bodies[0].law = "rve";
    CHECK(says(fault_of([&] { start(scene); }), "asks for the law 'rve'"));
}
