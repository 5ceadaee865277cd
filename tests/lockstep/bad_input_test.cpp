// What a user may get wrong: each fault is one line that names it and says what to do, with exit code 2.
#include "tests/lockstep/support.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/text.hpp"

#include <csignal>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>

using namespace talik::lockstep;

namespace {

struct BadScene {
    std::string what;
    std::map<std::string, std::string> replace;
    std::vector<std::string> says;
    bool by_check = true; // `mpm-driver check` sees it, too: it needs no packing and no farm
};

const std::vector<BadScene> bad_scenes = {
    {"a misspelt key", {{"friction", "frictoin = 0.5"}}, {"scene.toml:20: rve.contact.frictoin", "did you mean \"friction\"?"}},
    {"a wrong unit", {{"cell", "cell = \"0.1 kPa\""}}, {"domain.cell", "kPa"}},
    {"a number where a text belongs", {{"name = \"sample\"", "name = 3"}}, {"body.0.name"}},
    {"a text where a number belongs", {{"pic", "pic = \"much\""}}, {"stage.0.pic"}},
    {"a negative size", {{"size", "size = [\"-0.4 m\", \"0.3 m\"]"}}, {"domain.size", "> 0"}},
    {"a missing key", {{"law", ""}}, {"body.0.law"}},
    {"TOML that is none", {{"seed = 3", "seed = = 3"}}, {"scene.toml:2"}},
    {"a body outside of the domain", {{"box", "box = [[\"0 m\", \"0 m\"], [\"0.2 m\", \"2 m\"]]"}}, {"body.0.box", "lies outside the domain"}},
    {"a wall that is none", {{"moves", "moves = [\"plat\"]"}}, {"stage.0.moves", "its walls are: base, plate"}},
    {"a grid beyond all memory", {{"cell", "cell = \"1e-6 m\""}}, {"domain.cell: 1e-06 m makes 1.2e+11 cells"}},
    {"a damping that turns the motion round", {{"pic", "grid_damping = 1e6"}}, {"stage.0.grid_damping: 1e+06 1/s times the step of"}, false},
    {"a packing that is missing", {{"discs", "file = \"none.h5\""}, {"void_ratio =", ""}, {"void_ratio_tol", ""}, {"count", ""}}, {"none.h5"}, false},
    {"a void ratio out of reach", {{"void_ratio =", "void_ratio = 0.05"}, {"void_ratio_tol", "void_ratio_tolerance = 0.001"}, {"count", ""}},
     {"out of reach", " to ", "choose a value in between"}, false},
    {"a macro step too large", {{"safety", "fixed = \"20 ms\""}}, {"the step of 0.02 s is beyond the largest stable one", "use step.fixed = \"auto\", or at most"}, false},
    {"a DEM step too large", {{"time_step", "time_step = \"1 ms\""}}, {"the DEM time step of 0.001 s is unstable", "the largest stable step of its contact network is"}, false},
};

} // namespace

TEST_CASE("A fault in a scene is one line with file, key and mend, exit code 2, and nothing is left behind", "[lockstep][fault]") {
    for (const BadScene& bad : bad_scenes) {
        TemporaryFolder folder;
        const fs::path cache = folder / "cache", scene = write_tiny_scene(folder, bad.replace);
        const Finished run = run_to_end({"mpm-driver", "run", scene.string(), "--output", (folder / "out").string(), "--quiet"}, cache);
        CAPTURE(bad.what, run.text);
        CHECK(run.end.code == 2);
        // A farm that found the fault says it, too: a line per process.
        REQUIRE_FALSE(run.errors.empty());
        CHECK(run.errors.size() <= 2);
        for (const std::string& part : bad.says) CHECK_CONTAINS(run.text, part);
        if (bad.by_check) {
            CHECK(run.errors.size() == 1);
            CHECK(run_to_end({"mpm-driver", "check", scene.string()}, cache).end.code == 2);
        }
        CHECK(halves(folder.path()).empty());
        CHECK(checkpoints(folder / "out").empty());
    }
}

