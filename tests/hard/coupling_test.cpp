// Driver and farm together where it is rough: a fall at 20 m/s, a column that collapses, thaw of everything at a blow, cycles
// of frost under weight.
#include <algorithm>
#include <cmath>
#include <string>

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

const Invariant energy_books{"ledger's energy residual, of the input work", 0.02, "the RVEs' stress is taken at the ends of a step: its trapezoid is of second order in strains of up to 1 % a step"};
const Invariant momentum_kept{"momentum error, of all impulses", 1e-12, "each force has its counter-force: rounding"};

// Small RVEs of 30 discs at 20 kPa, in the scene's folder.
lockstep::Prepared grains(const lockstep::TemporaryFolder& folder, bool bonds = false) {
    lockstep::Prepared made = lockstep::prepare(lockstep::write_tiny_scene(folder, {{"discs", "discs = 30\npressure = \"20 kPa\""}}), folder / "cache");
    if (bonds) made.setup.parameters.bond = BondParameters{2e6, 2e6, 1.0, true, 0.5};
    made.scene.rve->parameters = made.setup.parameters;
    made.scene.confining_pressure = 0.0;
    made.scene.step.fixed.reset();
    return made;
}

void run_to(Simulation& simulation, double time) {
    while (simulation.time() < time * (1.0 - 1e-9)) simulation.step(std::min(simulation.next_step(), time - simulation.time()));
}

std::string shares(const Simulation& s) {
    std::string text;
    for (std::size_t k = 0; k < static_cast<std::size_t>(Help::count); ++k)
        if (const auto& r = s.self_help().record(static_cast<Help>(k)); r.count > 0.0) text += fmt::format("{} {:.0f} ", kind_of(static_cast<Help>(k)).name, r.count);
    return text;
}

} // namespace

TEST_CASE("a block of grains dropped at 20 m per s lands, helps itself, and keeps its books", "[hard][coupling]") {
    HardCase hard("coupling", "a block of RVEs dropped at 20 m/s", "strain of per cents in a step: RVEs fly apart or are asked for what they cannot follow");
    const lockstep::TemporaryFolder folder;
    lockstep::Prepared made = grains(folder);
    Scene& scene = made.scene;
    scene.domain.origin = {-0.5, 0.0};
    scene.domain.size = {1.2, 1.0};
    scene.bodies[0].velocity = {0.0, -20.0};
    scene.walls = {wall("bottom", 0.0)};
    scene.walls[0].separates = true;
    scene.stages[0] = StageSpec();
    scene.stages[0].duration = 1.0;
    scene.stages[0].gravity = {0.0, -9.81};
    lockstep::FarmInThread farm("loopback", 1);
    {
        lockstep::Coupled run(made, farm);
        run_to(*run.simulation, 0.02);
        const Ledger& ledger = run.simulation->ledger();
        INFO(shares(*run.simulation));
        hard.holds(energy_books, ledger.energy_error());
        hard.holds(momentum_kept, ledger.momentum_error());
        hard.holds({"extra sub-steps that were not counted", 0, "every event is counted"}, run.simulation->self_help().record(Help::extra_sub_steps).count == static_cast<double>(run.law->split_steps()) ? 0 : 1);
        CHECK(run.law->split_steps() > 0);
        run.law->bye();
    }
    farm.join();
}

TEST_CASE("a column ten times as high as wide collapses onto its base", "[hard][coupling]") {
    HardCase hard("coupling", "a column 10 : 1 collapsing onto the base", "RVEs open and close, points part, the foot is crushed");
    const Invariant top{"height left, of the column's", 0.7, "frictional grains do not stand ten times as high as wide"};
    const lockstep::TemporaryFolder folder;
    lockstep::Prepared made = grains(folder);
    Scene& scene = made.scene;
    scene.domain.origin = {-0.8, 0.0};
    scene.domain.size = {1.7, 1.2};
    scene.bodies[0].polygon = {{0, 0}, {0.1, 0}, {0.1, 1.0}, {0, 1.0}};
    scene.walls = {wall("bottom", 0.0, "fixed")};
    scene.stages[0] = StageSpec();
    scene.stages[0].duration = 10.0;
    scene.stages[0].gravity = {0.3, -9.81}; // a little to one side
    lockstep::FarmInThread farm("loopback", 1);
    {
        lockstep::Coupled run(made, farm);
        run_to(*run.simulation, 0.6);
        double highest = 0.0;
        for (const Vector& x : run.simulation->points().position) highest = std::max(highest, x[1]);
        INFO(shares(*run.simulation));
        hard.holds(top, highest / 1.0);
        hard.holds(energy_books, run.simulation->ledger().energy_error());
        hard.holds(momentum_kept, run.simulation->ledger().momentum_error());
        run.law->bye();
    }
    farm.join();
}

