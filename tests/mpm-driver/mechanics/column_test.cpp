#include <cmath>

#include "tests/mpm-driver/mechanics/small_scenes.hpp"
#include "tests/support/catch.hpp"

using namespace talik;
using namespace talik::driver;
using namespace talik::driver::tests;

TEST_CASE("an elastic column settles under its weight and then stays for 1e5 steps without creeping", "[eq22][eq23][eq30][many-steps]") {
    Scene scene = elastic_scene(box({0.0, 0.0}, {0.2, 0.8}), {-0.1, -0.1}, {0.4, 1.1});
    scene.walls = {wall("left", 0.0), wall("right", 0.2), wall("bottom", 0.0)};
    scene.step.fixed = 5e-4;
    scene.stages[0].gravity = {0.0, -10.0};
    scene.stages[0].duration = 4.0;        // s
    scene.stages[0].particle_damping = 40.0; // 1/s: near critical for the column's first mode (150 rad/s)
    scene.stages.push_back(scene.stages[0]);
    scene.stages[1].duration = 50.0;       // 1e5 steps, undamped
    scene.stages[1].particle_damping = 0.0;
    auto simulation = start(scene);
    while (simulation->stage() == 0) take_steps(*simulation, 1);
    const std::vector<Vector> settled = simulation->points().position;
    const std::vector<Stress> stress = simulation->points().stress;
    take_steps(*simulation, 100000);
    const Points& points = simulation->points();
    double creep = 0.0, stress_change = 0.0, off = 0.0;
    for (std::size_t p = 0; p < points.count(); ++p) {
        creep = std::max(creep, (points.position[p] - settled[p]).norm());
        stress_change = std::max(stress_change, (points.stress[p] - stress[p]).cwiseAbs().maxCoeff());
        // points whose extent lies in one cell share its strain: the weight above the cell's middle, Pa
        const double middle = 0.1 * (std::floor(points.initial_position[p][1] / 0.1) + 0.5);
        off = std::max(off, std::abs(points.stress[p][1] + 2000.0 * 10.0 * (0.8 - middle)));
    }
    WARN("column: creep " << creep << " m, change of stress " << stress_change << " Pa in 1e5 steps; off the weight above by " << off << " Pa of 16000");
    // Settling is u = rho g H^2 / 2M = 0.6 mm. Rounding of positions, 1e-16 m a step, may add up at random over 1e5 steps: 3e-14 m
    // in position, or in stress through the stiffness M / h = 1e8 Pa/m.
    CHECK(creep < 1e-11);
    CHECK(stress_change < 1e-3);
    CHECK(off < 0.005 * 16000.0); // the settled points no longer tile: strains up to 1.4e-3
}