TEST_CASE("`check` names every fault of a scene at once, a line each", "[lockstep][fault]") {
    TemporaryFolder folder;
    const fs::path scene = write_tiny_scene(folder, {{"friction", "frictoin = 0.5"}, {"cell", "cell = \"0.1 kPa\""}, {"pic", "pic = 2"}});
    const Finished check = run_to_end({"mpm-driver", "check", scene.string()}, folder / "cache");
    CAPTURE(check.text);
    CHECK(check.end.code == 2);
    CHECK(check.errors.size() == 3);
    const Finished sound = run_to_end({"mpm-driver", "check", write_tiny_scene(folder).string()}, folder / "cache");
    CHECK(sound.end.code == 0);
}

TEST_CASE("A call that cannot be meant is one line and exit code 2", "[lockstep][fault]") {
    TemporaryFolder folder;
    const std::string scene = write_tiny_scene(folder).string(), output = (folder / "out").string(), pipe = (folder / "pipe").string(), barred = (folder / "barred").string();
    const std::string alone = (folder / "alone.toml").string(); // no RVEs
    REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
    fs::create_directories(fs::path(barred) / "fields.h5");
    std::ofstream(alone) << "[domain]\nsize = [1, 1]\ncell = 0.25\n[[body]]\nname = \"b\"\nbox = [[0, 0], [1, 0.5]]\nlaw = \"elastic\"\ndensity = 2000\n[elastic]\nyoung = 1e6\npoisson = 0.3\n[[stage]]\nname = \"s\"\nduration = 0.02\n";
    struct Call {
        std::vector<std::string> arguments;
        std::string says;
    };
    const std::vector<Call> calls = {
        {{"mpm-driver", "run", (folder / "none.toml").string()}, "none.toml: cannot be read"},
        {{"mpm-driver", "run", scene, "--output", output, "--colour", "red"}, "--colour"},
        {{"mpm-driver", "run", scene, "--output", output, "--exchange", "pigeon:post"}, "no such transport"},
        {{"mpm-driver", "run", scene, "--output", output, "--exchange", "shm:a/b"}, "is no name for an exchange"},
        {{"mpm-driver", "run", scene, "--output", output, "--set", "rve.contact.frictoin=1"}, "friction"},
        {{"mpm-driver", "run", scene, "--output", scene + "/below-a-file"}, "cannot be written"},
        {{"mpm-driver", "run", scene, "--output", ""}, "--output: must not be empty"},
        {{"mpm-driver", "run", scene, "--output", output, "--until", "nan"}, "--until: \"nan\" does not begin with a number"},
        {{"mpm-driver", "run", scene, "--output", output, "--stall-seconds", "nan"}, "--stall-seconds: must be a number > 0"},
        {{"mpm-driver", "run", scene, "--output", output, "--threads", "-1"}, "--threads: must be a whole number from 0"},
        {{"rve-farm", "pack", scene, "-o", folder.path().string()}, "is a folder"},
        {{"rve-farm", "pack", scene, "-o", (folder / "none/packing.h5").string()}, "its folder does not exist"},
        {{"mpm-driver", "check", "/dev/null"}, "is no regular file but a pipe or a device"},
        {{"mpm-driver", "run", pipe, "--output", output}, "is no regular file but a pipe or a device"},
        {{"mpm-driver", "run", alone, "--output", output, "--exchange", "shm:" + unique_exchange_name()}, "has no RVEs for a farm to answer"},
        {{"mpm-driver", "run", alone, "--output", barred}, "fields.h5: is no regular file, but the run writes a file there"},
        {{"mpm-driver", "run", scene, "--output", output, "--set", "rve.time_step=1e-13"}, "too many DEM sub-steps"},
        {{"rve-farm", "serve", "--exchange", "pigeon:post"}, "no such transport"},
        {{"rve-farm", "serve", "--exchange", "shm:" + unique_exchange_name(), "--backend", "abacus"}, "--backend"},
    };
    for (const Call& call : calls) {
        const Finished run = run_to_end(call.arguments, folder / "cache");
        CAPTURE(call.says, run.text);
        CHECK(run.end.code == 2);
        CHECK(run.errors.size() == 1);
        CHECK_CONTAINS(run.text, call.says);
    }
}