namespace {

// Frozen RVEs between walls, under weight; ground that may thaw at a blow or in cycles.
lockstep::Prepared frozen_ground(const lockstep::TemporaryFolder& folder) {
    lockstep::Prepared made = grains(folder, true);
    Scene& scene = made.scene;
    scene.walls = {wall("bottom", 0.0), wall("left", 0.0), wall("right", 0.2)};
    scene.heat.emplace();
    ThermalMaterialSpec soil = soil_material();
    soil.residual_temperature = -0.5;
    scene.heat->materials = {soil};
    scene.bodies[0].material = "soil";
    scene.bodies[0].temperature = -1.0;
    scene.stages[0] = StageSpec();
    scene.stages[0].duration = 1000.0;
    scene.stages[0].gravity = {0.0, -9.81};
    scene.stages[0].activates = {"bonds"};
    scene.stages[0].particle_damping = 5.0;
    scene.confining_pressure = 2e4;
    return made;
}

} // namespace

TEST_CASE("frozen ground that thaws within one step loses its bonds at a blow and stays in one piece", "[hard][coupling]") {
    HardCase hard("coupling", "full thaw of bonded ground within one step", "every bond fails at once: RVEs throw their discs apart");
    const lockstep::TemporaryFolder folder;
    lockstep::Prepared made = frozen_ground(folder);
    HeatSourceSpec blow;
    blow.name = "blow";
    blow.value.constant = 1e12; // W/m^3: 0.5 ms melt it all
    made.scene.heat->sources = {blow};
    lockstep::FarmInThread farm("loopback", 1);
    {
        lockstep::Coupled run(made, farm);
        Simulation& simulation = *run.simulation;
        simulation.step(simulation.next_step());
        double ice = 0.0;
        for (double s : simulation.points().ice_saturation) ice = std::max(ice, s);
        hard.holds({"ice left after one step, -", 0, "the heat of the step is more than the latent heat"}, ice);
        for (int k = 0; k < 100; ++k) simulation.step(simulation.next_step());
        hard.holds({"heat balance, relative", 1e-12, "what nodes receive points receive: rounding"}, balance(simulation));
        hard.holds(energy_books, simulation.ledger().energy_error());
        double volume = 0.0;
        for (std::size_t p = 0; p < simulation.points().count(); ++p) volume = std::max(volume, std::abs(simulation.points().volume[p] / simulation.points().initial_volume[p] - 1.0));
        hard.holds({"change of a point's volume, -", 0.05, "between walls and under pressure: as much as a loose packing can settle"}, volume);
        run.law->bye();
    }
    farm.join();
}

TEST_CASE("fifty cycles of frost and thaw under weight with bonds that form anew stay in bounds", "[hard][coupling]") {
    HardCase hard("coupling", "50 freeze-thaw cycles under load", "settlement that never ends, heat from nothing");
    const lockstep::TemporaryFolder folder;
    lockstep::Prepared made = frozen_ground(folder);
    const double period = 0.02; // s of the scene: 30 steps
    HeatSourceSpec cycle;
    cycle.name = "cycle";
    const double latent = 333e3 * 1000.0 * 0.43; // J/m^3
    cycle.value.constant = 0.0;
    cycle.value.amplitude = 1.3 * M_PI * latent / period;
    cycle.value.period = period;
    made.scene.heat->sources = {cycle};
    lockstep::FarmInThread farm("loopback", 1);
    {
        lockstep::Coupled run(made, farm);
        Simulation& simulation = *run.simulation;
        double least = 1.0, most = 0.0, height = 0.0;
        for (int k = 0; k < 100; ++k) { // half cycles
            run_to(simulation, (k + 1) * period / 2);
            for (double s : simulation.points().ice_saturation) least = std::min(least, s), most = std::max(most, s);
        }
        for (std::size_t p = 0; p < simulation.points().count(); ++p) height = std::max(height, std::abs(simulation.points().displacement(p)[1]));
        INFO(shares(simulation));
        CHECK(least < 0.1);
        CHECK(most > 0.9);
        hard.holds({"heat balance, relative", 1e-12, "what nodes receive points receive: rounding"}, balance(simulation));
        hard.holds({"settlement, of the height", 0.1, "as much as a loose packing can settle"}, height / 0.2);
        hard.holds(energy_books, simulation.ledger().energy_error());
        run.law->bye();
    }
    farm.join();
}
