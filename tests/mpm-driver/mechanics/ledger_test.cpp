#include <cmath>

#include "tests/mpm-driver/mechanics/small_scenes.hpp"
#include "tests/support/catch.hpp"

using namespace talik;
using namespace talik::driver;
using namespace talik::driver::tests;

TEST_CASE("the energy ledger of a block pressed between rough plates closes to 1 % of the input work", "[eq22][eq34][ledger]") {
    const double pic = GENERATE(0.0, 0.05);
    Scene scene = elastic_scene(box({0.4, 0.3}, {0.8, 1.1}), {0, 0}, {1.2, 1.5});
    scene.bodies[0].stress = {-1e5, -1e5, 0.0};
    scene.confining_pressure = 1e5;
    scene.walls = {wall("bottom", 0.3, "fixed"), wall("top", 1.1, "roller", -0.05)};
    scene.walls[1].friction = 0.05; // less than it takes to stick at the plate's ends
    scene.walls[1].ramp = 0.1;
    scene.stages[0].moves = {"top"};
    scene.stages[0].duration = 0.8; // 4.7 % of strain
    scene.stages[0].pic = pic;
    scene.stages[0].particle_damping = 3.0;
    scene.stages[0].grid_damping = 2.0;
    auto simulation = start(scene);
    while (!simulation->finished()) take_steps(*simulation, 1);
    const Ledger& l = simulation->ledger();
    WARN("rough plates, PIC " << pic << ": energy error " << l.energy_error() << ", numerical loss " << l.numerical_loss() << "; walls " << l.wall_work << ", pressure " << l.pressure_work << ", internal "
         << l.internal_work << ", by points " << l.point_work << ", law " << l.law_energy - l.initial_law_energy << ", friction " << l.wall_friction << ", PIC " << l.pic
         << ", dampings " << l.particle_damping << " and " << l.grid_damping << ", transfer " << l.transfer << ", impact " << l.wall_impact << " J");
    CHECK(l.energy_error() < 1e-9); // all booked: what is left is the law's own account against the work done on it
    // The project's bound, with PIC, damping and friction booked but none of the losses between points and grid:
    CHECK(l.energy_error() + l.numerical_loss() < 0.01);
    CHECK(l.wall_friction > 0.0);
    CHECK(l.particle_damping > 0.0);
    CHECK(l.grid_damping > 0.0);
    CHECK((pic == 0.0 ? l.pic == 0.0 : l.pic > 0.0));
    CHECK(l.momentum_error() < 1e-12); // roundings of 4000 steps' impulses
    CHECK(l.mass_error() < 1e-13);
}

TEST_CASE("a block that falls, bounces and is damped keeps its books", "[eq34][ledger]") {
    Scene scene = elastic_scene(box({0.3, 0.35}, {0.7, 0.75}), {0, 0}, {1, 1.5});
    scene.walls = {wall("bottom", 0.2)};
    scene.walls[0].separates = true;
    scene.stages[0].gravity = {0.0, -10.0};
    scene.stages[0].pic = GENERATE(0.0, 0.02);
    auto simulation = start(scene);
    take_steps(*simulation, 2000); // 0.4 s: falls 0.15 m in 0.17 s and bounces
    const Ledger& l = simulation->ledger();
    WARN("bounce: energy error " << l.energy_error() << ", numerical loss " << l.numerical_loss() << "; gravity " << l.gravity_work << ", kinetic " << l.kinetic << ", law " << l.law_energy << ", PIC " << l.pic
         << ", transfer " << l.transfer << ", impact " << l.wall_impact << ", internal " << l.internal_work << ", by points " << l.point_work << " J");
    CHECK(l.momentum_error() < 1e-12);
    CHECK(l.momentum[1] > 0.0); // on its way up again
    CHECK(std::abs(l.energy_residual()) < 0.01 * 320.0 * 10.0 * 0.15); // of the energy of its fall
}

TEST_CASE("the energy of a free vibration is kept without PIC and damping, and what PIC takes is booked", "[eq34][ledger]") {
    const double pic = GENERATE(0.0, 0.01);
    Scene scene = elastic_scene(box({0, 0}, {1, 0.2}), {-0.2, -0.2}, {1.4, 0.6});
    scene.walls = {wall("left", 0), wall("right", 1), wall("bottom", 0), wall("top", 0.2)};
    scene.stages[0].pic = pic;
    auto simulation = start(scene);
    Points& points = simulation->points();
    for (std::size_t p = 0; p < points.count(); ++p) points.velocity[p] = {0.01 * std::sin(3.14159265358979 * points.position[p][0]), 0.0};
    take_steps(*simulation, 1340); // 10 periods
    const Ledger& l = simulation->ledger();
    WARN("free vibration, PIC " << pic << ": energy error " << l.energy_error() << ", PIC loss " << l.pic / l.initial_kinetic << ", transfer " << l.transfer / l.initial_kinetic << ", strain transfer " << l.strain_transfer / l.initial_kinetic);
    CHECK(l.energy_error() < 1e-9);
    // Stress updated last, on a mode of ten cells: its loss per time is of the order dt w^2 (k h)^2 / 4; here 10 periods.
    CHECK(l.numerical_loss() < 0.1);
    CHECK((pic == 0.0 ? l.pic == 0.0 : l.pic > 0.1 * l.initial_kinetic));
}

TEST_CASE("a free body that breathes under a pressure gathers no momentum, though no impulse adds up to more than rounding", "[eq34][ledger]") {
    Scene scene = elastic_scene(box({0.337, 0.3}, {0.737, 0.8}, 9), {0, 0}, {1, 1.1});
    scene.confining_pressure = 1e5;
    scene.stages[0].particle_damping = 0.5; // whose impulses cancel too
    auto simulation = start(scene);
    take_steps(*simulation, 200);
    CHECK(simulation->ledger().kinetic > 0.0);
    CHECK(simulation->ledger().momentum_error() < 1e-12); // of the impulses of the pressure on each node
}
