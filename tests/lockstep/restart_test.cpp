// A run cut at a checkpoint and gone on with is the run that was not cut, byte for byte.
#include "tests/lockstep/support.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/text.hpp"

#include <fstream>

using namespace talik::lockstep;

namespace {

std::vector<std::string> run_command(const fs::path& scene, const fs::path& output, const std::vector<std::string>& more = {}, const std::string& threads = "1") {
    std::vector<std::string> command = {"mpm-driver", "run", scene.string(), "--output", output.string(), "--quiet", "--threads", threads};
    command.insert(command.end(), more.begin(), more.end());
    return command;
}

void check_same_outputs(const fs::path& a, const fs::path& b) {
    CHECK(content(a / "history.csv") == content(b / "history.csv"));
    CHECK(differences(a / "fields.h5", b / "fields.h5").empty());
    CHECK(content(a / "fields.pvd") == content(b / "fields.pvd"));
    std::size_t views = 0;
    for (const auto& view : fs::directory_iterator(a / "fields")) {
        ++views;
        CHECK(content(view.path()) == content(b / "fields" / view.path().filename()));
    }
    CHECK(views == 5); // at 0, 10, 20, 30, 40 ms
    REQUIRE_FALSE(checkpoints(b).empty());
    const fs::path last = checkpoints(a).back().filename();
    REQUIRE(last == checkpoints(b).back().filename());
    for (const char* file : {"driver.h5", "rve/farm.h5", "rve/law.h5"}) CHECK(differences(a / last / file, b / last / file).empty());
}

} // namespace

TEST_CASE("A run restarted from a checkpoint in its middle ends with the bytes of the run that was not cut, with any number of threads",
          "[lockstep][restart]") {
    TemporaryFolder folder;
    const fs::path scene = write_tiny_scene(folder), cache = folder / "cache", whole = folder / "whole", cut = folder / "cut";
    REQUIRE(run_to_end(run_command(scene, whole), cache).end.code == 0);
    const auto checkpoint = checkpoints(whole).front();

    const std::string threads = GENERATE("1", "2");
    // Beyond the checkpoint at 20 ms, so that rows and fields after it are there to be dropped.
    REQUIRE(run_to_end(run_command(scene, cut, {"--until", "0.0333"}), cache).end.code == 0);
    REQUIRE(checkpoints(cut).front().filename() == checkpoint.filename());
    const Finished restarted =
        run_to_end(run_command(scene, cut, {"--restart", checkpoints(cut).front().string()}, threads), cache);
    CAPTURE(restarted.text);
    REQUIRE(restarted.end.code == 0);
    check_same_outputs(whole, cut);
}

TEST_CASE("Two runs of one scene leave the same history and fields", "[lockstep][restart]") {
    TemporaryFolder folder;
    const fs::path scene = write_tiny_scene(folder), cache = folder / "cache";
    REQUIRE(run_to_end(run_command(scene, folder / "a"), cache).end.code == 0);
    REQUIRE(run_to_end(run_command(scene, folder / "b", {}, "2"), cache).end.code == 0);
    check_same_outputs(folder / "a", folder / "b");
    // The comparison does see another state where there is one.
    const auto two = checkpoints(folder / "a");
    REQUIRE(two.size() == 2);
    for (const char* file : {"driver.h5", "rve/farm.h5", "rve/law.h5"}) CHECK_FALSE(differences(two[0] / file, two[1] / file).empty());
}

TEST_CASE("A checkpoint is refused by another scene, and what is no checkpoint is called so", "[lockstep][restart]") {
    TemporaryFolder folder;
    const fs::path scene = write_tiny_scene(folder), cache = folder / "cache", output = folder / "out";
    REQUIRE(run_to_end(run_command(scene, output, {"--until", "0.005"}), cache).end.code == 0);
    const std::string checkpoint = checkpoints(output).front().string();
    const std::string history = content(output / "history.csv");

    const Finished other = run_to_end(run_command(scene, output, {"--restart", checkpoint, "--set", "rve.contact.friction=0.4"}), cache);
    CHECK(other.end.code == 2);
    CHECK_CONTAINS(other.text, checkpoint + ": belongs to another scene");
    CHECK(content(output / "history.csv") == history); // and nothing is lost by the attempt

    const Finished none = run_to_end(run_command(scene, output, {"--restart", folder.path().string()}), cache);
    CHECK(none.end.code == 2);
    CHECK_CONTAINS(none.text, "is not a checkpoint");
}