TEST_CASE("An output folder that may not be written to is named before anything is prepared", "[lockstep][fault]") {
    TemporaryFolder folder;
    const fs::path closed = folder / "closed", cache = folder / "cache";
    fs::create_directory(closed);
    fs::permissions(closed, fs::perms::owner_read | fs::perms::owner_exec);
    if (access(closed.c_str(), W_OK) == 0) { // root may write everywhere, but not below /proc
        const Finished run = run_to_end({"mpm-driver", "run", write_tiny_scene(folder).string(), "--output", "/proc/talik", "--quiet"}, cache);
        CHECK(run.end.code == 2);
        CHECK_CONTAINS(run.text, "/proc/talik: cannot be written");
        CHECK_FALSE(fs::exists(cache / "packings"));
        return;
    }
    const Finished run = run_to_end({"mpm-driver", "run", write_tiny_scene(folder).string(), "--output", (closed / "out").string(), "--quiet"}, cache);
    CHECK(run.end.code == 2);
    CHECK_CONTAINS(run.text, "cannot be written: Permission denied");
    CHECK_FALSE(fs::exists(cache / "packings"));
}

TEST_CASE("What is written replaces nothing but a file of its own kind", "[lockstep][fault]") {
    TemporaryFolder folder;
    const std::string scene = write_tiny_scene(folder).string(), output = (folder / "out").string(), pipe = (folder / "pipe").string(), packing = (folder / "packing.h5").string();
    REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
    std::ofstream(packing) << "thesis";
    const std::string kept = content(scene);
    struct Call {
        std::vector<std::string> arguments;
        std::string says;
    };
    const std::vector<std::string> run = {"mpm-driver", "run", scene, "--output", output, "--quiet", "--record"};
    const auto recording = [&](const std::string& file) { auto call = run; call.push_back(file); return call; };
    const std::vector<Call> calls = {
        {recording(scene), "is there already, and is no file of the format \"talik-record 1\""},
        {recording(pipe), "is no regular file"},
        {recording(output + "/history.csv"), "the run writes that file itself"},
        {recording(output + "/checkpoint-000000001.part/x"), "the run writes that file itself"},
        {{"rve-farm", "pack", scene, "-o", scene}, "is there already, and is no file of the format \"talik-packing 1\""},
        {{"rve-farm", "pack", scene, "-o", packing}, "is there already"},
        {{"rve-farm", "pack", scene, "-o", pipe}, "is no regular file"},
    };
    for (const Call& call : calls) {
        const Finished end = run_to_end(call.arguments, folder / "cache");
        CAPTURE(call.says, end.text);
        CHECK(end.end.code == 2);
        CHECK(end.errors.size() == 1);
        CHECK_CONTAINS(end.text, call.says);
    }
    CHECK(content(scene) == kept);
    CHECK(content(packing) == "thesis");
    CHECK_FALSE(fs::exists(folder / "cache/packings"));
    CHECK_FALSE(fs::exists(folder / "out/history.csv"));
}

TEST_CASE("A run removes checkpoints of its own making only: folders that a user keeps beside them stay", "[lockstep][fault]") {
    TemporaryFolder folder;
    const fs::path output = folder / "out";
    for (const char* name : {"checkpoint-000000001.bak", "checkpoint-thesis.part", "checkpoint-", "checkpoint-000000007.part", "checkpoint-000000001"}) fs::create_directories(output / name);
    REQUIRE(run_to_end({"mpm-driver", "run", write_tiny_scene(folder).string(), "--output", output.string(), "--quiet"}, folder / "cache").end.code == 0);
    for (const char* name : {"checkpoint-000000001.bak", "checkpoint-thesis.part", "checkpoint-"}) CHECK(fs::exists(output / name));
    for (const char* name : {"checkpoint-000000007.part", "checkpoint-000000001"}) CHECK_FALSE(fs::exists(output / name));
}

