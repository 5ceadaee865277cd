// Bodies that drop, collide, spin, tear, stand for ever and lie badly in their grid.
#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "tests/hard/hard_case.hpp"
#include "tests/mpm-driver/fault_text.hpp"
#include "tests/mpm-driver/mechanics/small_scenes.hpp"

using namespace talik;
using namespace talik::driver;
using namespace talik::driver::tests;
using namespace talik::hard;

namespace {

const Invariant momentum_kept{"momentum error, of all impulses", 1e-12, "each force has its counter-force: rounding"};
const Invariant no_gain{"energy gained at the end, of what was put in", 1e-3, "a symplectic step keeps a shadow of the energy: what an event borrows it gives back"};
const Invariant shadow{"energy gained on the way, of half of what kinetic energy changes by in a step", 1, "the shadow energy of the symplectic step, H + dt/2 dK/dt"};
const Invariant energy_books{"ledger's energy residual, of the input work", 1e-2, "the law's account by the trapezoid of its increments, second order in them"};

double wave_speed() { return std::sqrt(p_wave / 2000.0); } // m/s

double energy(const Simulation& s) { return s.ledger().kinetic + s.ledger().law_energy; } // J

void set_noise(Simulation& simulation, double speed) {
    Points& points = simulation.points();
    for (std::size_t p = 0; p < points.count(); ++p) points.velocity[p] += speed * Vector(std::sin(37.0 * static_cast<double>(p)), std::cos(53.0 * static_cast<double>(p)));
}

// Energy while a body meets something: what it gains, and by how much its kinetic energy changes in a step, at most. J
struct Watch {
    explicit Watch(double energy_before) : before(energy_before), last_kinetic(energy_before) {}
    void look(const Simulation& s) {
        gained = std::max(gained, energy(s) - before);
        exchanged = std::max(exchanged, std::abs(s.ledger().kinetic - last_kinetic));
        last_kinetic = s.ledger().kinetic;
    }
    void judge(HardCase& hard, const Simulation& s) const {
        hard.holds(shadow, gained / (0.5 * exchanged));
        hard.holds(no_gain, energy(s) / before - 1.0);
    }
    double before, last_kinetic, gained = 0.0, exchanged = 0.0;
};

double kinetic(const Simulation& simulation) { // J, before the first step
    double sum = 0.0;
    const Points& points = simulation.points();
    for (std::size_t p = 0; p < points.count(); ++p) sum += 0.5 * points.mass[p] * points.velocity[p].squaredNorm();
    return sum;
}

// Energy of a body with a little noise, after 2,000 steps over that before.
double growth(Simulation& simulation) {
    set_noise(simulation, 1e-6);
    const double before = kinetic(simulation);
    take_steps(simulation, 2000);
    return energy(simulation) / before - 1.0;
}

} // namespace

TEST_CASE("a block dropped at 20 m per s bounces with the stress of the impact and keeps its books", "[hard][mpm]") {
    HardCase hard("MPM", "a block dropped at 20 m/s", "points pass the wall, stresses explode, energy is made");
    const Invariant stress{"largest stress over rho c v of a plane impact", 2.0, "rho c v, doubled where two waves meet"};
    const Invariant depth{"depth beneath the wall, cells", 0.5, "the wall holds the grid's velocity at its face, points by half their size"};
    for (const int per_cell : {4, 16}) {
        Scene scene = elastic_scene(box({0.3, 0.02}, {0.7, 0.42}, per_cell), {0, -0.2}, {1, 1.2});
        scene.bodies[0].velocity = {0.0, -20.0};
        scene.walls = {wall("bottom", 0.0)};
        scene.walls[0].separates = true;
        scene.stages[0].gravity = {0.0, -9.81};
        scene.step.fixed.reset();
        auto simulation = start(scene);
        const double before = kinetic(*simulation);
        double most = 0.0, lowest = 0.0;
        while (simulation->time() < 0.03) {
            take_steps(*simulation, 1);
            most = std::max(most, largest_stress(*simulation));
            for (const Vector& x : simulation->points().position) lowest = std::min(lowest, x[1]);
        }
        const std::string variant = fmt::format("{} points per cell", per_cell);
        hard.holds(stress, most / (2000.0 * wave_speed() * 20.0), variant);
        hard.holds(depth, -lowest / 0.1, variant);
        hard.holds(no_gain, energy(*simulation) / (before + simulation->ledger().gravity_work) - 1.0, variant);
        hard.holds(momentum_kept, simulation->ledger().momentum_error(), variant);
    }
}

