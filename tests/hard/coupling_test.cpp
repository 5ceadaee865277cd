// Driver and farm together where it is rough: a fall at 20 m/s, a column that collapses, thaw of everything at a blow, cycles
// of frost under weight.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "tests/hard/hard_case.hpp"
#include "tests/lockstep/in_process.hpp"
#include "tests/mpm-driver/fault_text.hpp"
#include "tests/mpm-driver/heat/small_heat.hpp"

using namespace talik;
using namespace talik::hard;
using namespace talik::driver;
using namespace talik::driver::tests;

namespace {

const Invariant momentum_kept{"momentum error, of all impulses", 1e-12, "each force has its counter-force: rounding of 1e4 sums"};
const Invariant heat_kept{"heat balance, relative", 1e-12, "what nodes receive points receive: rounding of 1e4 sums"};

// Packings of 30 discs at 20 kPa, 16 RVEs in a block of 0.2 m, in the scene's folder.
lockstep::Prepared grains(const lockstep::TemporaryFolder& folder, const Vector& gravity, bool bonds = false) {
    lockstep::Prepared made = lockstep::prepare(lockstep::write_tiny_scene(folder, {{"discs", "discs = 30\npressure = \"20 kPa\""}}), folder / "cache");
    if (bonds) made.setup.parameters.bond = BondParameters{2e6, 2e6, 1.0, true, 0.5};
    Scene& scene = made.scene;
    scene.rve->parameters = made.setup.parameters;
    scene.confining_pressure = 0.0;
    scene.step.fixed.reset();
    scene.stages[0] = StageSpec();
    scene.stages[0].duration = 1000.0;
    scene.stages[0].gravity = gravity;
    return made;
}

// How far a packing can be compacted at most: from its void ratio to that of the densest of all, the triangular lattice.
double largest_settlement(const lockstep::Prepared& made) {
    const double densest = 2.0 * std::sqrt(3.0) / M_PI; // 1 + e, -
    double most = 0.0;
    for (const Packing& packing : made.setup.packings) most = std::max(most, 1.0 - densest / (1.0 + packing.void_ratio()));
    return most;
}

// What the ledger's trapezoid of V sigma : d eps can be wrong by, summed over steps and points without signs. Where the law is
// smooth it is of second order: with steps of twice the length the error is four times as large, so a third of the difference
// is the error. In a step within which the law jumps, the work lies between that of the stress before and that of the stress after.
class Trapezoid {
public:
    void look(const Points& points, bool law_jumps = false) {
        const auto& increment = points.displacement_gradient_increment; // of the step that ends now
        std::vector<Stress> now(points.count());                        // V sigma, J
        for (std::size_t p = 0; p < points.count(); ++p) now[p] = points.volume[p] * points.stress[p];
        for (std::size_t p = 0; p < points.count() && steps_ > 0; ++p) {
            if (law_jumps) error_ += std::abs(power(now[p] - middle_[p], increment[p])) / 2.0;
            if (steps_ % 2 == 0) error_ += std::abs(power(middle_[p] - now[p], increment_[p]) + power(middle_[p] - first_[p], increment[p])) / 6.0;
        }
        first_ = std::move(middle_), middle_ = std::move(now);
        increment_ = increment;
        ++steps_;
    }
    double error() const { return error_; } // J

private:
    static double power(const Stress& s, const Matrix& e) { return s[0] * e(0, 0) + s[1] * e(1, 1) + s[2] * (e(0, 1) + e(1, 0)); }
    std::vector<Stress> first_, middle_;
    std::vector<Matrix> increment_;
    double error_ = 0.0; // J
    int steps_ = 0;
};

// A run over a farm in a thread of this process.
struct Run {
    Simulation& simulation;
    FarmLaw& law;
    Trapezoid trapezoid;

