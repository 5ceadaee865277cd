// Heat of points that move across cells.
#include <cmath>

#include "tests/mpm-driver/heat/small_heat.hpp"
#include "tests/support/catch.hpp"

using namespace talik;
using namespace talik::driver;
using namespace talik::driver::tests;

namespace {

PrescribedField translation(const Vector& velocity) {
    PrescribedField field;
    field.velocity = velocity;
    return field;
}

// A frozen core in warm ground that thaws while all of it is carried along.
std::unique_ptr<Simulation> carried_core(const Vector& velocity, double duration) {
    ThermalMaterialSpec spec = soil_material();
    spec.curve = "saturation";
    spec.residual_saturation = 0.05;
    Scene scene = heat_scene(spec, {1.0, 1.0}, 0.05, 5.0);
    BodySpec core = scene.bodies[0];
    core.name = "core";
    core.temperature = -5.0;
    core.polygon = {{0.35, 0.35}, {0.65, 0.35}, {0.65, 0.65}, {0.35, 0.65}};
    BodySpec below = scene.bodies[0], above = below, left = below, right = below;
    const auto outline = [](BodySpec& b, const std::string& name, double x0, double y0, double x1, double y1) {
        b.name = name;
        b.polygon = {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
    };
    outline(left, "left", 0, 0, 0.35, 1);
    outline(below, "below", 0.35, 0, 0.65, 0.35);
    outline(above, "above", 0.35, 0.65, 0.65, 1);
    outline(right, "right", 0.65, 0, 1, 1);
    scene.bodies = {left, below, core, above, right};
    make_moving(scene, {0.6, 0.6}, 400.0);
    auto simulation = start_heat(scene);
    simulation->prescribe(translation(velocity));
    while (simulation->time() < duration) simulation->step(simulation->next_step());
    return simulation;
}

} // namespace

TEST_CASE("ground that is carried across cells keeps its energy and makes neither heat nor cold", "[heat][moving][many-steps]") {
    const double duration = 1.2e6; // s: the core thaws after about half of it
    auto rest = carried_core({0, 0}, duration);
    const double span = 10.0; // K
    for (const double cells : {0.01, 0.3, 3.0}) {
        auto moving = carried_core(Vector(1.0, 0.37) * (cells * 0.05 / duration), duration);
        CAPTURE(cells);
        CHECK(balance(*moving) < 1e-12);
        WARN("carried by " << cells << " cells: out of range by " << moving->heat()->books().overshoot() << " K; coldest node "
             << moving->heat()->extremes().first << " C, at rest " << rest->heat()->extremes().first << " C");
        CHECK(moving->heat()->books().overshoot() <= 0.01 * span);
        // Mapping smears by at most (3/16) h^2 for each cell passed: against 2 k t / C of conduction, 0.36 m^2, a hundredth
        CHECK(moving->heat()->extremes().first == Approx(rest->heat()->extremes().first).margin(0.03 * span));
    }
}

TEST_CASE("a front behind a wall that moves with the surface converges with the cell", "[heat][moving]") {
    // The surface drifts by 0.1 m while the front goes 0.62 m (Ste = 1): a temperature held at nodes is off by up to half a cell.
    const auto error = [](int cells) {
        const double h = 2.0 / cells;
        Scene scene = heat_scene(unit_material(1.0), {2.0, 2 * h}, h, 0.0);
        scene.bodies[0].frozen = true;
        scene.heat->boundaries = {held_side("left", 1.0)};
        make_moving(scene, {0.2, 2 * h}, 0.25 * h * h * 1.0 / 0.1);
        auto simulation = start_heat(scene);
        simulation->prescribe(translation({0.04, 0.0}));
        while (simulation->time() < 2.5) simulation->step(simulation->next_step());
        CHECK(balance(*simulation) < 1e-12);
        CHECK(simulation->heat()->books().overshoot() <= 0.01);
        return simulation->heat()->water_volume(simulation->points()) / (2 * h) / (1.240125 / std::sqrt(10.0) * std::sqrt(simulation->time())) - 1.0;
    };
    const double coarse = error(25), fine = error(100);
    WARN("surface that moves, 25 and 100 cells: front off by " << coarse << ", " << fine);
    CHECK(std::abs(fine) < 0.5 * std::abs(coarse));
    CHECK(std::abs(fine) < 0.05); // first order: half a cell of 0.02 m in 0.62 m are 1.6 %
}

TEST_CASE("heat goes on once in many mechanical steps or many times within one, with the same result", "[heat][schedule]") {
    const auto content = [](double step, double size) {
        Scene scene = heat_scene(soil_material(), {0.4 * size, 0.4 * size}, 0.1 * size, 3.0);
        scene.heat->boundaries = {held_side("left", -4.0)};
        scene.heat->ice_step = 1.0; // no bound: the stable step alone
        make_moving(scene, {0.0, 0.0}, step);
        scene.stages[0].duration = 40000.0;
        auto simulation = start_heat(scene);
        simulation->prescribe(translation({0, 0}));
        while (!simulation->finished()) simulation->step(simulation->next_step());
        CHECK(balance(*simulation) < 1e-12);
        return std::pair{simulation->heat()->books().entered(), simulation->heat()->steps() / static_cast<double>(simulation->steps_done())};
    };
    // The limit at b = 4 is 2170 s: 8 steps of 250 s fit, and a step of 8000 s takes 4. The first of the 160 mechanical steps is
    // one of heat by itself, from which the rates of ice are known; 159 follow, in eights and a rest.
    const auto [many, share] = content(250.0, 1.0);
    const auto [few, substeps] = content(8000.0, 1.0);
    CHECK(share == Approx((1.0 + 20.0) / 160.0));
    CHECK(substeps == Approx(4.0));
    CHECK(few == Approx(many).epsilon(0.02)); // both in steps of 2000 s, 4 cells, but `many` maps to the points after each of them
}

TEST_CASE("a held side that moves with its surface makes neither heat nor cold, in whatever direction it goes", "[heat][moving][held]") {
    for (const double velocity : {-0.05, 0.05}) // m per duration: a cell
        for (const double sign : {1.0, -1.0}) { // freezing, thawing
            Scene scene = heat_scene(soil_material(), {0.5, 0.2}, 0.05, 0.5 * sign);
            scene.heat->boundaries = {held_side("left", -6.0 * sign)};
            make_moving(scene, {0.4, 0.0}, 200.0);
            for (Vector& corner : scene.bodies[0].polygon) corner[0] += 0.2;
            auto simulation = start_heat(scene);
            const double duration = 4.3e4; // s: half a day
            simulation->prescribe(translation(Vector(velocity / duration, 0.0)));
            while (simulation->time() < duration) simulation->step(simulation->next_step());
            CAPTURE(velocity, sign);
            CHECK(balance(*simulation) < 1e-12);
            CHECK(simulation->heat()->books().overshoot() <= 0.01 * 6.5); // asked: a hundredth of the span; once 225 of them
        }
}

TEST_CASE("between two steps of heat, a restarted run tells the temperatures of the one that was not cut", "[heat][moving][restart]") {
    ThermalMaterialSpec spec = soil_material();
    Scene scene = heat_scene(spec, {1.0, 0.4}, 0.05, 5.0);
    scene.heat->boundaries.push_back(held_side("left", -1e3));
    scene.heat->boundaries[0].kind = "flux"; // W/m^2, out of the ground: the coldest node grows colder with every step of heat
    make_moving(scene, {0.2, 0.2}, 1.0); // many of its steps fit into one of heat
    auto through = start_heat(scene), restarted = start_heat(scene);
    for (auto* run : {&through, &restarted}) (*run)->prescribe(translation({1e-3, 0.0}));
    const double heat_steps = through->heat()->steps();
    while (through->heat()->steps() == heat_steps) through->step(through->next_step());
    through->step(through->next_step());
    const auto from = through->state(), to = restarted->state();
    for (std::size_t c = 0; c < from.size(); ++c) std::copy_n(from[c].data, from[c].size(), to[c].data);
    restarted->restored();
    CHECK(through->heat()->extremes().first < 5.0);
    CHECK(restarted->heat()->extremes() == through->heat()->extremes());
    for (int k = 0; k < 50; ++k) {
        through->step(through->next_step()), restarted->step(restarted->next_step());
        CHECK(restarted->heat()->extremes() == through->heat()->extremes());
    }
}
