// A NaN or an infinite number put anywhere: found within one step, named with point, RVE and field, and never in a checkpoint.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <future>
#include <limits>
#include <string>

#include <fmt/format.h>

#include "common/base/version.hpp"
#include "common/io/hdf5_file.hpp"
#include "exchange/sealed_file.hpp"
#include "mpm-driver/output/checkpoint.hpp"
#include "tests/hard/every_kernel.hpp"
#include "tests/hard/hard_case.hpp"
#include "tests/lockstep/in_process.hpp"
#include "tests/mpm-driver/fault_text.hpp"
#include "tests/mpm-driver/heat/small_heat.hpp"

using namespace talik;
using namespace talik::hard;
using namespace talik::driver;
using namespace talik::driver::tests;
using farm::Status;

namespace {

const double no_numbers[] = {std::nan(""), HUGE_VAL, -HUGE_VAL};
const Invariant found{"injections not found within the step, or not named", 0, "a NaN poisons every sum it enters"};

Scene moving_heated() {
    Scene scene = heat_scene(soil_material(), {0.3, 0.2}, 0.1, -2.0);
    make_moving(scene, {0.3, 0.3}, 1e-3);
    scene.heat->boundaries = {held_side("left", 5.0)};
    return scene;
}

// Answers like a farm, but for one number of one answer.
class SpoilingService : public farm::Service {
public:
    using farm::Service::Service;
    void answer(const exchange::Batch& request, exchange::Batch& answer, exchange::Channel& progress) override {
        farm::Service::answer(request, answer, progress);
        if (++steps == spoilt_step) answer.component(component)[1] = std::nan("");
    }
    int steps = 0, spoilt_step = 2, component = 0;
};

} // namespace

TEST_CASE("a NaN in any column of any disc of an RVE is found in the next sub-step on every kernel", "[hard][nan][rve]") {
    HardCase hard("NaN and infinity", "in the state of an RVE", "comparisons with NaN are false: a force vanishes and the run goes on");
    for (const KernelChoice& kernel : every_kernel())
        for (const double value : no_numbers)
            for (int disc : {0, 17, 30}) {
                int missed = 0;
                for (int column = 0; column < 8; ++column) {
                    farm::Farm rve = kernel.farm_of(RveParameters(), farm::samples::disordered(31));
                    farm::AssemblyView& s = rve.assembly(0).view();
                    int contact = 0;
                    while (!farm::carries_force(s, contact)) ++contact;
                    double* const places[] = {s.x + disc, s.y + disc, s.velocity_x + disc, s.velocity_y + disc, s.spin + disc, s.mass + disc, s.radius + disc, s.tangential_force + contact};
                    *places[column] = column == 5 && std::isinf(value) ? std::nan("") : value; // an infinite mass is a disc that is held: no NaN comes of it
                    const farm::Answer answer = farm::samples::step(rve, {1e-6, 1e-6, 0, 0}, 1e-5, 1);
                    if (answer.status == Status::ok) ++missed, UNSCOPED_INFO(kernel.name() << " column " << column << " value " << value);
                }
                hard.holds(found, missed, kernel.name());
            }
}

TEST_CASE("a request that is no number is refused and leaves the RVE as it was, on every kernel", "[hard][nan][rve]") {
    HardCase hard("NaN and infinity", "in a request", "bonds without strength because beta is NaN, a cell that is none");
    for (const KernelChoice& kernel : every_kernel()) {
        RveParameters p;
        p.bond = BondParameters{};
        farm::Farm rve = kernel.farm_of(p, farm::samples::disordered(31)), untouched = kernel.farm_of(p, farm::samples::disordered(31));
        int missed = 0;
        for (const double value : no_numbers) {
            for (std::size_t c = 0; c < 4; ++c) {
                std::array<double, 4> increment = {0, 0, 0, 0};
                increment[c] = value;
                missed += farm::samples::step(rve, increment, 1e-4).status != Status::bad_request;
            }
            missed += farm::samples::step(rve, {0, 0, 0, 0}, 1e-4, 0, value).status != Status::bad_request;
        }
        missed += !farm::samples::same_bits(rve, 0, untouched, 0);
        hard.holds(found, missed, kernel.name());
    }
}