TEST_CASE("two bodies that collide keep their momentum and make no energy", "[hard][mpm]") {
    HardCase hard("MPM", "two bodies colliding at 20 m/s", "momentum leaks, energy is made where their points mix");
    Scene scene = elastic_scene(box({0.13, 0.31}, {0.43, 0.61}), {-0.4, 0}, {1.8, 1});
    scene.bodies.push_back(scene.bodies[0]);
    scene.bodies[1] = box({0.55, 0.35}, {0.85, 0.65});
    scene.bodies[1].name = "other";
    scene.bodies[0].velocity = {10.0, 0.0};
    scene.bodies[1].velocity = {-10.0, 0.0};
    scene.step.fixed.reset();
    auto simulation = start(scene);
    Watch watch(kinetic(*simulation));
    while (simulation->time() < 0.04) {
        take_steps(*simulation, 1);
        watch.look(*simulation);
    }
    const Invariant momentum{"momentum gained, of one body's", 1e-12, "no force from outside: rounding"};
    hard.holds(momentum, simulation->ledger().momentum.norm() / (0.09 * 2000.0 * 10.0));
    watch.judge(hard, *simulation);
    hard.holds(energy_books, simulation->ledger().energy_error());
}

namespace {

struct Spun {
    double turn_lost, energy_gained, momentum_error; // relative
};

// A body of so many cells that turns by half a radian while it flies over ten cells of 0.1 m.
Spun spin(int cells) {
    const double size = 0.4, spin = 5.0, speed = 10.0, cell = size / cells; // m, 1/s, m/s, m
    Scene scene = elastic_scene(box({0.3, 0.3}, {0.7, 0.7}), {0, 0}, {2.4, 1}, cell);
    scene.step.fixed.reset();
    auto simulation = start(scene);
    Points& points = simulation->points();
    for (std::size_t p = 0; p < points.count(); ++p) points.velocity[p] = Vector(speed - spin * (points.position[p][1] - 0.5), spin * (points.position[p][0] - 0.5));
    const auto turn = [&] { // angular momentum about the centre, kg m2/s
        double sum = 0.0;
        Vector centre = Vector::Zero(), mean = Vector::Zero();
        const double share = 1.0 / static_cast<double>(points.count());
        for (std::size_t p = 0; p < points.count(); ++p) centre += share * points.position[p], mean += share * points.velocity[p];
        for (std::size_t p = 0; p < points.count(); ++p) {
            const Vector arm = points.position[p] - centre, v = points.velocity[p] - mean;
            sum += points.mass[p] * (arm[0] * v[1] - arm[1] * v[0]);
        }
        return sum;
    };
    const double before = kinetic(*simulation), turn_before = turn();
    while (simulation->time() < 0.1) take_steps(*simulation, 1);
    return {1.0 - turn() / turn_before, energy(*simulation) / before - 1.0, simulation->ledger().momentum_error()};
}

} // namespace

TEST_CASE("a body that spins across cells makes no energy and loses less of its turn the finer the grid", "[hard][mpm]") {
    HardCase hard("MPM", "a rotating body crossing cells", "crossings kick points, the spin feeds a stress");
    const Invariant finer{"angular momentum lost with twice the cells over that lost with once", 0.6, "the grid's error is at the body's edge: first order in the cell, a half"};
    const Spun coarse = spin(4), fine = spin(8);
    WARN("angular momentum lost over 0.5 rad: " << coarse.turn_lost << " with 4 x 4 cells, " << fine.turn_lost << " with 8 x 8");
    hard.holds(finer, fine.turn_lost / coarse.turn_lost);
    for (const Spun& spun : {coarse, fine}) {
        hard.holds(no_gain, spun.energy_gained);
        hard.holds(momentum_kept, spun.momentum_error);
    }
}

