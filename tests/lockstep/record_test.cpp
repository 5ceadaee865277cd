// Recordings: a replayed run is the recorded one to the bit, a run that leaves its recording is told where, and a recording is
// whole up to its last step whatever ended its writer.
#include <csignal>
#include <fstream>

#include <fmt/format.h>

#include "common/base/error.hpp"
#include "exchange/record_file.hpp"
#include "tests/lockstep/support.hpp"
#include "tests/lockstep/tiny_disk.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/text.hpp"

using namespace talik;
using namespace talik::lockstep;

namespace {

// A run of the tiny scene with more options; fails the test where it does not end as it should.
Finished run(const TemporaryFolder& folder, const fs::path& scene, const std::string& output, std::vector<std::string> more, int code = 0) {
    std::vector<std::string> arguments = {"mpm-driver", "run", scene.string(), "--output", (folder / output).string(), "--quiet", "--threads", "1"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Finished done = run_to_end(arguments, folder / "cache");
    INFO(done.text);
    REQUIRE(done.end.code == code);
    return done;
}

std::size_t numbers_of_an_answer(const exchange::Record& record) {
    int components = 0;
    for (const auto& column : record.facts().answer_columns) components += column.components;
    return static_cast<std::size_t>(components) * record.facts().rves;
}

void require_same(const fs::path& a, const fs::path& b) {
    CHECK(content(a / "history.csv") == content(b / "history.csv"));
    CHECK(differences(a / "fields.h5", b / "fields.h5").empty());
    const auto there = checkpoints(b);
    REQUIRE(checkpoints(a).size() == there.size());
    for (const fs::path& checkpoint : checkpoints(a)) {
        const fs::path other = b / checkpoint.filename();
        for (const auto& entry : fs::recursive_directory_iterator(checkpoint)) // the farm's own state is not the driver's
            if (entry.path().extension() == ".h5" && entry.path().filename() != "farm.h5") CHECK(differences(entry.path(), other / fs::relative(entry.path(), checkpoint)).empty());
    }
}

} // namespace

TEST_CASE("A replayed run is the recorded one to the bit: history, fields and checkpoints", "[lockstep][record]") {
    const TemporaryFolder folder;
    const fs::path scene = write_tiny_scene(folder), file = folder / "record.h5";
    run(folder, scene, "plain", {});
    run(folder, scene, "recorded", {"--record", file.string()});
    require_same(folder / "plain", folder / "recorded"); // recording changes nothing
    run(folder, scene, "replayed", {"--replay", file.string(), "--tolerance", "0"});
    require_same(folder / "recorded", folder / "replayed");
    CHECK(halves(folder.path()).empty());

    const exchange::Record record(file.string());
    CHECK(record.facts().rves == 16);
    CHECK(record.steps().front().step == 1);
    // A replay goes on from a checkpoint of the recorded run, and from one of its own.
    for (const char* of : {"recorded", "replayed"}) {
        const std::string name = std::string("continued-") + of;
        fs::copy(folder / of, folder / name, fs::copy_options::recursive);
        run(folder, scene, name, {"--replay", file.string(), "--restart", checkpoints(folder / name).front().string()});
        require_same(folder / "recorded", folder / name);
    }
    // A farm does not go on from a replay: it has no discs.
    const Finished refused = run(folder, scene, "real", {"--restart", checkpoints(folder / "replayed").front().string()}, 2);
    CHECK_CONTAINS(refused.text, "talik-replay-checkpoint");
}

TEST_CASE("A run that leaves its recording ends with the step, the RVE and the component that left it: loosely it goes on and says so", "[lockstep][record]") {
    const TemporaryFolder folder;
    const fs::path scene = write_tiny_scene(folder), file = folder / "record.h5";
    run(folder, scene, "recorded", {"--record", file.string()});
    const Finished left = run(folder, scene, "left", {"--replay", file.string(), "--set", "wall.1.velocity=\"-0.11 m/s\""}, 1);
    REQUIRE(left.errors.size() == 1);
    CHECK_CONTAINS(left.errors[0], "step 1: RVE ");
    CHECK_CONTAINS(left.errors[0], "displacement_gradient_increment[");
    CHECK_CONTAINS(left.errors[0], "was recorded");
    const Finished longer = run(folder, scene, "longer", {"--replay", file.string(), "--set", "stage.0.duration=\"0.05 s\"", "--tolerance", "1e6"}, 1);
    CHECK_CONTAINS(longer.text, "it holds steps 1 to ");
    std::vector<std::string> arguments = {"mpm-driver", "run", scene.string(), "--output", (folder / "loose").string(), "--threads", "1", "--replay", file.string(), "--loose", "--set", "wall.1.velocity=\"-0.11 m/s\""};
    const Finished loose = run_to_end(arguments, folder / "cache");
    INFO(loose.text);
    CHECK(loose.end.code == 0);
    CHECK_CONTAINS(loose.text, "replayed loosely");
    CHECK_CONTAINS(loose.text, "a loose replay is no solution");
    // Of the recorded run itself the nearest answers are the recorded ones.
    run(folder, scene, "exact", {"--replay", file.string(), "--loose"});
    CHECK(content(folder / "recorded" / "history.csv") == content(folder / "exact" / "history.csv"));
    CHECK_CONTAINS(run(folder, scene, "both", {"--replay", file.string(), "--record", file.string()}, 2).text, "name another file");
    CHECK_CONTAINS(run(folder, scene, "none", {"--replay", (folder / "none.h5").string()}, 2).text, "no such recording");
    std::ofstream(folder / "foreign.h5") << "no HDF5";
    CHECK_CONTAINS(run(folder, scene, "foreign", {"--replay", (folder / "foreign.h5").string()}, 2).text, "is not a readable HDF5 file");
}

TEST_CASE("A recording goes on with its run after a restart: steps after the checkpoint are recorded anew", "[lockstep][record]") {
    const TemporaryFolder folder;
    const fs::path scene = write_tiny_scene(folder), file = folder / "record.h5", output = folder / "cut";
    run(folder, scene, "whole", {"--record", (folder / "whole.h5").string()});
    run(folder, scene, "cut", {"--record", file.string()});
    run(folder, scene, "cut", {"--record", file.string(), "--restart", checkpoints(output).front().string()});
    const exchange::Record whole((folder / "whole.h5").string()), cut(file.string());
    REQUIRE(cut.steps().size() == whole.steps().size());
    std::vector<double> here(numbers_of_an_answer(whole)), there(here);
    for (std::size_t i = 0; i < cut.steps().size(); ++i) {
        CHECK(cut.steps()[i].step == whole.steps()[i].step);
        whole.read_answer(i, here);
        cut.read_answer(i, there);
        CHECK(here == there);
    }
    // Of another scene it is refused, and stays what it was.
    const std::string before = content(file);
    const fs::path other = write_tiny_scene(folder, {{"pic", "pic = 0.002"}});
    CHECK_CONTAINS(run(folder, other, "other", {}).text, "");
    run(folder, other, "other", {"--record", file.string(), "--restart", checkpoints(folder / "other").front().string()}, 2);
    CHECK(content(file) == before);
}

TEST_CASE("A driver killed at any moment leaves a recording that is whole up to a step, and replays to there", "[lockstep][record][fault]") {
    const TemporaryFolder folder;
    const fs::path scene = write_endless_scene(folder), file = folder / "record.h5";
    for (int kill = 0; kill < 8; ++kill) {
        fs::remove(file);
        Program program({"mpm-driver", "run", scene.string(), "--output", (folder / "killed").string(), "--quiet", "--threads", "1", "--record", file.string()}, folder / "cache");
        REQUIRE(appears(file, 30));
        pause(0.02 + 0.037 * kill);
        program.send(SIGKILL);
        program.wait(10);
        program.orphans(10);
        const exchange::Record record(file.string());
        INFO(record.steps().size());
        std::vector<double> answer(numbers_of_an_answer(record));
        for (std::size_t i = 0; i < record.steps().size(); ++i) CHECK_NOTHROW(record.read_answer(i, answer));
        if (kill < 7) continue;
        REQUIRE(record.steps().size() > 3);
        const Finished replayed = run(folder, scene, "replayed", {"--replay", file.string()}, 1);
        CHECK_CONTAINS(replayed.text, fmt::format("it holds steps 1 to {}", record.steps().back().step));
    }
}

TEST_CASE("A disk that fills up while a run is recorded ends it with exit code 4, one line and a checkpoint: what was recorded stays", "[lockstep][record][fault]") {
    const TemporaryFolder folder;
    const fs::path disk = folder / "disk", scene = write_endless_scene(folder);
    const TinyDisk tiny(disk, "300k");
    if (!tiny.mounted()) {
        WARN("no disk of its own can be mounted here: " << tiny.why());
        return;
    }
    Finished full;
    {
        Program program({"mpm-driver", "run", scene.string(), "--output", (folder / "full").string(), "--quiet", "--threads", "1", "--record", (disk / "record.h5").string()}, folder / "cache");
        const End end = program.wait(60);
        program.orphans(10);
        full = {end, program.text(), program.errors()};
    }
    std::size_t recorded = 0;
    try {
        recorded = exchange::Record((disk / "record.h5").string()).steps().size();
    } catch (const Error& error) {
        UNSCOPED_INFO(error.what());
    }
    INFO(full.text);
    CHECK(full.end.code == 4);
    REQUIRE(full.errors.size() == 1);
    CHECK_CONTAINS(full.errors[0], "the disk is full");
    CHECK_CONTAINS(full.errors[0], "record.h5");
    CHECK_CONTAINS(full.errors[0], "last good checkpoint");
    CHECK(recorded > 10);
}
