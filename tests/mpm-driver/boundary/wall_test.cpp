#include <cmath>

#include "mpm-driver/boundary/walls.hpp"
#include "tests/mpm-driver/fault_text.hpp"
#include "tests/mpm-driver/mechanics/small_scenes.hpp"
#include "tests/support/catch.hpp"

using namespace talik;
using namespace talik::driver;
using namespace talik::driver::tests;

namespace {

// A grid of 10 x 10 cells of 0.1 m whose nodes all have mass, unevenly.
Grid grid_with_mass() {
    Grid grid({0, 0}, {1, 1}, 0.1, 1.0);
    for (int n = 0; n < grid.node_count(); ++n) grid.mass[static_cast<std::size_t>(n)] = 1.0 + 0.3 * std::sin(1.7 * n);
    return grid;
}

template <class Field>
void set_velocity(Grid& grid, Field&& field) {
    for (int n = 0; n < grid.node_count(); ++n)
        grid.velocity[static_cast<std::size_t>(n)] = grid.velocity_before[static_cast<std::size_t>(n)] = field(grid.node_position(n));
}

} // namespace

TEST_CASE("a velocity field linear in the normal direction that satisfies a wall is left alone, wherever its face stands", "[wall]") {
    const std::string side = GENERATE("left", "right", "bottom", "top");
    const double face = GENERATE(0.5, 0.5 + 1e-13, 0.51, 0.537, 0.5999999, 0.6);
    Grid grid = grid_with_mass();
    std::vector<Wall> walls;
    walls.emplace_back(wall(side, face, "fixed"), grid);
    const int axis = side == "left" || side == "right" ? 0 : 1;
    const auto field = [&](const Vector& x) { return Vector((x[axis] - face) * Vector(0.7, -0.4)); };
    set_velocity(grid, field);
    hold_mapped_velocity(walls, grid, 1e-3, 0.0, 0.0);
    constrain(walls, grid);
    double change = 0.0;
    for (int n = 0; n < grid.node_count(); ++n)
        change = std::max(change, (grid.velocity[static_cast<std::size_t>(n)] - field(grid.node_position(n))).norm());
    CHECK(change < 1e-13); // roundings of distances of 1 m, and a face within 1e-12 cells of a row that counts as on it
    CHECK(walls[0].reaction().force.norm() < 1e-13 / 1e-3 * 40.0); // the same, times the mass of four rows over dt
}

TEST_CASE("a wall gives the grid its velocity at the face with the least change of momentum, and its impulse is that change", "[wall]") {
    const double face = GENERATE(0.5, 0.537, 0.549); // beyond half a cell a third row takes part
    Grid grid = grid_with_mass();
    for (int j = 0; j < 6; ++j) // no material beneath row 0.5 m: two rows take part
        for (int i = 0; i < grid.nodes(0); ++i) grid.mass[static_cast<std::size_t>(grid.node(i, j))] = 0.0;
    std::vector<Wall> walls;
    walls.emplace_back(wall("bottom", face), grid);
    set_velocity(grid, [](const Vector& x) { return Vector(0.3, 0.2 * std::cos(9.0 * x[0] + 5.0 * x[1])); });
    const std::vector<Vector> before = grid.velocity;
    hold_mapped_velocity(walls, grid, 1e-3, 0.0, 0.0);
    constrain(walls, grid);
    const double s = (face - 0.5) / 0.1;
    double impulse = 0.0;
    for (int i = 0; i < grid.nodes(0); ++i) {
        const auto j = static_cast<std::size_t>(grid.node(i, 6)), inner = static_cast<std::size_t>(grid.node(i, 7));
        CHECK(std::abs((1 - s) * grid.velocity[j][1] + s * grid.velocity[inner][1]) < 1e-14);
        // Gauss: m_j dv_j : m_{j+1} dv_{j+1} = (1-s) : s
        const double outer_part = grid.mass[j] * (grid.velocity[j][1] - before[j][1]);
        const double inner_part = grid.mass[inner] * (grid.velocity[inner][1] - before[inner][1]);
        CHECK(std::abs(s * outer_part - (1 - s) * inner_part) < 1e-14);
        CHECK(grid.velocity[j][0] == 0.3); // a roller leaves the other component
        impulse += outer_part + inner_part;
    }
    CHECK(walls[0].reaction().force[1] == Approx(impulse / 1e-3).epsilon(1e-12));
}