    void step(double dt, bool law_jumps = false) {
        if (simulation.steps_done() == 0) trapezoid.look(simulation.points());
        simulation.step(dt);
        trapezoid.look(simulation.points(), law_jumps);
    }
    void to(double time, bool law_jumps = false) {
        while (simulation.time() < time * (1.0 - 1e-9)) step(std::min(simulation.next_step(), time - simulation.time()), law_jumps);
    }
    double help(Help kind) const { return simulation.self_help().record(kind).count; }
    void judge_books(HardCase& hard) const {
        std::string helped;
        for (std::size_t k = 0; k < static_cast<std::size_t>(Help::count); ++k)
            if (const double count = help(static_cast<Help>(k)); count > 0.0) helped += fmt::format("{} {:.0f} ", kind_of(static_cast<Help>(k)).name, count);
        INFO(helped);
        const Ledger& ledger = simulation.ledger();
        const double scale = std::max(ledger.input_work(), ledger.kinetic); // J
        hard.holds({"ledger's energy residual, of the input work", trapezoid.error() / scale,
                    "the trapezoid is of second order: a third of what it changes by with twice the step; where bonds fail at a blow, half of what that changes"},
                   ledger.energy_error());
        hard.holds(momentum_kept, ledger.momentum_error());
        if (simulation.heat()) hard.holds(heat_kept, balance(simulation));
    }
};

template <class Work>
void with_farm(const lockstep::Prepared& made, Work&& work) {
    lockstep::FarmInThread farm("loopback", 1);
    {
        lockstep::Coupled coupled(made, farm);
        Run run{*coupled.simulation, *coupled.law, {}};
        work(run);
        coupled.law->bye();
    }
    farm.join();
}

} // namespace

TEST_CASE("a block of grains dropped at 20 m per s lands, helps itself, and keeps its books", "[hard][coupling]") {
    HardCase hard("coupling", "a block of RVEs dropped at 20 m/s", "strain of per cents in a step: RVEs fly apart or are asked for what they cannot follow");
    const lockstep::TemporaryFolder folder;
    lockstep::Prepared made = grains(folder, {0.0, -9.81});
    Scene& scene = made.scene;
    scene.domain.origin = {-0.5, 0.0};
    scene.domain.size = {1.2, 1.0};
    scene.bodies[0].velocity = {0.0, -20.0};
    scene.walls = {wall("bottom", 0.0)};
    scene.walls[0].separates = true;
    with_farm(made, [&](Run& run) {
        run.to(0.02);
        run.judge_books(hard);
        hard.holds({"extra sub-steps that were not counted", 0, "every event is counted"}, run.help(Help::extra_sub_steps) == static_cast<double>(run.law.split_steps()) ? 0 : 1);
        CHECK(run.law.split_steps() > 0);
    });
}

TEST_CASE("a column ten times as high as wide collapses onto its base", "[hard][coupling]") {
    HardCase hard("coupling", "a column 10 : 1 collapsing onto the base", "RVEs open and close, points part, the foot is crushed");
    const double height = 1.0, half_width = 0.05, cell = 0.1, gravity = 9.81; // m, m/s^2
    const Invariant top{"height of nine tenths, of the column's", (half_width * std::pow(height / half_width, 0.4) + cell) / height,
                        "dry grains in a plane come to rest at a height of L (H/L)^(2/5), L half the width (Lube et al. 2005; Lajeunesse et al.: 1/3), after 3 sqrt(H/g); and a cell"};
    const lockstep::TemporaryFolder folder;
    lockstep::Prepared made = grains(folder, {0.3, -gravity}); // a little to one side
    Scene& scene = made.scene;
    scene.domain.origin = {-2.2, 0.0}; // room for single points that are thrown
    scene.domain.size = {4.5, 1.6};
    scene.bodies[0].polygon = {{0, 0}, {2 * half_width, 0}, {2 * half_width, height}, {0, height}};
    scene.walls = {wall("bottom", 0.0, "fixed")};
    with_farm(made, [&](Run& run) {
        run.to(3.0 * std::sqrt(height / gravity));
        std::vector<double> heights;
        for (const Vector& x : run.simulation.points().position) heights.push_back(x[1]);
        std::sort(heights.begin(), heights.end());
        hard.holds(top, heights[heights.size() * 9 / 10] / height);
        run.judge_books(hard);
    });
}

