// Runs that lose a farm, that share their RVEs out, or that meet over another transport: the bytes of the plain run.
#include "tests/lockstep/support.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/text.hpp"

#include <csignal>
#include <nlohmann/json.hpp>

#include <fmt/format.h>

using namespace talik::lockstep;

namespace {

std::vector<std::string> run_command(const fs::path& scene, const fs::path& output, const std::vector<std::string>& more = {}) {
    std::vector<std::string> command = {"mpm-driver", "run", scene.string(), "--output", output.string(), "--threads", "1"};
    command.insert(command.end(), more.begin(), more.end());
    return command;
}

// history, and the driver's last state: it depends on every answer of every farm.
void check_same(const fs::path& a, const fs::path& b) {
    CHECK(content(a / "history.csv") == content(b / "history.csv"));
    REQUIRE_FALSE(checkpoints(b).empty());
    const fs::path last = checkpoints(a).back().filename();
    REQUIRE(last == checkpoints(b).back().filename());
    for (const char* file : {"driver.h5", "rve/law.h5"}) CHECK(differences(a / last / file, b / last / file).empty());
}

struct Reference {
    TemporaryFolder folder;
    fs::path scene, cache = folder / "cache", output = folder / "plain";
    explicit Reference(bool thaws = false) : scene(write_tiny_scene(folder, thaws ? thawing() : std::map<std::string, std::string>())) { REQUIRE(run_to_end(run_command(scene, output, {"--quiet"}), cache).end.code == 0); }
};

} // namespace

TEST_CASE("A farm killed or stopped in the middle of a run is replaced where the scene says so, and the run ends with the same bytes", "[lockstep][recovery]") {
    const auto [signal, thaws] = GENERATE(table<int, bool>({{SIGKILL, false}, {SIGKILL, true}, {SIGSTOP, false}}));
    CAPTURE(signal, thaws);
    const Reference reference(thaws);
    const fs::path output = reference.folder / "replaced";
    Program run(run_command(reference.scene, output, {"--set", "exchange.replace_farm=2", "--set", "exchange.replace_interval=0.1", "--stall-seconds", "1"}), reference.cache);
    for (const double begin = now(); checkpoints(output).empty() && now() - begin < 30;) pause(0.002); // half way: the scene writes one at 20 ms
    REQUIRE_FALSE(checkpoints(output).empty());
    const auto farm = run.child();
    REQUIRE(farm);
    kill(*farm, signal);
    const End end = run.wait(30);
    CAPTURE(run.text());
    CHECK(end.code == 0);
    CHECK(run.errors().empty());
    CHECK_CONTAINS(run.text(), signal == SIGKILL ? "was killed by signal 9 (SIGKILL): another farm takes over (1 of at most 2" : "has stalled: nothing of it moved for 1 s");
    CHECK_CONTAINS(content(output / "summary.json"), "\"replaced\": 1");
    CHECK_FALSE(fs::exists(output / "recovery"));
    CHECK(run.orphans(10).empty());
    check_same(reference.output, output);
}

TEST_CASE("Two and four farms, and another number of them after a restart, give the bytes of one", "[lockstep][recovery]") {
    const int farms = GENERATE(2, 4);
    const Reference reference;
    const fs::path output = reference.folder / "shared";
    const Finished whole = run_to_end(run_command(reference.scene, output, {"--quiet", "--farms", std::to_string(farms)}), reference.cache);
    CAPTURE(whole.text);
    REQUIRE(whole.end.code == 0);
    check_same(reference.output, output);
    CHECK(fs::exists(checkpoints(output).front() / "rve" / ("farm-" + std::to_string(farms - 1) + ".h5")));
    const Finished rest = run_to_end(run_command(reference.scene, output, {"--quiet", "--farms", std::to_string(farms == 2 ? 3 : 1), "--restart", checkpoints(output).front().string()}), reference.cache);
    CAPTURE(rest.text);
    REQUIRE(rest.end.code == 0);
    check_same(reference.output, output);
}

TEST_CASE("Driver and farm that meet in a folder leave the bytes of shared memory, and a log to follow", "[lockstep][recovery]") {
    const Reference reference;
    const fs::path output = reference.folder / "files";
    const std::string exchange = "file:" + (reference.folder / "exchange").string();
    Program farm({"rve-farm", "serve", "--quiet", "--threads", "1", "--exchange", exchange}, reference.cache);
    const Finished run = run_to_end(run_command(reference.scene, output, {"--quiet", "--exchange", exchange}), reference.cache);
    CAPTURE(run.text, farm.text());
    CHECK(run.end.code == 0);
    CHECK(farm.wait(10).code == 0);
    check_same(reference.output, output);
    const auto summary = nlohmann::json::parse(content(output / "summary.json"));
    CHECK_CONTAINS(content(reference.folder / "exchange" / "driver.log"), fmt::format("step answer of step {}", summary["steps"].get<int>()));
}