TEST_CASE("the reaction of a plate is continuous as its face crosses a node row", "[wall]") {
    // A block between two plates; the upper one pushes it down at constant speed, its face passing a row of nodes. The
    // block has no weight and the plate is slow, so the reaction is elastic resistance, and must not jump.
    BodySpec body = box({0.3, 0.3}, {0.7, 0.905});
    body.polygon = {{0.3, 0.305}, {0.7, 0.305}, {0.7, 0.905}, {0.3, 0.905}};
    Scene scene = elastic_scene(body, {0, 0}, {1, 1.2});
    scene.walls = {wall("bottom", 0.305), wall("top", 0.905, "roller", -0.02)};
    scene.walls[1].ramp = 0.1; // s
    scene.stages[0].moves = {"top"};
    scene.stages[0].particle_damping = 20.0; // 1/s
    auto simulation = start(scene);
    double previous = 0.0, largest_jump = 0.0, largest_smooth_change = 0.0, force = 0.0;
    int crossings = 0;
    for (int k = 0; k < 3000; ++k) { // 0.6 s: the face moves from 0.905 m to 0.894 m and crosses the row at 0.9 m
        const double position = simulation->walls()[1].position();
        take_steps(*simulation, 1);
        force = -simulation->walls()[1].reaction().force[1];
        const bool crosses = position > 0.9 && simulation->walls()[1].position() <= 0.9;
        crossings += crosses;
        const double change = std::abs(force - previous);
        if (k > 600) { // after the ramp and its waves
            double& largest = std::abs(position - 0.9) < 2e-5 ? largest_jump : largest_smooth_change;
            largest = std::max(largest, change);
        }
        previous = force;
    }
    CHECK(crossings == 1);
    WARN("plate crossing a row: change of the reaction per step " << largest_jump << " N there, " << largest_smooth_change << " N elsewhere, of " << force << " N");
    // A step adds 30 N everywhere (6e-6 of strain). Were the slope left to the outer row alone, the crossing would show 965 N.
    CHECK(largest_jump < 2.0 * largest_smooth_change);
    CHECK(largest_smooth_change < 1e-3 * force);
}

TEST_CASE("a wall that separates only pushes", "[wall]") {
    Grid grid = grid_with_mass();
    WallSpec spec = wall("bottom", 0.5);
    spec.separates = true;
    std::vector<Wall> walls;
    walls.emplace_back(spec, grid);
    set_velocity(grid, [](const Vector&) { return Vector(0.0, 0.1); }); // leaves
    hold_mapped_velocity(walls, grid, 1e-3, 0.0, 0.0);
    constrain(walls, grid);
    CHECK(walls[0].reaction().force.norm() == 0.0);
    set_velocity(grid, [](const Vector&) { return Vector(0.0, -0.1); }); // comes
    hold_mapped_velocity(walls, grid, 1e-3, 0.0, 0.0);
    constrain(walls, grid);
    CHECK(walls[0].reaction().force[1] > 0.0);
    for (int i = 0; i < grid.nodes(0); ++i) CHECK(std::abs(grid.velocity[static_cast<std::size_t>(grid.node(i, 6))][1]) < 1e-16);
}

