#include <cmath>

#include "tests/mpm-driver/mechanics/small_scenes.hpp"
#include "tests/support/catch.hpp"

using namespace talik;
using namespace talik::driver;
using namespace talik::driver::tests;

TEST_CASE("a body of any outline under the stress of its confining pressure rests exactly", "[eq22][eq23]") {
    BodySpec body = box({0, 0}, {1, 1});
    body.polygon.clear();
    for (int k = 0; k < 40; ++k) body.polygon.push_back(Vector(0.75, 0.75) + 0.51 * Vector(std::cos(0.157 * k), std::sin(0.157 * k)));
    body.stress = {-1e5, -1e5, 0.0};
    Scene scene = elastic_scene(body, {0, 0}, {1.5, 1.5});
    scene.confining_pressure = 1e5;
    auto simulation = start(scene);
    take_steps(*simulation, 100);
    double fastest = 0.0;
    for (const Vector& v : simulation->points().velocity) fastest = std::max(fastest, v.norm());
    // Each node's force is a sum of terms p V grad phi that cancels to about 1e-16 of them: 1e-16 * 2 * 1e5 Pa / (2000 kg/m^3 *
    // 0.05 m) = 2e-13 m/s^2, more where a node has little mass; 100 steps of 2e-4 s.
    CHECK(fastest < 1e-12);
}

TEST_CASE("plates of a confined body report the pressure times their area at the start, wherever they stand", "[eq23]") {
    const double shift = GENERATE(0.0, 0.0371);
    BodySpec body = box({0.4, 0.3 + shift}, {1.2, 1.1 + shift});
    body.stress = {-1e5, -1e5, 0.0};
    Scene scene = elastic_scene(body, {0, 0}, {1.6, 1.5});
    scene.domain.thickness = 0.7;
    scene.confining_pressure = 1e5;
    scene.walls = {wall("bottom", 0.3 + shift), wall("top", 1.1 + shift)};
    auto simulation = start(scene);
    take_steps(*simulation, 5);
    for (const Wall& plate : simulation->walls()) {
        CHECK(plate.reaction().contact_area == Approx(0.8 * 0.7).epsilon(1e-12)); // sums of 300 roundings
        CHECK(std::abs(plate.reaction().force[1]) == Approx(1e5 * 0.8 * 0.7).epsilon(1e-12));
        CHECK(std::abs(plate.reaction().force[0]) < 1e-9);
    }
    CHECK(simulation->walls()[0].reaction().force[1] > 0.0); // it pushes the body up
}

TEST_CASE("a block compressed between plates under a confining pressure answers with p plus E' strain, and its ledger closes", "[eq22]") {
    BodySpec body = box({0.4, 0.3}, {0.8, 1.1});
    body.stress = {-1e5, -1e5, 0.0};
    Scene scene = elastic_scene(body, {0, 0}, {1.2, 1.5});
    scene.confining_pressure = 1e5;
    scene.walls = {wall("bottom", 0.3), wall("top", 1.1, "roller", -0.02)};
    scene.walls[1].ramp = 0.2;
    scene.stages[0].duration = 0.5;
    scene.stages[0].moves = {"top"};
    scene.stages[0].pic = 0.01;
    scene.stages[0].particle_damping = 5.0;
    auto simulation = start(scene);
    while (!simulation->finished()) take_steps(*simulation, 1);
    const double strain = std::log(1.0 - 0.008 / 0.8); // 0.02 m/s for 0.5 s, less half the ramp
    const double plane_strain_young = young / (1.0 - 0.04); // E / (1 - nu^2): free to widen against the pressure
    const Wall& top = simulation->walls()[1];
    const double pressure = -top.reaction().force[1] / top.reaction().contact_area;
    const Ledger& ledger = simulation->ledger();
    WARN("confined block: " << pressure << " Pa, expected " << 1e5 - plane_strain_young * strain << "; energy error " << ledger.energy_error()
         << " (wall " << ledger.wall_work << " J, pressure " << ledger.pressure_work << " J, internal " << ledger.internal_work << ", by points " << ledger.point_work << ", transfer " << ledger.transfer
         << ", PIC " << ledger.pic << ", damping " << ledger.particle_damping << ", impact " << ledger.wall_impact << ", law " << ledger.law_energy - ledger.initial_law_energy << "), momentum error " << ledger.momentum_error());
    CHECK(pressure == Approx(1e5 - plane_strain_young * strain).epsilon(0.02)); // a wave is still on its way; overlap of 1 %
    CHECK(ledger.energy_error() < 0.01);
    CHECK(ledger.momentum_error() < 1e-12);
    CHECK(ledger.mass_error() < 1e-13);
}
