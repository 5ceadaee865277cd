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

const Invariant momentum_kept{"momentum error, of all impulses", 1e-12, "each force has its counter-force: rounding of 1e4 sums"};
const Invariant shadow{"energy gained on the way, of half of what kinetic energy changes by in a step", 1, "the shadow energy of the symplectic step, H + dt/2 dK/dt"};
const Invariant no_gain{"energy gained at the end beyond its swing in the last step, of what was put in", 0,
                        "FLIP gives points no more than nodes got (Jensen); the symplectic step keeps H + dt/2 dK/dt: H swings by half of what K changes by in a step"};

double wave_speed() { return std::sqrt(p_wave / 2000.0); } // m/s

double energy(const Simulation& s) { return s.ledger().kinetic + s.ledger().law_energy; } // J

void set_noise(Simulation& simulation, double speed) {
    Points& points = simulation.points();
    for (std::size_t p = 0; p < points.count(); ++p) points.velocity[p] += speed * Vector(std::sin(37.0 * static_cast<double>(p)), std::cos(53.0 * static_cast<double>(p)));
}

double kinetic(const Simulation& simulation) { // J, before the first step
    double sum = 0.0;
    const Points& points = simulation.points();
    for (std::size_t p = 0; p < points.count(); ++p) sum += 0.5 * points.mass[p] * points.velocity[p].squaredNorm();
    return sum;
}

std::unique_ptr<Simulation> start_automatic(Scene scene) { // step = "auto"
    scene.step.fixed.reset();
    return start(scene);
}

// A run whose energy is looked at in every step: what it gains, what its kinetic energy changes by in a step, how far points turn.
class Watch {
public:
    explicit Watch(Simulation& simulation) : simulation_(simulation), before_(kinetic(simulation)), last_kinetic_(before_) {}
    void step() {
        take_steps(simulation_, 1);
        gained_ = std::max(gained_, energy(simulation_) - put_in());
        last_exchange_ = std::abs(simulation_.ledger().kinetic - last_kinetic_);
        exchange_ = std::max(exchange_, last_exchange_);
        last_kinetic_ = simulation_.ledger().kinetic;
        for (const Matrix& l : simulation_.points().displacement_gradient_increment) turn_ = std::max(turn_, std::abs(l(1, 0) - l(0, 1)) / 2);
    }
    void to(double time) {
        while (simulation_.time() < time) step();
    }
    void steps(int count) {
        for (int k = 0; k < count; ++k) step();
    }
    void judge_end(HardCase& hard, const std::string& variant = "") const { hard.holds(no_gain, (energy(simulation_) - 0.5 * last_exchange_) / put_in() - 1.0, variant); }
    void judge_way(HardCase& hard) const { hard.holds(shadow, gained_ / (0.5 * exchange_)); }
    // The law turns the stress by half before and by half after it strains it, the ledger takes the mean of both ends: they differ
    // by theta^2/4 at either end, theta the turn of a step, of the work that goes in and comes out.
    void judge_books(HardCase& hard) const {
        hard.holds({"ledger's energy residual, of the input work", turn_ * turn_, "the trapezoid's error in a step that turns by theta: theta^2/2 of the work in, and of that out"}, simulation_.ledger().energy_error());
    }

private:
    double put_in() const { return before_ + simulation_.ledger().gravity_work; } // J

    Simulation& simulation_;
    double before_, last_kinetic_, last_exchange_ = 0.0, gained_ = 0.0, exchange_ = 0.0, turn_ = 0.0;
};

// A body with a little noise over 2,000 steps, which an unstable mode would make grow by orders of magnitude.
void check_noise(HardCase& hard, Simulation& simulation, const std::string& variant = "") {
    set_noise(simulation, 1e-6);
    Watch watch(simulation);
    watch.steps(2000);
    watch.judge_end(hard, variant);
}

} // namespace