TEST_CASE("a block slides on a rough wall with the deceleration mu g, and its friction is booked", "[wall]") {
    BodySpec body = box({0.3, 0.2}, {0.7, 0.4});
    body.velocity = {1.0, 0.0};
    Scene scene = elastic_scene(body, {0, 0}, {3, 1});
    scene.walls = {wall("bottom", 0.2)};
    scene.walls[0].friction = 0.3;
    scene.walls[0].separates = true;
    scene.stages[0].gravity = {0.0, -10.0};
    auto simulation = start(scene);
    Points& points = simulation->points();
    for (std::size_t p = 0; p < points.count(); ++p) // at rest under its weight: it would bounce otherwise
        points.stress[p] = {0.0, -2000.0 * 10.0 * (0.4 - points.position[p][1]), 0.0};
    take_steps(*simulation, 500); // 0.1 s
    const Ledger& ledger = simulation->ledger();
    const double speed = ledger.momentum[0] / ledger.mass; // mean, m/s
    WARN("sliding block: speed " << speed << " m/s after 0.1 s (0.7 expected), friction " << ledger.wall_friction << " J of " << ledger.initial_kinetic - ledger.kinetic << " J; energy error " << ledger.energy_error() << ": internal " << ledger.internal_work << ", by points " << ledger.point_work << ", transfer " << ledger.transfer << ", impact " << ledger.wall_impact << ", gravity " << ledger.gravity_work);
    // The block is four points high and rocks as friction sets in: its mean speed swings by a percent or two.
    CHECK(speed == Approx(0.7).epsilon(0.02));
    CHECK(ledger.wall_friction == Approx(ledger.initial_kinetic - ledger.kinetic).epsilon(0.05));
    CHECK(ledger.momentum_error() < 1e-12);
    // Friction, losses in transfer and the law's energy, all booked: what is left is the law's second order in its turns.
    CHECK(ledger.energy_error() < 0.01);
}

TEST_CASE("a moving wall's position is the integral of its velocity for any step", "[wall]") {
    const Grid grid({0, 0}, {1, 1}, 0.1, 1.0);
    for (const int steps : {1, 7, 1000}) {
        WallMotion motion(0.5, -0.1, 0.2);
        motion.start();
        double path = 0.0;
        for (int k = 0; k < steps; ++k) path += motion.advance(0.5 / steps) * 0.5 / steps;
        CHECK(motion.position() == Approx(0.5 - 0.1 * (0.5 - 0.1)).epsilon(1e-12)); // half the ramp is lost
        CHECK(path == Approx(-0.04).epsilon(1e-12));
    }
}

TEST_CASE("a wall outside the domain is refused by name", "[wall]") {
    const Grid grid({0, 0}, {1, 1}, 0.1, 1.0);
    CHECK(says(fault_of([&] { Wall(wall("top", 1.05), grid); }), "wall 'top' at 1.05 m stands outside the domain"));
    CHECK(says(fault_of([&] { Wall(wall("up", 0.5), grid); }), "side is 'up'"));
    CHECK(fault_of([&] { Wall(wall("top", 1.0), grid); }).empty());
}

TEST_CASE("points beneath a plate that has been set in motion move with it, without PIC or damping", "[wall][eq34]") {
    const double ramp = GENERATE(0.1, 0.0); // s: smooth, and at once
    Scene scene = elastic_scene(box({0, 0}, {0.4, 1.0}), {-0.2, 0}, {0.8, 1.2});
    scene.walls = {wall("bottom", 0.0), wall("top", 1.0, "roller", -0.05)};
    scene.walls[1].ramp = ramp;
    scene.stages[0].moves = {"top"};
    auto simulation = start(scene);
    // Means over whole periods of the column's slowest vibration, 4 H / c = 54 ms at most: what is left is the linear field.
    const int steps = 2700; // 0.54 s
    Vector moved = Vector::Zero();
    double top_row = 0.0, gained = 0.0;
    int counted = 0;
    for (int k = 0; k < steps; ++k) {
        take_steps(*simulation, 1);
        if (k < steps / 2) continue;
        const Points& p = simulation->points();
        ++counted;
        for (std::size_t i = 0; i < p.count(); ++i)
            if (p.initial_position[i][1] > 0.95) top_row += p.velocity[i][1] / 8.0; // 8 points in the uppermost row, at y = 0.975
        double momentum = 0.0, mass = 0.0;
        for (std::size_t i = 0; i < p.count(); ++i) {
            momentum += p.mass[i] * p.velocity[i][1];
            mass += p.mass[i];
        }
        gained += momentum / mass;
    }
    moved[1] = -0.05 * 0.975;
    CHECK(std::abs(top_row / counted - moved[1]) < 0.03 * 0.05);   // the mapped field is off by a few per cent at a boundary
    CHECK(std::abs(gained / counted + 0.05 / 2.0) < 0.03 * 0.05);  // the mean of a linear field: half the plate's velocity
}