namespace {

void check_column(int steps, const char* name) {
    HardCase hard("MPM", name, "rounding and cell crossings make it creep");
    const Invariant creep{"displacement since it settled, of the settlement", 1e-9, "equilibrium to the rounding of stresses and positions"};
    Scene scene = elastic_scene(box({0.0, 0.0}, {0.1, 1.0}), {-0.1, -0.1}, {0.3, 1.3});
    scene.walls = {wall("left", 0.0), wall("right", 0.1), wall("bottom", 0.0)};
    scene.stages[0].gravity = {0.0, -9.81};
    scene.stages[0].particle_damping = 60.0;
    scene.step.fixed.reset();
    auto simulation = start(scene);
    take_steps(*simulation, 8000);
    const std::vector<Vector> settled = simulation->points().position;
    take_steps(*simulation, steps);
    const Points& points = simulation->points();
    double most = 0.0, settlement = 0.0;
    for (std::size_t p = 0; p < points.count(); ++p) {
        most = std::max(most, (points.position[p] - settled[p]).norm());
        settlement = std::max(settlement, points.displacement(p).norm());
    }
    hard.holds(creep, most / settlement);
}

} // namespace

TEST_CASE("an elastic column rests for twenty thousand steps", "[hard][mpm]") { check_column(20000, "an elastic column at rest for 2e4 steps"); }
TEST_CASE("an elastic column rests for a million steps", "[hard][mpm][long]") { check_column(1000000, "an elastic column at rest for 1e6 steps"); }

TEST_CASE("a lone point flies on its parabola", "[hard][mpm]") {
    HardCase hard("MPM", "a lone point in flight", "it loses speed at cell borders or strains itself");
    const Invariant path{"distance from the parabola, of the path", 1e-12, "one point alone: the grid gives back what it got; rounding of 1,000 steps"};
    const Invariant strain{"largest stress, Pa", 1e-6, "a rigid motion: rounding (1e-16) of E"};
    Scene scene = elastic_scene(box({0.3, 0.3}, {0.4, 0.4}, 1), {0, 0}, {3, 3});
    scene.bodies[0].velocity = {3.3, 4.7};
    scene.stages[0].gravity = {0.0, -9.81};
    auto simulation = start(scene);
    REQUIRE(simulation->points().count() == 1);
    const Vector from = simulation->points().position[0];
    take_steps(*simulation, 1000);
    const double t = simulation->time();
    const Vector exact = from + t * Vector(3.3, 4.7 - 0.5 * 9.81 * t);
    hard.holds(path, (simulation->points().position[0] - exact).norm() / (exact - from).norm());
    hard.holds(strain, largest_stress(*simulation));
}

TEST_CASE("one point in a cell and a hundred and twelve in a cell keep noise from growing", "[hard][mpm]") {
    HardCase hard("MPM", "one point in a cell, 112 in a cell", "too few points leave cells empty, many make nodes stiff");
    const Invariant stable{"energy gained over 2,000 steps, relative", 0.01, "an unstable mode grows by orders of magnitude"};
    for (const int bodies : {1, 7}) {
        Scene scene = elastic_scene(box({0.337, 0.337}, {0.737, 0.637}, bodies == 1 ? 1 : 16), {0, 0}, {1, 1});
        scene.bodies[0].density = 2000.0 / bodies;
        scene.elastic->young /= bodies;
        for (int b = 1; b < bodies; ++b) {
            scene.bodies.push_back(scene.bodies[0]);
            scene.bodies.back().name = fmt::format("body {}", b);
        }
        scene.step.fixed.reset();
        auto simulation = start(scene);
        hard.holds(stable, growth(*simulation), bodies == 1 ? "1 per cell" : "112 per cell");
    }
}

TEST_CASE("cells cut by a billionth of themselves keep noise from growing", "[hard][mpm]") {
    HardCase hard("MPM", "badly cut cells", "a node that is barely reached has no mass: a huge acceleration");
    const Invariant stable{"energy gained over 2,000 steps, relative", 0.01, "an unstable mode grows by orders of magnitude"};
    for (const int per_cell : {1, 4, 16})
        for (const double cut : {1e-3, 1e-6, 1e-9, 1e-12, 1e-14}) {
            const double corner = 0.3 - 0.1 * cut;
            Scene scene = elastic_scene(box({corner, corner}, {corner + 0.4, corner + 0.3}, per_cell), {0, 0}, {1, 1});
            scene.step.fixed.reset();
            auto simulation = start(scene);
            hard.holds(stable, growth(*simulation), fmt::format("{} per cell, by {:g}", per_cell, cut));
        }
}

