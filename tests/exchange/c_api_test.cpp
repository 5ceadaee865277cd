// The C interface: a law behind callbacks and a driver behind a handle, in two threads over shared memory.
#include "exchange/c_api.h"

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <thread>

#include "common/packing/packing_file.hpp"
#include "tests/exchange/support.hpp"
#include "tests/support/catch.hpp"

using namespace talik;
using namespace talik::exchange::test;

namespace {

// Hooke in one dimension after the other; counts what it is asked, and fails on command.
struct Spring {
    std::vector<double> stress;
    std::size_t rves = 0;
    int asked = 0;
    bool fails = false;
};

int configure(void* user, const talik_setup* setup, double* initial) {
    auto& spring = *static_cast<Spring*>(user);
    spring.rves = setup->rves;
    spring.stress.assign(setup->initial_stress, setup->initial_stress + 3 * setup->rves);
    std::copy(spring.stress.begin(), spring.stress.end(), initial);
    std::fill(initial + 3 * setup->rves, initial + 4 * setup->rves, 1e7);
    return 0;
}

int answer(void* user, const talik_batch* batch) {
    auto& spring = *static_cast<Spring*>(user);
    if (spring.fails) {
        talik_set_error("the spring broke");
        return 1;
    }
    for (std::size_t i = 0; i < batch->rows; ++i, ++spring.asked) {
        for (const auto& [component, of] : {std::pair{0, 0}, std::pair{1, 3}}) {
            double& stress = spring.stress[static_cast<std::size_t>(component) * spring.rves + batch->ids[i]];
            stress += 1e7 * batch->request[static_cast<std::size_t>(of) * batch->rows + i];
            batch->answer[static_cast<std::size_t>(component) * batch->rows + i] = stress;
        }
        batch->answer[2 * batch->rows + i] = 0.0;
        batch->answer[3 * batch->rows + i] = 1e7;
    }
    return 0;
}

const talik_column gradient[] = {{"displacement_gradient_increment", 4, "1", nullptr}};
const talik_column given[] = {{"stress", 3, "Pa", nullptr}, {"stiffness", 1, "Pa", nullptr}};
const talik_column wanted[] = {{"stress", 3, "Pa", nullptr}, {"status", 1, "1", nullptr}, {"void_ratio", 1, "1", nullptr}};

talik_law spring_law() {
    talik_law law{};
    law.size = sizeof law;
    law.name = "a spring";
    law.request = gradient, law.request_columns = 1;
    law.answer = given, law.answer_columns = 2;
    law.configure = configure, law.answer_batch = answer;
    return law;
}

talik_driver_options options() {
    talik_driver_options o{};
    o.size = sizeof o;
    o.program = "test";
    o.request = gradient, o.request_columns = 1;
    o.answer = wanted, o.answer_columns = 3;
    o.attach_seconds = 30;
    return o;
}

// A packing of two discs, and the specification that names it.
std::string specification() {
    const std::filesystem::path folder = std::filesystem::path(TALIK_BINARY_DIR) / unique_name("c-api");
    std::filesystem::create_directories(folder);
    Packing packing;
    packing.x = packing.y = {0.25, 0.75}, packing.radius = {0.25, 0.25};
    packing.pressure = 1e5;
    write_packings((folder / "packing.h5").string(), "test", {packing});
    std::ofstream(folder / "rves.toml") << "[rve.packing]\nfile = \"packing.h5\"\n";
    return (folder / "rves.toml").string();
}

} // namespace

