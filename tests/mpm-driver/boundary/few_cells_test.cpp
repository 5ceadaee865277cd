// Walls on bodies of few cells, and walls that let go.
#include <cmath>

#include "tests/mpm-driver/mechanics/small_scenes.hpp"
#include "tests/support/catch.hpp"

using namespace talik;
using namespace talik::driver;
using namespace talik::driver::tests;

namespace {

double fastest(const Simulation& simulation) { // m/s
    double most = 0.0;
    for (const Vector& v : simulation.points().velocity) most = std::max(most, v.norm());
    return most;
}

} // namespace

TEST_CASE("a layer of few cells between facing rollers, wherever they stand, is pressed with its stress times its area", "[eq23]") {
    const double cells = GENERATE(1.0, 1.5, 2.0, 2.5, 4.0), shift = GENERATE(0.0, 0.03, 0.07);
    CAPTURE(cells, shift);
    BodySpec body = box({0.3, 0.3 + shift}, {1.1, 0.3 + shift + 0.1 * cells});
    body.stress = {-1e5, -1e5, 0.0};
    Scene scene = elastic_scene(body, {0, 0}, {1.4, 1.2});
    scene.walls = {wall("left", 0.3), wall("right", 1.1), wall("bottom", 0.3 + shift), wall("top", 0.3 + shift + 0.1 * cells)};
    scene.stages[0].particle_damping = 20.0;
    auto simulation = start(scene);
    take_steps(*simulation, 2000);
    // At rest in a state that a uniform stress is: 1e-3 is what points that do not tile the cells of an odd thickness leave.
    for (int k = 2; k < 4; ++k) CHECK(std::abs(simulation->walls()[k].reaction().force[1]) == Approx(1e5 * 0.8).epsilon(1e-3));
    CHECK(fastest(*simulation) < 1e-4);
}

TEST_CASE("a body of few cells under its confining pressure pushes a wall with the pressure times its area", "[eq23]") {
    const double cells = GENERATE(1.0, 2.0, 3.0, 6.0);
    CAPTURE(cells);
    BodySpec body = box({0.3, 0.3}, {0.3 + 0.1 * cells, 1.1});
    body.stress = {-1e5, -1e5, 0.0};
    Scene scene = elastic_scene(body, {0, 0}, {1.4, 1.5});
    scene.confining_pressure = 1e5;
    scene.walls = {wall("left", 0.3)};
    auto simulation = start(scene);
    take_steps(*simulation, 5);
    CHECK(simulation->walls()[0].reaction().contact_area == Approx(0.8).epsilon(1e-12)); // sums of 300 roundings
    CHECK(simulation->walls()[0].reaction().force[0] == Approx(1e5 * 0.8).epsilon(1e-12));
}

TEST_CASE("friction stays within Coulomb's cone whatever the PIC fraction", "[wall][friction]") {
    const double pic = GENERATE(0.0, 0.01, 0.05);
    CAPTURE(pic);
    Scene scene = elastic_scene(box({0.3, 0.2}, {0.7, 0.6}), {0, 0}, {3.0, 1.0});
    scene.walls = {wall("bottom", 0.2)};
    scene.walls[0].friction = 0.3;
    scene.walls[0].separates = true;
    scene.stages[0].pic = pic;
    scene.stages[0].gravity = Vector(10.0 * std::sin(0.6), -10.0 * std::cos(0.6)); // 34 degrees: it slides
    auto simulation = start(scene);
    // With a PIC fraction, what holding the mapped velocity takes through it is friction, too. Where a line slips again in that step all
    // of its present correction is taken back, but no more: a hundredth may be left over, in some steps.
    const double cone = pic > 0.0 ? 1.02 * 0.3 : 0.3;
    double along = 0.0, onto = 0.0;
    for (int k = 0; k < 2000; ++k) {
        take_steps(*simulation, 1);
        const Vector force = simulation->walls()[0].reaction().force;
        CHECK(std::abs(force[0]) <= cone * std::max(force[1], 0.0) + 1e-9); // N, of a weight of 3 kN
        if (k >= 1000) along += std::abs(force[0]), onto += force[1];
    }
    CHECK(along > 0.9 * 0.3 * onto); // it slides all the time, and lines of little weight may stick
}

TEST_CASE("a fixed wall that lets go holds nothing that does not touch it", "[wall]") {
    BodySpec body = box({0.4, 0.25}, {0.8, 0.65});
    Scene scene = elastic_scene(body, {0, 0}, {2.0, 3.0});
    scene.walls = {wall("bottom", 0.2, "fixed")}; // half a cell below
    scene.walls[0].separates = true;
    auto simulation = start(scene);
    for (Vector& v : simulation->points().velocity) v = {1.0, 2.0};
    take_steps(*simulation, 500);
    for (const Vector& v : simulation->points().velocity) {
        CHECK(v[0] == Approx(1.0).epsilon(1e-9));
        CHECK(v[1] == Approx(2.0).epsilon(1e-9));
    }
}
