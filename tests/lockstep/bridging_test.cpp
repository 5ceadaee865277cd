// The bridge carries strain and stress unchanged: a point of the macro solver and an RVE driven by hand are one.
#include "tests/lockstep/in_process.hpp"

#include "common/physics/rve_columns.hpp"
#include "mpm-driver/constitutive/packing_choice.hpp"
#include "mpm-driver/output/history.hpp"
#include "mpm-driver/output/quantities.hpp"
#include "rve-farm/backend/farm.hpp"
#include "tests/support/catch.hpp"

using namespace talik;
using namespace talik::lockstep;

namespace {

constexpr double pressure = 1e5; // Pa, of the packings
constexpr double dt = 1e-4;      // s
constexpr int steps = 100;       // 0.1 % of the strain below

// Compression, shear and spin at once: 0.1 /s at most.
Matrix velocity_gradient() {
    Matrix gradient;
    gradient << 0.03, 0.06, -0.02, -0.1;
    return gradient;
}

// Every stress of every step, Pa, point after point: 16 points in a field of uniform L.
struct Course {
    std::vector<std::array<double, 4>> increments;
    std::vector<Eigen::Vector3d> stresses;
    bool operator==(const Course& other) const { return increments == other.increments && stresses == other.stresses; }
};

Course drive_uniformly(const Prepared& prepared, const std::string& kind, int threads) {
    FarmInThread farm(kind, threads);
    Coupled coupled(prepared, farm);
    coupled.simulation->prescribe({velocity_gradient(), Vector::Zero(), Vector(0.1, 0.1)});
    Course course;
    for (int step = 0; step < steps; ++step) {
        coupled.simulation->step(dt);
        for (const auto& stress : coupled.simulation->points().stress) course.stresses.push_back(stress);
    }
    coupled.law->bye();
    farm.join();
    course.increments = farm.service.increments;
    return course;
}

// Points one cell and more from the edge of the domain: there the shape functions add up to linear fields.
fs::path write_inner_scene(const TemporaryFolder& folder) {
    return write_tiny_scene(folder, {{"origin", "origin = [\"-0.2 m\", \"-0.2 m\"]"}, {"size", "size = [\"0.6 m\", \"0.6 m\"]"}});
}

// history.csv of the tiny scene, every step of it, with the driver's and the farm's numbers of threads.
std::string free_run(const Prepared& prepared, const fs::path& file, const std::string& kind, int farm_threads, int driver_threads) {
    omp_set_num_threads(driver_threads);
    FarmInThread farm(kind, farm_threads);
    Coupled coupled(prepared, farm);
    driver::Simulation& simulation = *coupled.simulation;
    std::vector<std::string> names;
    std::vector<double> values;
    for (const auto& value : driver::history_values(simulation)) names.push_back(value.name);
    {
        driver::History history(file, names, -1);
        while (!simulation.finished()) {
            simulation.step(simulation.next_step());
            values.clear();
            for (const auto& value : driver::history_values(simulation)) values.push_back(value.value);
            history.row(simulation.steps_done(), simulation.time(), values);
        }
    }
    coupled.law->bye();
    farm.join();
    omp_set_num_threads(1);
    return content(file);
}

} // namespace