TEST_CASE("A half-written checkpoint is no checkpoint: the next run removes it", "[lockstep][restart]") {
    TemporaryFolder folder;
    const fs::path scene = write_tiny_scene(folder), cache = folder / "cache", output = folder / "out";
    REQUIRE(run_to_end(run_command(scene, output, {"--until", "0.005"}), cache).end.code == 0);
    const fs::path whole = checkpoints(output).front(), half = output / "checkpoint-000000020.part";
    fs::create_directories(half / "rve");
    std::ofstream(half / "rve" / "farm.h5") << "half of a file";
    const Finished restarted = run_to_end(run_command(scene, output, {"--restart", whole.string(), "--until", "0.01"}), cache);
    CAPTURE(restarted.text);
    CHECK(restarted.end.code == 0);
    CHECK_FALSE(fs::exists(half));
    CHECK(halves(output).empty());
}

TEST_CASE("A checkpoint with one damaged byte, wherever it lies, is refused in one line with exit code 2", "[lockstep][restart]") {
    TemporaryFolder folder;
    const fs::path scene = write_tiny_scene(folder), cache = folder / "cache", output = folder / "out";
    REQUIRE(run_to_end(run_command(scene, output, {"--until", "0.005"}), cache).end.code == 0);
    const fs::path checkpoint = checkpoints(output).front();
    for (const char* file : {"rve/farm.h5", "rve/law.h5", "driver.h5"}) {
        const std::string sound = content(checkpoint / file);
        // The tables of HDF5 stand first, then numbers, then the seal: places spread evenly meet all of them.
        constexpr std::size_t places = 8;
        for (std::size_t place = 0; place < places; ++place) {
            const std::size_t at = place * (sound.size() - 1) / (places - 1);
            std::string damaged = sound;
            damaged[at] = static_cast<char>(~damaged[at]);
            std::ofstream(checkpoint / file, std::ios::binary) << damaged;
            const Finished restarted = run_to_end(run_command(scene, folder / "restarted", {"--restart", checkpoint.string()}), cache);
            CAPTURE(file, at, sound.size(), restarted.end.signal, restarted.text);
            CHECK(restarted.end.code == 2);
            REQUIRE(restarted.errors.size() == 1);
            CHECK_CONTAINS(restarted.errors[0], (checkpoint / file).string());
            CHECK_CONTAINS(restarted.errors[0], "is damaged");
            CHECK_CONTAINS(restarted.errors[0], "take another checkpoint");
        }
        std::ofstream(checkpoint / file, std::ios::binary) << sound;
    }
    CHECK(run_to_end(run_command(scene, output, {"--restart", checkpoint.string(), "--until", "0.01"}), cache).end.code == 0);
}

TEST_CASE("Fields that a killed run left damaged do not bar the restart from a sound checkpoint", "[lockstep][restart]") {
    TemporaryFolder folder;
    const fs::path scene = write_tiny_scene(folder), cache = folder / "cache", output = folder / "out";
    REQUIRE(run_to_end(run_command(scene, output, {"--until", "0.0201"}), cache).end.code == 0);
    fs::resize_file(output / "fields.h5", fs::file_size(output / "fields.h5") / 2);
    const Finished restarted = run_to_end(run_command(scene, output, {"--restart", checkpoints(output).back().string()}), cache);
    CAPTURE(restarted.text);
    CHECK(restarted.end.code == 0);
    CHECK_CONTAINS(restarted.text, "outputs of the run before are kept");
    CHECK(differences(output / "fields.h5", output / "fields.h5").empty()); // readable to its end
}