TEST_CASE("points at the very edge of the grid move like others", "[hard][mpm]") {
    HardCase hard("MPM", "points at the grid's edge", "supports reach out of the arrays, ghosts take mass");
    const Invariant mass{"mass error, relative", 1e-14, "the weights of a point add up to 1: rounding"};
    const Invariant stable{"energy gained over 2,000 steps, relative", 0.01, "an unstable mode grows by orders of magnitude"};
    Scene scene = elastic_scene(box({0.0, 0.0}, {0.5, 0.4}), {0, 0}, {0.5, 0.4});
    scene.walls = {wall("left", 0.0), wall("right", 0.5), wall("bottom", 0.0), wall("top", 0.4)};
    scene.step.fixed.reset();
    auto simulation = start(scene);
    hard.holds(stable, growth(*simulation));
    hard.holds(mass, simulation->ledger().mass_error());
    simulation->points().position[0] = {0.0, 0.0}; // on the corner to the bit
    take_steps(*simulation, 1);
    simulation->points().position[0] = {-1e-3, 0.0};
    CHECK(says(fault_of([&] { take_steps(*simulation, 1); }), "point 0"));
}

TEST_CASE("a bar torn to five times its length breaks in its grid and its parts fly on", "[hard][mpm]") {
    HardCase hard("MPM", "numerical fracture of uGIMP under stretch", "gaps between points: forces without counter-force, energy from nothing");
    Scene scene = elastic_scene(box({2.0, 0.3}, {3.0, 0.5}), {0, 0}, {5, 0.8});
    scene.step.fixed.reset();
    auto simulation = start(scene);
    Points& points = simulation->points();
    for (std::size_t p = 0; p < points.count(); ++p) points.velocity[p] = {60.0 * (points.position[p][0] - 2.5), 0.0};
    Watch watch(kinetic(*simulation));
    while (simulation->time() < 0.06) {
        take_steps(*simulation, 1);
        watch.look(*simulation);
    }
    const Invariant momentum{"momentum gained, of |momentum| of its points", 1e-12, "no force from outside: rounding"};
    double size = 0.0;
    for (std::size_t p = 0; p < points.count(); ++p) size += points.mass[p] * points.velocity[p].norm();
    hard.holds(momentum, simulation->ledger().momentum.norm() / size);
    watch.judge(hard, *simulation);
    hard.holds(energy_books, simulation->ledger().energy_error());
}

TEST_CASE("a point pressed to a millionth of its volume keeps a volume and one turned inside out is named", "[hard][mpm]") {
    HardCase hard("MPM", "a point pressed to J -> 0", "J <= 0: negative volume, NaN in the law");
    const Invariant volume{"J against exp of what was imposed, relative", 1e-9, "F follows exp(dt L): rounding of 10,000 factors"};
    Scene scene = elastic_scene(box({0.45, 0.45}, {0.55, 0.55}), {0, 0}, {1, 1});
    scene.step.fixed.reset();
    auto simulation = start(scene);
    PrescribedField field;
    field.velocity_gradient << -50.0, 0.0, 0.0, -50.0;
    field.centre = {0.5, 0.5};
    simulation->prescribe(field);
    while (simulation->points().volume[0] > 1e-6 * simulation->points().initial_volume[0]) take_steps(*simulation, 1);
    const double j = simulation->points().volume[0] / simulation->points().initial_volume[0];
    hard.holds(volume, std::abs(j / std::exp(-100.0 * simulation->time()) - 1.0));
    CHECK(std::isfinite(largest_stress(*simulation)));
    field.velocity_gradient << -1e4, 0.0, 0.0, 0.0;
    simulation->prescribe(field);
    CHECK(says(fault_of([&] { take_steps(*simulation, 1); }), "is turned inside out in step"));
}