TEST_CASE("A law and a driver behind the C interface meet: what is asked once is not asked the law again", "[exchange][c]") {
    const std::string name = "shm:" + unique_name("c"), file = specification();
    Spring spring;
    const talik_law law = spring_law();
    int ended = -1;
    std::string said;
    std::thread farm([&] {
        ended = talik_serve(name.c_str(), &law, &spring, 30);
        said = talik_last_error();
    });
    const talik_driver_options o = options();
    talik_driver* driver = nullptr;
    REQUIRE(talik_driver_open(&driver, name.c_str(), &o) == 0);
    double initial[5 * 3], first[5 * 2], again[5 * 2];
    REQUIRE(talik_driver_configure(driver, file.c_str(), 3, initial) == 0);
    CHECK(initial[0] == -1e5); // the packing's pressure
    const std::uint32_t ids[2] = {2, 0};
    const double asked[8] = {1e-4, 2e-4, 0, 0, 0, 0, 3e-4, 4e-4}; // xx, xy, yx, yy of both
    REQUIRE(talik_driver_step(driver, 1, 1e-3, 0, 2, ids, asked, first) == 0);
    CHECK(first[0] == -1e5 + 1e3);
    CHECK(first[3] == -1e5 + 4e3);
    CHECK(first[6] == 0.0);         // the status that the law does not give
    CHECK(std::isnan(first[8]));    // and the void ratio, which it does not know
    REQUIRE(talik_driver_step(driver, 1, 1e-3, 0, 2, ids, asked, again) == 0);
    CHECK(std::memcmp(first, again, 8 * sizeof(double)) == 0);
    CHECK(spring.asked == 2);
    CHECK(talik_driver_command(driver, "activate bonds") == 2); // which ends the run: this law knows none
    CHECK(contains(talik_last_error(), "the law knows no command"));
    talik_driver_close(driver);
    farm.join();
    CHECK(ended == 2);
    CHECK(contains(said, "the law knows no command"));
    std::filesystem::remove_all(std::filesystem::path(file).parent_path());
}

TEST_CASE("A law's fault reaches the driver in its own words, with its exit code", "[exchange][c]") {
    const std::string name = "shm:" + unique_name("c"), file = specification();
    Spring spring;
    spring.fails = true;
    const talik_law law = spring_law();
    std::thread farm([&] { (void)talik_serve(name.c_str(), &law, &spring, 30); });
    const talik_driver_options o = options();
    talik_driver* driver = nullptr;
    REQUIRE(talik_driver_open(&driver, name.c_str(), &o) == 0);
    REQUIRE(talik_driver_configure(driver, file.c_str(), 1, nullptr) == 0);
    const std::uint32_t id = 0;
    double asked[4] = {}, got[5];
    CHECK(talik_driver_step(driver, 1, 1e-3, 0, 1, &id, asked, got) == 1);
    CHECK(contains(talik_last_error(), "the spring broke"));
    talik_driver_close(driver);
    farm.join();
    std::filesystem::remove_all(std::filesystem::path(file).parent_path());
}

TEST_CASE("What cannot be meant is refused across the C interface, in one line, and nothing is thrown", "[exchange][c]") {
    talik_law law = spring_law();
    CHECK(talik_serve("shm:x", nullptr, nullptr, 1) == 2);
    CHECK(talik_serve("tcp:x", &law, nullptr, 1) == 2);
    CHECK(contains(talik_last_error(), "no such exchange"));
    law.size = 8;
    CHECK(talik_serve("shm:x", &law, nullptr, 1) == 2);
    CHECK(contains(talik_last_error(), "not of this version"));
    law = spring_law();
    law.answer_columns = 1; // no stiffness
    CHECK(talik_serve("shm:x", &law, nullptr, 1) == 2);
    CHECK(contains(talik_last_error(), "does not give stiffness"));
    talik_driver* driver = nullptr;
    CHECK(talik_driver_open(&driver, "shm:x", nullptr) == 2);
    CHECK(driver == nullptr);
    CHECK(talik_driver_bye(nullptr) == 2);
    talik_driver_close(nullptr);
    talik_driver_options o = options();
    o.attach_seconds = 0.2;
    CHECK(talik_driver_open(&driver, ("shm:" + unique_name("none")).c_str(), &o) == 3); // nobody comes
    CHECK(contains(talik_last_error(), "did not come"));
    CHECK(talik_known_column(-1) == nullptr);
    CHECK(std::string(talik_known_column(0)->name) == "displacement_gradient_increment");
}
