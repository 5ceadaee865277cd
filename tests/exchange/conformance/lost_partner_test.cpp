// The conformance suite, two processes, one of which comes to grief: killed, stopped, or failing, at every state of the protocol.
#include "exchange/driver_end.hpp"
#include "exchange/farm_end.hpp"
#include "exchange/process.hpp"
#include "tests/exchange/support.hpp"
#include "tests/support/catch.hpp"

#include <csignal>
#include <thread>

using namespace talik;
using namespace talik::exchange;
using namespace talik::exchange::test;

namespace {

constexpr double death_noticed_within = 0.5; // s: the goal of the design; a look is due every 50 ms
constexpr std::size_t small_ring = 16384;    // less than the step below, so that kills find rings full, too

// What the driver does in a run; `at` is called at each state with its name.
void drive(Channel& channel, const std::function<void(const std::string&)>& at, int steps = 3) {
    at("attached");
    DriverEnd driver(channel, 64);
    driver.connect(driver_hello());
    at("connected");
    driver.configure(setup_for(1000));
    at("configured");
    Batch request = driver.make_request(1000), answer = driver.make_answer(1000);
    for (int step = 1; step <= steps; ++step) {
        fill(request, 1000, 0.1);
        driver.begin_step({static_cast<std::uint64_t>(step), 1e-3, 0}, 1000, answer);
        for (int sent = 0; sent < 1000;) {
            Batch& chunk = driver.next_chunk();
            for (std::size_t row = 0; row < chunk.ids().size(); ++row) chunk.ids()[row] = static_cast<std::uint32_t>(sent++);
            for (int c = 0; c < 4; ++c) std::fill(chunk.component(c).begin(), chunk.component(c).end(), 1e-3 * step);
            driver.send_chunk();
            if (sent == 512) at("in a step");
        }
        driver.finish_step();
        at("between steps");
    }
    driver.checkpoint("here");
    driver.bye();
}

void serve(Channel& channel, const std::function<void(const std::string&)>& at) {
    at("attached");
    SummingFarm service;
    service.on = at;
    FarmEnd(channel, service, "test-farm").serve();
}

bool is_open(const std::string& kind, const std::string& name) { return kind == "shm" ? in_dev_shm(name) : std::filesystem::exists(exchange_folder(name)); }
bool farm_came(const std::string& kind, const std::string& name) {
    return kind == "shm" ? !in_dev_shm(name) : std::filesystem::exists(exchange_folder(name) + "/farm.id");
}

} // namespace

TEST_CASE("Two processes run a lockstep, and leave nothing in /dev/shm", "[exchange][process]") {
    const std::string kind = GENERATE(from_range(transports_between_processes()));
    CAPTURE(kind);
    const std::string name = unique_name("pair");
    const FolderOf folder(name);
    const auto channel = driver_channel(kind, name, small_ring);
    CHECK(is_open(kind, name));
    Child farm([&] { serve(*farm_channel(kind, name, small_ring), [](const std::string&) {}); });
    CHECK_NOTHROW(drive(*channel, [](const std::string&) {}));
    CHECK_FALSE(in_dev_shm(name));
    CHECK(farm.exit_code() == 0);
}

TEST_CASE("A farm killed at any state of the protocol is reported dead within half a second", "[exchange][process]") {
    const std::string kind = GENERATE(from_range(transports_between_processes()));
    CAPTURE(kind);
    const std::string state = GENERATE(as<std::string>{}, "attached", "configure", "answer", "fifth answer", "checkpoint");
    CAPTURE(state);
    const std::string name = unique_name("kill");
    const FolderOf folder(name);
    SharedInstant death;
    const auto channel = driver_channel(kind, name, small_ring);
    int answers = 0;
    Child farm([&] {
        serve(*farm_channel(kind, name, small_ring), [&](const std::string& at) {
            if (at == "answer") ++answers;
            if (at != state && !(state == "fifth answer" && answers == 5)) return;
            death.set();
            std::raise(SIGKILL);
        });
    });
    ExitCode code = ExitCode::done;
    const std::string text = error_text([&] { drive(*channel, [](const std::string&) {}); }, &code);
    CHECK(death.seconds_ago() < death_noticed_within);
    CHECK(code == ExitCode::partner_lost);
    CHECK(contains(text, fmt::format("the farm (process {}) died without a word", farm.pid())));
    CHECK_FALSE(in_dev_shm(name));
}

