// What a run leaves: a summary that scripts can rely on, and a good checkpoint where the disk is full.
#include "tests/lockstep/support.hpp"
#include "tests/lockstep/tiny_disk.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/text.hpp"

#include <nlohmann/json.hpp>

using namespace talik::lockstep;
using Json = nlohmann::json;

TEST_CASE("summary.json holds every key that scripts rely on, and its numbers agree with the run", "[lockstep]") {
    TemporaryFolder folder;
    const fs::path output = folder / "out";
    const Finished run = run_to_end({"mpm-driver", "run", write_tiny_scene(folder).string(), "--output", output.string(), "--quiet", "--threads", "1"}, folder / "cache");
    REQUIRE(run.end.code == 0);
    const Json summary = Json::parse(content(output / "summary.json"));
    for (const char* key : {"/scene", "/scene_hash", "/version", "/effects/on", "/effects/off", "/steps", "/time_end", "/rves", "/rve_evaluations/asked",
                            "/rve_evaluations/done", "/rve_evaluations/avoided", "/wall_seconds/total", "/waiting_seconds/driver", "/waiting_seconds/farm", "/lockstep_seconds/driver/computing", "/lockstep_seconds/farm/copying", "/bottleneck",
                            "/balance/mass", "/balance/momentum", "/balance/energy", "/balance/heat", "/warnings", "/exit"}) {
        CAPTURE(key);
        CHECK(summary.contains(Json::json_pointer(key)));
    }
    // ... and none that the page for users does not name.
    const std::string page = content(fs::path(TALIK_SOURCE_DIR) / "docs/interface.md");
    for (const auto& [key, value] : summary.items()) {
        CAPTURE(key);
        CHECK((page.find("`" + key + "`") != std::string::npos || page.find("`" + key + ".") != std::string::npos));
    }
    CHECK(summary["cpu_seconds"] > summary["lockstep_seconds"]["farm"]["computing"]); // the farm's time is counted, with the driver's own
    CHECK(summary["exit"] == 0);
    CHECK(summary["rves"] == 16);
    CHECK(summary["time_end"].get<double>() == Approx(0.04));
    CHECK(summary["rve_evaluations"]["asked"] == 16 * summary["steps"].get<int>());
    const double total = summary["wall_seconds"]["total"];
    for (const char* side : {"driver", "farm"}) {
        const double waited = summary["waiting_seconds"][side];
        CHECK(waited > 0.0); // each waits at least for the other's start
        CHECK(waited < total + 5.0);
    }
    // Sub-steps are at most as long as the scene allows (20 us) and no more than needed: n = ceil(dt / 20 us) of the last step,
    // which is cut so that the run ends on time, hence more than half of 20 us for any n > 1.
    CHECK(summary["dem_time_step_s"].get<double>() <= 2e-5 * (1 + 1e-9));
    CHECK(summary["dem_time_step_s"].get<double>() > 1e-5);
}

TEST_CASE("A summary is written, and names the cause, where a run fails", "[lockstep]") {
    TemporaryFolder folder;
    const fs::path output = folder / "out";
    const fs::path scene = write_tiny_scene(folder, {{"safety", "fixed = \"20 ms\""}});
    const Finished run = run_to_end({"mpm-driver", "run", scene.string(), "--output", output.string(), "--quiet"}, folder / "cache");
    REQUIRE(run.end.code == 2);
    const Json summary = Json::parse(content(output / "summary.json"));
    CHECK(summary["exit"] == 2);
    CHECK_CONTAINS(summary["cause"].get<std::string>(), "beyond the largest stable one");
    CHECK(summary["waiting_seconds"]["farm"].is_null()); // it was not asked any more
}

TEST_CASE("A full disk ends a run with exit code 4 and one line that names the last good checkpoint, which restarts", "[lockstep][fault]") {
    const bool thaws = GENERATE(false, true);
    CAPTURE(thaws);
    TemporaryFolder folder;
    const fs::path disk = folder / "disk", cache = folder / "cache", crowded = write_endless_scene(folder, "0.7 ms", thaws);
    const TinyDisk tiny(disk, "1500k");
    if (!tiny.mounted()) {
        WARN("skipped: no file system of our own can be mounted here (" << tiny.why() << ")");
        return;
    }
    const fs::path output = disk / "out";
    // Fields at every step fill the disk within a second or so.
    const Finished run = run_to_end({"mpm-driver", "run", crowded.string(), "--output", output.string(), "--quiet", "--threads", "1"}, cache);
    CAPTURE(run.text);
    CHECK(run.end.code == 4);
    REQUIRE_FALSE(run.errors.empty());
    CHECK(run.errors.size() <= 2); // the farm's own, where it is what could not write its checkpoint
    REQUIRE_FALSE(checkpoints(output).empty());
    CHECK_CONTAINS(run.text, "last good checkpoint: " + checkpoints(output).back().string());
    CHECK(halves(output).empty());
    const Finished restarted = restart(crowded, checkpoints(output).back(), folder / "elsewhere", cache);
    CAPTURE(restarted.text);
    CHECK(restarted.end.code == 0);
}