TEST_CASE("a block dropped at 20 m per s bounces with the stress of the impact and keeps its books", "[hard][mpm]") {
    HardCase hard("MPM", "a block dropped at 20 m/s", "points pass the wall, stresses explode, energy is made");
    const Invariant stress{"largest stress over rho c v of a plane impact", 2.0, "the cell at the wall is an oscillator without damping under a sudden load of rho c v: at most twice that"};
    for (const int per_cell : {4, 16}) {
        Scene scene = elastic_scene(box({0.3, 0.02}, {0.7, 0.42}, per_cell), {0, -0.2}, {1, 1.2});
        scene.bodies[0].velocity = {0.0, -20.0};
        scene.walls = {wall("bottom", 0.0)};
        scene.walls[0].separates = true;
        scene.stages[0].gravity = {0.0, -9.81};
        auto simulation = start_automatic(scene);
        Watch watch(*simulation);
        double most = 0.0, lowest = 0.0;
        while (simulation->time() < 0.03) {
            watch.step();
            most = std::max(most, largest_stress(*simulation));
            for (const Vector& x : simulation->points().position) lowest = std::min(lowest, x[1]);
        }
        const std::string variant = fmt::format("{} points per cell", per_cell);
        hard.holds(stress, most / (2000.0 * wave_speed() * 20.0), variant);
        hard.holds({"depth beneath the wall, cells", 0.5 / std::sqrt(per_cell), "a point sinks until it no longer reaches the nodes above the wall: half its size"}, -lowest / 0.1, variant);
        watch.judge_end(hard, variant);
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
    auto simulation = start_automatic(scene);
    Watch watch(*simulation);
    watch.to(0.04);
    const Invariant momentum{"momentum gained, of one body's", 1e-12, "no force from outside: rounding"};
    hard.holds(momentum, simulation->ledger().momentum.norm() / (0.09 * 2000.0 * 10.0));
    watch.judge_way(hard);
    watch.judge_end(hard);
    watch.judge_books(hard);
}

namespace {

// A body of so many cells that turns by half a radian while it flies over ten cells of 0.1 m: the share of its turn that it loses.
double spin(HardCase& hard, int cells) {
    const double size = 0.4, spin = 5.0, speed = 10.0, cell = size / cells; // m, 1/s, m/s, m
    Scene scene = elastic_scene(box({0.3, 0.3}, {0.7, 0.7}), {0, 0}, {2.4, 1}, cell);
    auto simulation = start_automatic(scene);
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
    Watch watch(*simulation);
    const double turn_before = turn();
    watch.to(0.1);
    const std::string variant = fmt::format("{0} x {0} cells", cells);
    watch.judge_end(hard, variant);
    hard.holds(momentum_kept, simulation->ledger().momentum_error(), variant);
    return 1.0 - turn() / turn_before;
}

} // namespace

TEST_CASE("a body that spins across cells makes no energy and loses less of its turn the finer the grid", "[hard][mpm]") {
    HardCase hard("MPM", "a rotating body crossing cells", "crossings kick points, the spin feeds a stress");
    const Invariant finer{"angular momentum lost with twice the cells over that lost with once", 0.5, "the grid's error is at the body's edge: first order in the cell at least"};
    const double coarse = spin(hard, 4), fine = spin(hard, 8);
    WARN("angular momentum lost over 0.5 rad: " << coarse << " with 4 x 4 cells, " << fine << " with 8 x 8");
    hard.holds(finer, fine / coarse);
}

namespace {

void check_column(int steps, const char* name) {
    HardCase hard("MPM", name, "rounding and cell crossings make it creep");
    const Invariant creep{"displacement since it settled, of the settlement", 1e-9, "positions of 1 m known to 1e-16 m, a walk of 1e6 steps: 4e-13 m of a settlement of 9e-4 m, twice"};
    Scene scene = elastic_scene(box({0.0, 0.0}, {0.1, 1.0}), {-0.1, -0.1}, {0.3, 1.3});
    scene.walls = {wall("left", 0.0), wall("right", 0.1), wall("bottom", 0.0)};
    scene.stages[0].gravity = {0.0, -9.81};
    scene.stages[0].particle_damping = 60.0;
    auto simulation = start_automatic(scene);
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
    const Invariant path{"distance from the parabola, of the path", 1e-12, "one point alone: the grid gives back what it got; rounding of 1,000 steps, ten sums each"};
    const Invariant strain{"largest stress, Pa", 1e-6, "a rigid motion: rounding (1e-16) of E = 1e7 Pa in each of 1,000 steps"};
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
    for (const int bodies : {1, 7}) {
        Scene scene = elastic_scene(box({0.337, 0.337}, {0.737, 0.637}, bodies == 1 ? 1 : 16), {0, 0}, {1, 1});
        scene.bodies[0].density = 2000.0 / bodies;
        scene.elastic->young /= bodies;
        for (int b = 1; b < bodies; ++b) {
            scene.bodies.push_back(scene.bodies[0]);
            scene.bodies.back().name = fmt::format("body {}", b);
        }
        auto simulation = start_automatic(scene);
        check_noise(hard, *simulation, bodies == 1 ? "1 per cell" : "112 per cell");
    }
}

TEST_CASE("cells cut by a billionth of themselves keep noise from growing", "[hard][mpm]") {
    HardCase hard("MPM", "badly cut cells", "a node that is barely reached has no mass: a huge acceleration");
    for (const int per_cell : {1, 4, 16})
        for (const double cut : {1e-3, 1e-6, 1e-9, 1e-12, 1e-14}) {
            const double corner = 0.3 - 0.1 * cut;
            Scene scene = elastic_scene(box({corner, corner}, {corner + 0.4, corner + 0.3}, per_cell), {0, 0}, {1, 1});
            auto simulation = start_automatic(scene);
            check_noise(hard, *simulation, fmt::format("{} per cell, by {:g}", per_cell, cut));
        }
}

TEST_CASE("points at the very edge of the grid move like others", "[hard][mpm]") {
    HardCase hard("MPM", "points at the grid's edge", "supports reach out of the arrays, ghosts take mass");
    const Invariant mass{"mass error, relative", 1e-14, "the weights of a point add up to 1: rounding of 80 points"};
    Scene scene = elastic_scene(box({0.0, 0.0}, {0.5, 0.4}), {0, 0}, {0.5, 0.4});
    scene.walls = {wall("left", 0.0), wall("right", 0.5), wall("bottom", 0.0), wall("top", 0.4)};
    auto simulation = start_automatic(scene);
    check_noise(hard, *simulation);
    hard.holds(mass, simulation->ledger().mass_error());
    simulation->points().position[0] = {0.0, 0.0}; // on the corner to the bit
    take_steps(*simulation, 1);
    simulation->points().position[0] = {-1e-3, 0.0};
    CHECK(says(fault_of([&] { take_steps(*simulation, 1); }), "point 0"));
}

TEST_CASE("a bar torn to five times its length breaks in its grid and its parts fly on", "[hard][mpm]") {
    HardCase hard("MPM", "numerical fracture of uGIMP under stretch", "gaps between points: forces without counter-force, energy from nothing");
    Scene scene = elastic_scene(box({2.0, 0.3}, {3.0, 0.5}), {0, 0}, {5, 0.8});
    auto simulation = start_automatic(scene);
    Points& points = simulation->points();
    for (std::size_t p = 0; p < points.count(); ++p) points.velocity[p] = {60.0 * (points.position[p][0] - 2.5), 0.0};
    Watch watch(*simulation);
    watch.to(0.06);
    const Invariant momentum{"momentum gained, of |momentum| of its points", 1e-12, "no force from outside: rounding"};
    double size = 0.0;
    for (std::size_t p = 0; p < points.count(); ++p) size += points.mass[p] * points.velocity[p].norm();
    hard.holds(momentum, simulation->ledger().momentum.norm() / size);
    watch.judge_way(hard);
    watch.judge_end(hard);
    watch.judge_books(hard);
}

TEST_CASE("a point pressed to a millionth of its volume keeps a volume and one turned inside out is named", "[hard][mpm]") {
    HardCase hard("MPM", "a point pressed to J -> 0", "J <= 0: negative volume, NaN in the law");
    Scene scene = elastic_scene(box({0.45, 0.45}, {0.55, 0.55}), {0, 0}, {1, 1});
    auto simulation = start_automatic(scene);
    PrescribedField field;
    field.velocity_gradient << -50.0, 0.0, 0.0, -50.0;
    field.centre = {0.5, 0.5};
    simulation->prescribe(field);
    while (simulation->points().volume[0] > 1e-6 * simulation->points().initial_volume[0]) take_steps(*simulation, 1);
    const double j = simulation->points().volume[0] / simulation->points().initial_volume[0];
    hard.holds({"J against exp of what was imposed, relative", 20 * unit_double * simulation->steps_done(), "F follows exp(dt L): twenty roundings in each of its factors, all to one side"}, std::abs(j / std::exp(-100.0 * simulation->time()) - 1.0));
    CHECK(std::isfinite(largest_stress(*simulation)));
    field.velocity_gradient << -1e4, 0.0, 0.0, 0.0;
    simulation->prescribe(field);
    CHECK(says(fault_of([&] { take_steps(*simulation, 1); }), "is turned inside out in step"));
}