TEST_CASE("A run that is refused leaves the run before it in that folder as it was", "[lockstep][fault]") {
    TemporaryFolder folder;
    const fs::path output = folder / "out";
    const std::vector<std::string> call = {"mpm-driver", "run", write_tiny_scene(folder).string(), "--output", output.string(), "--quiet"};
    REQUIRE(run_to_end(call, folder / "cache").end.code == 0);
    const auto all = [&] {
        std::string text;
        for (const char* name : {"history.csv", "summary.json", "fields.h5", "fields.pvd"}) text += content(output / name);
        for (const fs::path& checkpoint : checkpoints(output)) text += checkpoint.string() + content(checkpoint / "driver.h5");
        return text;
    };
    const std::string before = all();
    for (const char* set : {"step.fixed=1", "stage.0.grid_damping=1e6", "rve.time_step=1", "rve.time_step=1e-300"}) {
        auto refused = call;
        refused.insert(refused.end(), {"--set", set});
        const Finished end = run_to_end(refused, folder / "cache");
        CAPTURE(set, end.text);
        CHECK(end.end.code == 2);
        CHECK(all() == before);
    }
}

TEST_CASE("Two runs do not share an output folder: the second is refused, the first goes on", "[lockstep][fault]") {
    TemporaryFolder folder;
    const std::string scene = write_endless_scene(folder).string(), output = (folder / "out").string();
    Program first({"mpm-driver", "run", scene, "--output", output, "--quiet"}, folder / "cache");
    REQUIRE(appears(folder / "out/history.csv", 30.0));
    const Finished second = run_to_end({"mpm-driver", "run", scene, "--output", output, "--quiet"}, folder / "cache");
    CAPTURE(second.text);
    CHECK(second.end.code == 2);
    CHECK_CONTAINS(second.text, "is in use by another run");
    CHECK(first.running());
    first.send(SIGINT);
    CHECK(first.wait(30.0).code == 1);
    first.orphans(30.0);
}

TEST_CASE("A damaged packing in the cache is prepared again: a run from the start removes checkpoints of an earlier one", "[lockstep][fault]") {
    TemporaryFolder folder;
    const fs::path cache = folder / "cache", output = folder / "out";
    const std::vector<std::string> call = {"mpm-driver", "run", write_tiny_scene(folder).string(), "--output", output.string()};
    REQUIRE(run_to_end(call, cache).end.code == 0);
    fs::create_directory(output / "checkpoint-000999999");
    for (const auto& entry : fs::directory_iterator(cache / "packings")) fs::resize_file(entry.path(), 1000);
    const Finished again = run_to_end(call, cache);
    CAPTURE(again.text);
    CHECK(again.end.code == 0);
    CHECK_CONTAINS(again.text, "it is removed and prepared again");
    CHECK_CONTAINS(again.text, "of an earlier run");
    CHECK_FALSE(fs::exists(output / "checkpoint-000999999"));
}

TEST_CASE("A cache that cannot be written is mended by TALIK_CACHE", "[lockstep][fault]") {
    TemporaryFolder folder;
    const fs::path cache = folder / "cache";
    fs::create_directory(cache);
    std::ofstream(cache / "packings") << "a file where the folder belongs";
    const Finished run = run_to_end({"mpm-driver", "run", write_tiny_scene(folder).string(), "--output", (folder / "out").string(), "--quiet"}, cache);
    CHECK(run.end.code == 2);
    CHECK_CONTAINS(run.text, "set TALIK_CACHE to a folder you may write to");
}
