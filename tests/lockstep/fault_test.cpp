// One of the two programs comes to grief: the other says so in one line, within a second, with its exit code; nothing is
// left in /dev/shm, no process is left, and the last checkpoint restarts.
#include "tests/lockstep/support.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/text.hpp"

#include <csignal>
#include <random>

#include "exchange/shm_segment.hpp"
#include "exchange/stale_segment.hpp"

using namespace talik::lockstep;
using talik::exchange::examine_segment;
using talik::exchange::remove_stale_segments;
using talik::exchange::SegmentState;

namespace {

// The law says a second. On a machine whose cores are busy with other work a process waits for its turn as well.
constexpr double a_second = 1.0, for_its_turn = 1.0;

// A run without end and its farm, each with a text of its own.
struct Pair {
    explicit Pair(const std::vector<std::string>& more = {}, const std::string& farm_name = "") {
        const auto shm = [](const std::string& of) { return "shm:" + of; };
        std::vector<std::string> run = {"mpm-driver", "run", scene.string(), "--output", output.string(), "--quiet", "--exchange", shm(name)};
        std::vector<std::string> serve = {"rve-farm", "serve", "--quiet", "--threads", "1", "--exchange", shm(farm_name.empty() ? name : farm_name)};
        run.insert(run.end(), more.begin(), more.end());
        serve.insert(serve.end(), more.begin(), more.end());
        driver.emplace(run, cache);
        farm.emplace(serve, cache);
    }
    bool has_checkpoint() const {
        const double until = now() + 30;
        while (checkpoints(output).empty() && now() < until) pause(0.002);
        return !checkpoints(output).empty();
    }
    bool left_in_shm() const { return fs::exists("/dev/shm/talik-" + name); }

    TemporaryFolder folder;
    fs::path cache = folder / "cache", output = folder / "out", scene = write_endless_scene(folder);
    std::string name = unique_exchange_name();
    std::optional<Program> driver, farm;
};

// Goes on for a few steps from the newest checkpoint.
void check_restarts(const fs::path& scene, const fs::path& output, const fs::path& cache) {
    REQUIRE_FALSE(checkpoints(output).empty());
    const Finished restarted = restart(scene, checkpoints(output).back(), output, cache);
    CAPTURE(restarted.text);
    CHECK(restarted.end.code == 0);
    CHECK(halves(output).empty());
}

void check_one_error(const std::vector<std::string>& errors, const std::string& says) {
    CAPTURE(errors);
    REQUIRE(errors.size() == 1);
    CHECK_CONTAINS(errors[0], says);
}

// Kills one process of a run that launched its farm, at a moment drawn between its start and half a second later.
void kill_at_random(bool the_farm, int trials) {
    TemporaryFolder folder, thawing_folder;
    const fs::path cache = folder / "cache", scenes[] = {write_endless_scene(folder), write_endless_scene(thawing_folder, "50 ms", true)};
    for (const fs::path& scene : scenes) REQUIRE(run_to_end({"mpm-driver", "explain", scene.string()}, cache).end.code == 0); // prepares the packings
    std::mt19937_64 random(the_farm ? 1 : 2);
    int restarts = 0;
    for (int trial = 0; trial < trials; ++trial) {
        const fs::path output = folder / ("out-" + std::to_string(trial)), scene = scenes[trial % 2]; // every other one with heat
        const double moment = 0.5 * static_cast<double>(random() % 1000) / 1000.0;
        CAPTURE(the_farm, trial, moment);
        Program run({"mpm-driver", "run", scene.string(), "--output", output.string(), "--quiet", "--threads", "1"}, cache);
        const double begin = now();
        while (the_farm && !run.child()) pause(0.001);
        pause(std::max(0.0, moment - (now() - begin)));
        const double killed = now();
        if (the_farm) {
            kill(*run.child(), SIGKILL);
            CHECK(run.wait(10).code == 3);
            check_one_error(run.errors(), "was killed by signal 9 (SIGKILL)");
        } else {
            run.send(SIGKILL);
            CHECK(run.wait(10).signal == SIGKILL);
            const auto ends = run.orphans(10);
            REQUIRE(ends.size() <= 1); // the farm; none where it was not launched yet
            // Before the farm has met the driver it is ended by the signal that Linux sends it at its parent's death.
            for (const End& end : ends) CHECK((end.code == 3 || (run.errors().size() <= 1 && (end.code == 1 || end.signal == SIGTERM))));
            for (const End& end : ends)
                if (end.code == 3) check_one_error(run.errors(), "the driver");
        }
        CHECK(run.orphans(10).empty());
        CHECK(now() - killed < a_second + for_its_turn);
        if (the_farm) CHECK(segments_made_by(run.pid()).empty());
        for (const auto& left : segments_made_by(run.pid())) CHECK(examine_segment(left).state == SegmentState::stale);
        remove_stale_segments(); // as each start of a driver does: one may have died before its farm came
        CHECK(segments_made_by(run.pid()).empty());
        if (!checkpoints(output).empty() && restarts < 6) check_restarts(scene, output, cache), ++restarts;
    }
    CHECK(restarts > 0);
}

} // namespace