TEST_CASE("a packing that holds a NaN is refused by name", "[hard][nan][rve]") {
    HardCase hard("NaN and infinity", "in a packing", "an RVE that is no number from the start");
    for (const double value : no_numbers) {
        int missed = 0;
        for (int where = 0; where < 8; ++where) {
            Packing packing = farm::samples::disordered(9);
            packing.velocity_x = packing.velocity_y = packing.spin = std::vector<double>(9, 0.0);
            packing.contacts.push_back({0, 1, {0, 0}, 0.0, false});
            double* const places[] = {&packing.x[3], &packing.y[3], &packing.radius[3], &packing.velocity_x[3], &packing.velocity_y[3], &packing.spin[3], &packing.contacts[0].tangential_force, &packing.cell(0, 1)};
            *places[where] = value;
            missed += !says(fault_of([&] { farm::Farm(RveParameters(), {packing}, {0}); }), "numbers that are none");
        }
        hard.holds(found, missed);
    }
}

TEST_CASE("a NaN in any state of a point stops the next step with the point and the field named", "[hard][nan][mpm]") {
    HardCase hard("NaN and infinity", "in a point", "it spreads over nine nodes a step, and reaches a checkpoint");
    const std::vector<std::string> read = {"points/position", "points/velocity", "points/deformation_gradient", "points/volume", "points/stress", "points/p_wave_modulus", "points/enthalpy"};
    for (const double value : no_numbers) {
        int missed = 0;
        for (const std::string& name : read)
            for (std::size_t component = 0; component < 4; ++component) {
                auto simulation = start_heat(moving_heated());
                take_steps(*simulation, 2);
                const std::vector<StateColumn> columns = simulation->state();
                const auto column = std::find_if(columns.begin(), columns.end(), [&](const StateColumn& c) { return c.name == name; });
                REQUIRE(column != columns.end());
                const std::size_t components = column->components.size();
                if (component >= components) continue;
                column->data[5 * components + component] = value;
                const std::string fault = fault_of([&] { take_steps(*simulation, 1); });
                const std::string field = name.substr(name.find('/') + 1);
                // The deformation is read once the step has been taken: its point is named by the volume that follows from it.
                const bool named = says(fault, "point 5 ") && (says(fault, "its " + field) || (field == "deformation_gradient" && says(fault, "is "))) && says(fault, "at t = ");
                if (!named) ++missed, UNSCOPED_INFO(name << " " << component << " " << value << ": " << fault);
            }
        hard.holds(found, missed, fmt::format("{}", value));
    }
}

TEST_CASE("a NaN on a node, of the grid or of heat at rest, stops the step with the node or its points named", "[hard][nan][mpm]") {
    HardCase hard("NaN and infinity", "on a node", "points take it over and lose where it came from");
    int missed = 0;
    for (const double value : no_numbers) {
        auto simulation = start_heat(moving_heated());
        PrescribedField field;
        field.velocity = {value, 0.0};
        simulation->prescribe(field);
        const std::string fault = fault_of([&] { take_steps(*simulation, 1); });
        missed += !(says(fault, "node ") && says(fault, "its velocity is no number in step 1"));
        auto resting = start_heat([] {
            Scene scene = heat_scene(soil_material(), {0.3, 0.2}, 0.1, -2.0);
            scene.heat->boundaries = {held_side("left", 5.0)};
            return scene;
        }());
        for (const StateColumn& column : resting->state())
            if (column.name == "heat/node_enthalpy") column.data[resting->grid().node(2, 2)] = value;
        missed += !says(fault_of([&] { take_steps(*resting, 1); }), "enthalpy is");
    }
    hard.holds(found, missed);
}