TEST_CASE("With all nodes prescribed, the driver sends dt L to every RVE and gets the stress of an RVE driven by hand",
          "[lockstep][bridge][eq32][eq49]") {
    TemporaryFolder folder;
    const Prepared prepared = prepare(write_inner_scene(folder), folder / "cache");
    const Course course = drive_uniformly(prepared, "loopback", 1);
    constexpr std::size_t count = 16;
    REQUIRE(course.increments.size() == count * steps);
    REQUIRE(course.stresses.size() == count * steps);

    const Matrix L = velocity_gradient();
    const std::array<double, 4> wanted = {dt * L(0, 0), dt * L(0, 1), dt * L(1, 0), dt * L(1, 1)};
    double furthest = 0.0;
    for (const auto& increment : course.increments)
        for (std::size_t c = 0; c < 4; ++c) furthest = std::max(furthest, std::abs(increment[c] - wanted[c]));
    // Rounding of sums over nodes with gradients of 1/h: 1e-16 of the largest increment times a few tens.
    INFO("increments off by " << furthest / (dt * 0.1) << " of the largest");
    CHECK(furthest < 1e-12 * dt * 0.1);

    farm::Farm by_hand(prepared.setup.parameters, prepared.setup.packings,
                       driver::deal_packings(count, static_cast<int>(prepared.setup.packings.size()), prepared.scene.seed));
    std::vector<std::uint32_t> ids(count);
    std::vector<double> increments;
    for (std::uint32_t id = 0; id < count; ++id) {
        ids[id] = id;
        increments.insert(increments.end(), wanted.begin(), wanted.end());
    }
    std::vector<farm::Answer> answers(count);
    double furthest_stress = 0.0, moved = 0.0;
    for (std::size_t step = 0; step < steps; ++step) {
        by_hand.advance(ids, increments, {}, dt, 0, answers);
        for (std::size_t point = 0; point < count; ++point)
            for (int c = 0; c < 3; ++c) {
                const double ours = answers[point].stress[static_cast<std::size_t>(c)];
                furthest_stress = std::max(furthest_stress, std::abs(course.stresses[step * count + point][c] - ours));
                moved = std::max(moved, std::abs(ours - course.stresses[point][c]));
            }
    }
    INFO("stresses off by " << furthest_stress / pressure << " of the pressure, moved by " << moved / pressure);
    CHECK(furthest_stress < 1e-9 * pressure); // chaos is slow to grow: 1e-7 of the pressure at 0.5 % strain
    CHECK(moved > 1e-3 * pressure);           // the path does strain the RVEs
}

TEST_CASE("The same requests return the same bits, whatever the channel and the farm's threads", "[lockstep][bridge]") {
    TemporaryFolder folder;
    const Prepared prepared = prepare(write_inner_scene(folder), folder / "cache");
    const Course course = drive_uniformly(prepared, "loopback", 1);
    CHECK((course == drive_uniformly(prepared, "loopback", 1)));
    CHECK((course == drive_uniformly(prepared, "loopback", 2)));
    CHECK((course == drive_uniformly(prepared, "shm", 2)));
}

TEST_CASE("A step asked for again returns the same bits and moves no disc", "[lockstep][bridge]") {
    TemporaryFolder folder;
    const Prepared prepared = prepare(write_inner_scene(folder), folder / "cache");
    FarmInThread farm("loopback", 1);
    FarmSetup setup = prepared.setup;
    setup.packing_of_rve = {0, 1, 0};
    exchange::Hello hello;
    hello.role = exchange::Role::driver;
    hello.run_id = 1;
    hello.request_columns = {rve_columns::displacement_gradient_increment};
    hello.answer_columns = {rve_columns::stress, rve_columns::status, rve_columns::stored_energy};
    exchange::DriverEnd driver(farm.channel());
    driver.connect(hello);
    driver.configure(encode(setup));
    exchange::Batch request = driver.make_request(3), answer = driver.make_answer(3);
    const auto ask = [&](std::uint64_t step, double strain) {
        exchange::BatchHeader header;
        header.count = 3;
        request.start(header);
        for (std::uint32_t row = 0; row < 3; ++row) {
            request.ids()[row] = row;
            for (int c = 0; c < 4; ++c) request.component(c)[row] = c == 3 ? strain : 0.0;
        }
        driver.step({step, dt, 0}, request, answer);
        std::vector<double> all;
        for (int c = 0; c < 5; ++c) all.insert(all.end(), answer.component(c).begin(), answer.component(c).end());
        return all;
    };
    const auto first = ask(1, -1e-5);
    CHECK(ask(1, -1e-5) == first);
    const auto second = ask(2, -1e-5);
    CHECK(second != first);
    CHECK(ask(2, -1e-5) == second);
    driver.bye();
    farm.join();
}

TEST_CASE("Shared memory or in process, one thread or two on either side: a run leaves the same history, byte for byte",
          "[lockstep][bridge]") {
    TemporaryFolder folder;
    const Prepared prepared = prepare(write_tiny_scene(folder), folder / "cache");
    const std::string history = free_run(prepared, folder / "a.csv", "loopback", 1, 1);
    CHECK(std::count(history.begin(), history.end(), '\n') > 50); // the header and some sixty steps
    CHECK(free_run(prepared, folder / "b.csv", "shm", 1, 1) == history);
    CHECK(free_run(prepared, folder / "c.csv", "loopback", 2, 1) == history);
    CHECK(free_run(prepared, folder / "d.csv", "loopback", 1, 2) == history);
    CHECK(free_run(prepared, folder / "e.csv", "shm", 2, 2) == history);
}