TEST_CASE("A farm killed at any moment is reported within a second with exit code 3, and the last checkpoint restarts", "[lockstep][fault]") {
    kill_at_random(true, 20);
}

TEST_CASE("A driver killed at any moment takes its farm along within a second, and the last checkpoint restarts", "[lockstep][fault]") {
    kill_at_random(false, 20);
}

TEST_CASE("Hundreds of kills of either side leave no hang and nothing behind", "[lockstep][fault][long]") {
    kill_at_random(true, 300);
    kill_at_random(false, 300);
}

TEST_CASE("Each of two programs started apart reports the other's death in one line", "[lockstep][fault]") {
    const bool kill_farm = GENERATE(true, false);
    Pair pair;
    REQUIRE(pair.has_checkpoint());
    Program &victim = kill_farm ? *pair.farm : *pair.driver, &survivor = kill_farm ? *pair.driver : *pair.farm;
    const double killed = now();
    victim.send(SIGKILL);
    CHECK(survivor.wait(10).code == 3);
    CHECK(now() - killed < a_second + for_its_turn);
    check_one_error(survivor.errors(), (kill_farm ? "the farm (process " : "the driver (process ") + std::to_string(victim.pid()) + ") died without a word");
    if (kill_farm) CHECK_CONTAINS(survivor.text(), "last good checkpoint: " + checkpoints(pair.output).back().string());
    CHECK_FALSE(pair.left_in_shm());
    victim.wait(10);
    check_restarts(pair.scene, pair.output, pair.cache);
}

TEST_CASE("A stopped partner is waited for no longer than --stall-seconds, and a checkpoint restarts", "[lockstep][fault]") {
    const bool stop_farm = GENERATE(true, false);
    CAPTURE(stop_farm);
    Pair pair({"--stall-seconds", "1"});
    REQUIRE(pair.has_checkpoint());
    Program &stopped = stop_farm ? *pair.farm : *pair.driver, &waiting = stop_farm ? *pair.driver : *pair.farm;
    const double begin = now();
    stopped.send(SIGSTOP);
    CHECK(waiting.wait(20).code == 3);
    CHECK(now() - begin < 1.0 + a_second + for_its_turn);
    check_one_error(waiting.errors(), "has stalled: nothing of it moved for 1 s");
    CHECK_CONTAINS(waiting.text(), "it is stopped (SIGSTOP or Ctrl-Z)");
    stopped.send(SIGCONT);
    CHECK(stopped.wait(10).code == 3);
    check_one_error(stopped.errors(), "the driver (process"); // the farm learns of its end, the driver reads the farm's complaint
    CHECK_FALSE(pair.left_in_shm());
    check_restarts(pair.scene, pair.output, pair.cache);
}

TEST_CASE("SIGTERM ends a run in order, whichever program gets it: a checkpoint, one line, exit code 1, and a farm let go", "[lockstep][fault]") {
    const bool to_driver = GENERATE(true, false);
    CAPTURE(to_driver);
    Pair pair;
    REQUIRE(pair.has_checkpoint());
    (to_driver ? *pair.driver : *pair.farm).send(SIGTERM);
    const End end = pair.driver->wait(10);
    CAPTURE(pair.driver->text(), pair.farm->text());
    CHECK(end.code == 1);
    check_one_error(pair.driver->errors(), to_driver ? "stopped by SIGTERM at t = " : "stopped because the farm was asked to end at t = ");
    CHECK_CONTAINS(pair.driver->text(), "go on with --restart " + checkpoints(pair.output).back().string());
    CHECK(pair.farm->wait(10).code == 0);
    CHECK(pair.farm->errors().empty());
    CHECK_CONTAINS(content(pair.output / "summary.json"), "\"exit\": 1");
    check_restarts(pair.scene, pair.output, pair.cache);
}

TEST_CASE("Ctrl-C while no farm has come ends the driver at once: one line, exit code 1, nothing in /dev/shm", "[lockstep][fault]") {
    const int signal = GENERATE(SIGINT, SIGTERM);
    TemporaryFolder folder;
    const fs::path scene = write_tiny_scene(folder);
    const std::string name = unique_exchange_name();
    Program driver({"mpm-driver", "run", scene.string(), "--output", (folder / "out").string(), "--quiet", "--exchange", "shm:" + name}, folder / "cache");
    REQUIRE(appears("/dev/shm/talik-" + name, 30));
    pause(0.1);
    driver.send(signal);
    const End end = driver.wait(10);
    CHECK(end.code == 1);
    CHECK(end.seconds < a_second + for_its_turn);
    check_one_error(driver.errors(), signal == SIGINT ? "interrupted by SIGINT while waiting for the farm" : "interrupted by SIGTERM while waiting for the farm");
    CHECK_FALSE(fs::exists("/dev/shm/talik-" + name));
}