TEST_CASE("an answer that is no number stops the step with point and column named, and the checkpoint before it is good", "[hard][nan][lockstep]") {
    HardCase hard("NaN and infinity", "in an answer", "a law that is another program sends NaN: the grid takes it, and the next checkpoint keeps it");
    const lockstep::TemporaryFolder folder;
    const lockstep::Prepared prepared = lockstep::prepare(lockstep::write_tiny_scene(folder), folder / "cache");
    const int components = 10; // stress, status, stiffness and energies; the others are only shown
    int missed = 0, checked = 0;
    for (int component = 0; component < components; ++component) {
        if (component == 3) continue; // the status: another number than 0 is a fault of its own
        auto [driver_side, farm_side] = exchange::loopback_pair(std::size_t(1) << 20, {});
        farm::FarmOptions options;
        options.threads = 1;
        SpoilingService service(options);
        service.component = component;
        auto ended = std::async(std::launch::async, [&service, own = std::move(farm_side)]() mutable {
            const auto channel = std::move(own);
            exchange::FarmEnd(*channel, service, "a spoiling farm").serve();
        });
        std::string fault;
        {
            Simulation::Laws laws;
            laws["rve"] = lockstep::farm_law(prepared, *driver_side);
            Simulation simulation(prepared.scene, std::move(laws));
            std::filesystem::create_directories(folder / "out");
            Checkpoints checkpoints(folder / "out");
            simulation.step(simulation.next_step());
            const auto good = checkpoints.write(simulation);
            fault = fault_of([&] { simulation.step(simulation.next_step()); });
            restore_checkpoint(simulation, good); // refuses what is no number
            fault_of([&] { simulation.step(simulation.next_step()); }); // and goes on (the farm answers soundly from here)
            CHECK(simulation.steps_done() == 2);
        }
        driver_side.reset();
        try {
            ended.get();
        } catch (const Error&) { // that its driver has gone
        }
        ++checked;
        const bool named = says(fault, "the RVE of point ") && says(fault, "of nan in step 2");
        if (!named) ++missed, UNSCOPED_INFO("component " << component << ": " << fault);
    }
    CHECK(checked == components - 1);
    hard.holds(found, missed);
}

TEST_CASE("a checkpoint with a NaN is neither written nor read", "[hard][nan][mpm]") {
    HardCase hard("NaN and infinity", "in a checkpoint", "a run is restarted from nothing");
    const lockstep::TemporaryFolder folder;
    auto simulation = start_heat(moving_heated());
    take_steps(*simulation, 2);
    Checkpoints checkpoints(folder.path());
    const auto good = checkpoints.write(*simulation);
    int missed = 0;
    for (const char* name : {"points/stress", "points/enthalpy", "ledger/kinetic", "clock"}) {
        { // as a writer without the check would have left it
            Hdf5File file = Hdf5File::create((good / "driver.h5").string(), "mpm-driver", "talik-driver-checkpoint 3");
            file.set_attribute("/", "scene_hash", simulation->scene().hash);
            file.set_attribute("/", "build", build_facts("mpm-driver"));
            for (const StateColumn& column : simulation->state()) {
                std::vector<double> values(column.data, column.data + column.size());
                if (column.name == name) values.back() = std::nan("");
                file.write("/" + column.name, std::span<const double>(values), column.components.size());
            }
            file.close();
            exchange::seal(good / "driver.h5");
        }
        auto restarted = start_heat(moving_heated());
        const std::string fault = fault_of([&] { restore_checkpoint(*restarted, good); });
        if (!says(fault, std::string("of ") + name) || !says(fault, "is nan")) ++missed, UNSCOPED_INFO(name << ": " << fault);
    }
    simulation->points().stress[3][1] = std::nan("");
    missed += !says(fault_of([&] { checkpoints.write(*simulation); }), "no checkpoint of step 2");
    hard.holds(found, missed);
}

TEST_CASE("every number of a scene is refused where it is none, with its key", "[hard][nan][scene]") {
    HardCase hard("NaN and infinity", "in a scene", "TOML has nan and inf: ranges let them through");
    int missed = 0, checked = 0;
    for (const char* file : {"/cases/thaw-slope/quick.toml", "/cases/biaxial/dense.toml", "/cases/neumann/soil.toml"}) {
        std::ifstream in(std::string(TALIK_SOURCE_DIR) + file);
        std::string table;
        std::map<std::string, int> items; // of lists of tables
        for (std::string line; std::getline(in, line);) {
            if (line.starts_with("[[")) {
                const std::string list = line.substr(2, line.find("]]") - 2);
                table = list + "." + std::to_string(items[list]++) + ".";
            } else if (line.starts_with("[")) {
                table = line.substr(1, line.find(']') - 1) + ".";
            }
            const auto equals = line.find(" = ");
            if (equals == std::string::npos || line.starts_with("#")) continue;
            const std::string key = table + line.substr(0, equals);
            std::string value = line.substr(equals + 3);
            const bool quantity = value.starts_with("\"") && value.size() > 1 && (std::isdigit(value[1]) || value[1] == '-');
            if (!quantity && !std::isdigit(value[0]) && value[0] != '-') continue;
            for (const char* none : {"nan", "inf", "-inf"}) {
                const auto faults = check_scene(std::string(TALIK_SOURCE_DIR) + file, {key + "=" + none});
                ++checked;
                if (faults.empty()) ++missed, UNSCOPED_INFO(file << " " << key << " = " << none);
            }
        }
    }
    CHECK(checked > 100);
    hard.holds(found, missed);
}