namespace {

// Frozen RVEs between walls, under weight; ground that may thaw at a blow or in cycles by a source of heat.
lockstep::Prepared frozen_ground(const lockstep::TemporaryFolder& folder, const HeatSourceSpec& source) {
    lockstep::Prepared made = grains(folder, {0.0, -9.81}, true);
    Scene& scene = made.scene;
    scene.walls = {wall("bottom", 0.0), wall("left", 0.0), wall("right", 0.2)};
    scene.heat.emplace();
    ThermalMaterialSpec soil = soil_material();
    soil.residual_temperature = -0.5;
    scene.heat->materials = {soil};
    scene.heat->sources = {source};
    scene.bodies[0].material = "soil";
    scene.bodies[0].temperature = -1.0;
    scene.stages[0].activates = {"bonds"};
    scene.stages[0].particle_damping = 5.0;
    scene.confining_pressure = 2e4;
    return made;
}

const char* const densest = "from the packings' void ratio to that of the triangular lattice, the densest there is";

} // namespace

TEST_CASE("frozen ground that thaws within one step loses its bonds at a blow and stays in one piece", "[hard][coupling]") {
    HardCase hard("coupling", "full thaw of bonded ground within one step", "every bond fails at once: RVEs throw their discs apart");
    const lockstep::TemporaryFolder folder;
    HeatSourceSpec blow;
    blow.name = "blow";
    blow.value.constant = 1e12; // W/m^3: 0.5 ms melt it all
    const lockstep::Prepared made = frozen_ground(folder, blow);
    with_farm(made, [&](Run& run) {
        run.step(run.simulation.next_step(), true); // all bonds fail between two answers
        const Points& points = run.simulation.points();
        hard.holds({"ice left after one step, -", 0, "the heat of the step is more than the latent heat"}, *std::max_element(points.ice_saturation.begin(), points.ice_saturation.end()));
        for (int k = 0; k < 100; ++k) run.step(run.simulation.next_step());
        run.judge_books(hard);
        double volume = 0.0;
        for (std::size_t p = 0; p < points.count(); ++p) volume = std::max(volume, std::abs(points.volume[p] / points.initial_volume[p] - 1.0));
        hard.holds({"change of a point's volume, -", largest_settlement(made), densest}, volume);
    });
}

TEST_CASE("fifty cycles of frost and thaw under weight with bonds that form anew stay in bounds", "[hard][coupling]") {
    HardCase hard("coupling", "50 freeze-thaw cycles under load", "settlement that never ends, heat from nothing");
    const lockstep::TemporaryFolder folder;
    const double period = 0.02;                  // s of the scene: 30 steps
    const double latent = 333e3 * 1000.0 * 0.43; // J/m^3
    HeatSourceSpec cycle;
    cycle.name = "cycle";
    cycle.value.constant = 0.0;
    cycle.value.amplitude = 1.3 * M_PI * latent / period;
    cycle.value.period = period;
    const lockstep::Prepared made = frozen_ground(folder, cycle);
    with_farm(made, [&](Run& run) {
        const Points& points = run.simulation.points();
        double least = 1.0, most = 0.0, settlement = 0.0;
        for (int k = 0; k < 100; ++k) { // half cycles
            run.to((k + 1) * period / 2, true); // bonds fail or form in any of the steps
            const auto [low, high] = std::minmax_element(points.ice_saturation.begin(), points.ice_saturation.end());
            least = std::min(least, *low), most = std::max(most, *high);
        }
        for (std::size_t p = 0; p < points.count(); ++p) settlement = std::max(settlement, std::abs(points.displacement(p)[1]));
        CHECK(least < 0.1);
        CHECK(most > 0.9);
        hard.holds({"settlement, of the height", largest_settlement(made), densest}, settlement / 0.2);
        run.judge_books(hard);
    });
}