TEST_CASE("Ctrl-C for both programs at once, at any moment of their start, is one line and exit code 1", "[lockstep][fault]") {
    TemporaryFolder folder;
    const fs::path cache = folder / "cache", scene = write_endless_scene(folder);
    REQUIRE(run_to_end({"mpm-driver", "explain", scene.string()}, cache).end.code == 0); // prepares the packings
    for (int trial = 0; trial < 30; ++trial) {
        const int signal = trial % 3 == 2 ? SIGTERM : SIGINT;
        const double moment = 0.003 * trial; // s after the launch of the farm
        CAPTURE(trial, signal, moment);
        Program run({"mpm-driver", "run", scene.string(), "--output", (folder / "out").string(), "--quiet", "--threads", "1"}, cache);
        for (const double until = now() + 30; !run.child() && now() < until;) pause(0.0002);
        pause(moment);
        REQUIRE(kill(-run.pid(), signal) == 0); // as a terminal does
        const End end = run.wait(10);
        run.orphans(10);
        CAPTURE(run.text());
        CHECK(end.code == 1);
        check_one_error(run.errors(), signal == SIGINT ? "SIGINT" : "SIGTERM"); // interrupted by ..., or stopped by ... at t = ...
        CHECK(segments_made_by(run.pid()).empty());
    }
}

TEST_CASE("A farm is told why its driver failed, and says so", "[lockstep][fault]") {
    // The plate runs out of the domain's lower end: the points leave with it.
    TemporaryFolder folder;
    const fs::path scene = write_tiny_scene(folder, {{"velocity", "velocity = \"-40 m/s\""}, {"ramp", "ramp = \"0 s\""}, {"duration", "duration = \"1 s\""}});
    const std::string name = "shm:" + unique_exchange_name();
    Program farm({"rve-farm", "serve", "--quiet", "--threads", "1", "--exchange", name}, folder / "cache");
    const Finished run = run_to_end({"mpm-driver", "run", scene.string(), "--output", (folder / "out").string(), "--quiet", "--exchange", name}, folder / "cache");
    CHECK(run.end.code == 1);
    REQUIRE(run.errors.size() == 1);
    CHECK(farm.wait(10).code == 3);
    // The first words of the driver's own line, quoted by the farm.
    check_one_error(farm.errors(), "it reports: " + run.errors[0].substr(7, 30));
}

TEST_CASE("Driver and farm may be started in any order", "[lockstep][fault]") {
    const bool farm_first = GENERATE(true, false);
    TemporaryFolder folder;
    const fs::path cache = folder / "cache", scene = write_tiny_scene(folder);
    const std::string name = unique_exchange_name();
    const std::vector<std::string> run = {"mpm-driver", "run", scene.string(), "--output", (folder / "out").string(), "--quiet", "--exchange", "shm:" + name};
    const std::vector<std::string> serve = {"rve-farm", "serve", "--quiet", "--threads", "1", "--exchange", "shm:" + name};
    std::optional<Program> driver, farm;
    if (farm_first) farm.emplace(serve, cache), pause(0.3);
    driver.emplace(run, cache);
    if (!farm_first) {
        REQUIRE(appears("/dev/shm/talik-" + name, 30));
        pause(0.3);
        farm.emplace(serve, cache);
    }
    CHECK(driver->wait(30).code == 0);
    CHECK(farm->wait(10).code == 0);
    CHECK(driver->errors().empty());
    CHECK(farm->errors().empty());
    CHECK_FALSE(fs::exists("/dev/shm/talik-" + name));
}

TEST_CASE("Programs that were given different exchange names give up in the set time, each in one line", "[lockstep][fault]") {
    Pair pair({"--attach-seconds", "0.5"}, "lockstep-misspelt");
    CHECK(pair.driver->wait(20).code == 3);
    CHECK(pair.farm->wait(20).code == 3);
    check_one_error(pair.driver->errors(), "the farm did not come to the exchange within 0.5 s");
    check_one_error(pair.farm->errors(), "no driver opened the exchange 'lockstep-misspelt' within 0.5 s");
    CHECK_FALSE(pair.left_in_shm());
}

TEST_CASE("What a driver leaves in /dev/shm that is killed before its farm came, the next start of any run removes", "[lockstep][fault]") {
    TemporaryFolder folder;
    const fs::path cache = folder / "cache", scene = write_tiny_scene(folder);
    const std::string name = unique_exchange_name();
    {
        Program driver({"mpm-driver", "run", scene.string(), "--output", (folder / "out").string(), "--quiet", "--exchange", "shm:" + name}, cache);
        REQUIRE(appears("/dev/shm/talik-" + name, 30));
        pause(0.05);
        driver.send(SIGKILL);
        driver.wait(10);
    }
    const Finished next = run_to_end({"mpm-driver", "run", scene.string(), "--output", (folder / "next").string(), "--quiet", "--until", "0.002"}, cache);
    CHECK(next.end.code == 0);
    CHECK_FALSE(fs::exists("/dev/shm/talik-" + name));
}