TEST_CASE("A driver killed at any state of the protocol is reported dead within half a second", "[exchange][process]") {
    const std::string kind = GENERATE(from_range(transports_between_processes()));
    CAPTURE(kind);
    const std::string state = GENERATE(as<std::string>{}, "attached", "connected", "configured", "in a step", "between steps");
    CAPTURE(state);
    const std::string name = unique_name("kill");
    const FolderOf folder(name);
    SharedInstant death;
    Child driver([&] {
        drive(*driver_channel(kind, name, small_ring), [&](const std::string& at) {
            if (at == "attached") // else the farm might find the name gone, and wait for another driver
                while (!farm_came(kind, name)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
            if (at != state) return;
            death.set();
            std::raise(SIGKILL);
        });
    });
    ExitCode code = ExitCode::done;
    const std::string text = error_text([&] { serve(*farm_channel(kind, name, small_ring), [](const std::string&) {}); }, &code);
    CHECK(death.seconds_ago() < death_noticed_within);
    CHECK(code == ExitCode::partner_lost);
    CHECK(contains(text, fmt::format("the driver (process {}) died without a word", driver.pid())));
    CHECK_FALSE(in_dev_shm(name));
}

TEST_CASE("A launched farm that was killed is reported with its signal", "[exchange][process]") {
    const std::string kind = GENERATE(from_range(transports_between_processes()));
    CAPTURE(kind);
    const std::string name = unique_name("fate");
    const FolderOf folder(name);
    const auto channel = driver_channel(kind, name, small_ring);
    LaunchedProcess sleeper({"sleep", "30"}); // never comes to the exchange
    channel->ask_fate([&] { return sleeper.fate(); });
    kill(sleeper.pid(), SIGKILL);
    const auto begin = Clock::now();
    ExitCode code = ExitCode::done;
    const std::string text = error_text([&] { drive(*channel, [](const std::string&) {}); }, &code);
    CHECK(seconds_since(begin) < death_noticed_within);
    CHECK(code == ExitCode::partner_lost);
    CHECK(contains(text, "the farm was killed by signal 9 (SIGKILL)"));
}

TEST_CASE("A stopped farm is reported as stalled within the set time, not as dead", "[exchange][process]") {
    const std::string kind = GENERATE(from_range(transports_between_processes()));
    CAPTURE(kind);
    const std::string name = unique_name("stop");
    const FolderOf folder(name);
    WaitLimits limits;
    limits.stall_seconds = 0.5;
    SharedInstant stop;
    const auto channel = driver_channel(kind, name, small_ring, limits);
    Child farm([&] {
        serve(*farm_channel(kind, name, small_ring), [&](const std::string& at) {
            if (at != "answer") return;
            stop.set();
            std::raise(SIGSTOP);
        });
    });
    ExitCode code = ExitCode::done;
    const std::string text = error_text([&] { drive(*channel, [](const std::string&) {}); }, &code);
    CHECK(stop.seconds_ago() >= 0.45);
    CHECK(stop.seconds_ago() < 1.5); // the set time and one second
    CHECK(code == ExitCode::partner_lost);
    CHECK(contains(text, "has stalled: nothing of it moved for 0.5 s"));
    CHECK(contains(text, "it is stopped (SIGSTOP or Ctrl-Z)"));
    CHECK(contains(text, fmt::format("kill -CONT {}", farm.pid())));
}

TEST_CASE("A driver that is stopped itself does not take its own sleep for the farm's", "[exchange][process]") {
    const std::string kind = GENERATE(from_range(transports_between_processes()));
    CAPTURE(kind);
    const std::string name = unique_name("sleep");
    const FolderOf folder(name);
    WaitLimits limits;
    limits.stall_seconds = 0.6;
    Child driver([&] {
        const auto channel = driver_channel(kind, name, small_ring, limits);
        drive(*channel, [](const std::string&) {});
    });
    std::atomic<bool> stopped{false};
    std::thread stopper;
    serve(*farm_channel(kind, name, small_ring), [&](const std::string& at) {
        if (at != "configure" || stopped.exchange(true)) return;
        std::this_thread::sleep_for(std::chrono::milliseconds(200)); // the driver waits for `ready` by now
        kill(driver.pid(), SIGSTOP);
        std::this_thread::sleep_for(std::chrono::milliseconds(1500)); // far beyond the stall time
        kill(driver.pid(), SIGCONT);
        std::this_thread::sleep_for(std::chrono::milliseconds(150));
    });
    CHECK(driver.exit_code() == 0);
}

TEST_CASE("A failing farm is quoted, and ends with its own exit code", "[exchange][process]") {
    const std::string kind = GENERATE(from_range(transports_between_processes()));
    CAPTURE(kind);
    const std::string name = unique_name("fail");
    const FolderOf folder(name);
    const auto channel = driver_channel(kind, name, small_ring);
    Child farm([&] {
        serve(*farm_channel(kind, name, small_ring), [](const std::string& at) {
            if (at == "answer") fail(ExitCode::out_of_resource, "no memory for RVE 3", "use fewer");
        });
    });
    ExitCode code = ExitCode::done;
    const std::string text = error_text([&] { drive(*channel, [](const std::string&) {}); }, &code);
    CHECK(text == "the farm reports: no memory for RVE 3 (use fewer)");
    CHECK(code == ExitCode::out_of_resource);
    CHECK(farm.exit_code() == 4);
}

TEST_CASE("The cause of a driver's end is quoted by its farm", "[exchange][process]") {
    const std::string kind = GENERATE(from_range(transports_between_processes()));
    CAPTURE(kind);
    const std::string name = unique_name("cause");
    const FolderOf folder(name);
    Child driver([&] {
        const auto channel = driver_channel(kind, name, small_ring);
        with_cause(*channel, [&] {
            drive(*channel, [](const std::string& at) {
                if (at == "in a step") fail(ExitCode::failed, "point 7 left the grid", "enlarge it");
            });
        });
    });
    ExitCode code = ExitCode::done;
    const std::string text = error_text([&] { serve(*farm_channel(kind, name, small_ring), [](const std::string&) {}); }, &code);
    CHECK(code == ExitCode::partner_lost);
    CHECK(contains(text, "it reports: point 7 left the grid (enlarge it)"));
    CHECK(driver.exit_code() == 1);
}

TEST_CASE("Twenty random kills of either side: no hang, nothing left behind", "[exchange][process]") {
    const std::string kind = GENERATE(from_range(transports_between_processes()));
    CAPTURE(kind);
    const bool kill_farm = GENERATE(false, true);
    for (int trial = 0; trial < 20; ++trial) {
        CAPTURE(kill_farm, trial);
        const std::string name = unique_name("random");
        const FolderOf folder(name);
        SharedInstant connected;
        Child driver([&] {
            drive(*driver_channel(kind, name, small_ring), [&](const std::string& at) { if (at == "connected") connected.set(); }, 1'000'000);
        });
        Child farm([&] { serve(*farm_channel(kind, name, small_ring), [](const std::string&) {}); });
        while (!connected.is_set()) std::this_thread::sleep_for(std::chrono::microseconds(100));
        std::this_thread::sleep_for(std::chrono::microseconds(7919 * trial % 20000));
        const auto begin = Clock::now();
        kill(kill_farm ? farm.pid() : driver.pid(), SIGKILL);
        CHECK((kill_farm ? driver : farm).exit_code() == static_cast<int>(ExitCode::partner_lost));
        CHECK(seconds_since(begin) < death_noticed_within);
        CHECK_FALSE(in_dev_shm(name));
    }
}
