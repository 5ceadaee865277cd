// Heat, bonds, points and discs together: a vertical cut that stands while it is frozen and falls when it thaws.
#include <algorithm>
#include <cmath>
#include <fstream>

#include "common/io/csv_table.hpp"
#include "common/io/hdf5_file.hpp"
#include "tests/lockstep/support.hpp"
#include "tests/support/catch.hpp"

using namespace talik::lockstep;

namespace {

// 0.4 m high and wide, 64 points; thawed from within by a uniform source. A cohesionless vertical cut cannot stand.
std::string cut(const std::string& power, const std::string& bond_keys = "") {
    return R"(
title = "vertical cut"
[domain]
origin = ["-0.1 m", "-0.1 m"]
size = ["1.4 m", "0.8 m"]
cell = "0.1 m"
[[body]]
name = "left"
box = [["0 m", "0 m"], ["0.2 m", "0.4 m"]]
law = "rve"
material = "sand"
temperature = "-1 degC"
[[body]]
name = "right"
box = [["0.2 m", "0 m"], ["0.4 m", "0.4 m"]]
law = "rve"
material = "sand"
temperature = "-1 degC"
[rve]
time_step = "2e-5 s"
[rve.packing]
discs = 30
void_ratio = 0.2
void_ratio_tolerance = 0.02
pressure = "500 Pa"
[rve.packing.k0]
levels = 4
[rve.contact]
friction = 0.3
[rve.bond]
normal_strength = "2 MPa"
tangential_strength = "2 MPa"
)" + bond_keys + R"(
[heat]
time_scale = 86400
[[heat.material]]
name = "sand"
porosity = 0.4
grain_heat_capacity = 850
grain_conductivity = 3
residual_temperature = "-0.5 degC"
[[heat.source]]
name = "warmth"
power = )" + power + R"(
[[wall]]
name = "left"
side = "left"
position = "0 m"
[[wall]]
name = "base"
side = "bottom"
position = "0 m"
kind = "fixed"
[[stage]]
name = "frozen"
duration = "0.1 s"
activates = ["bonds"]
gravity = ["0 m/s^2", "-9.81 m/s^2"]
particle_damping = 20
[[stage]]
name = "thaw"
duration = "0.3 s"
gravity = ["0 m/s^2", "-9.81 m/s^2"]
pic = 0.01
[output]
history_interval = "20 ms"
fields_interval = "0.1 s"
checkpoint_interval = "0.15 s"
)";
}

// Latent heat of 400 kg/m^3 of water is 1.33e8 J/m^3: all of it within 0.15 s of the scene, which are 0.15 days.
const std::string warm = "\"12 kW/m^3\"", cold = "0";

fs::path written(const TemporaryFolder& folder, const std::string& name, const std::string& text) {
    std::ofstream(folder / name) << text;
    return folder / name;
}

Finished run_scene(const fs::path& scene, const fs::path& output, const fs::path& cache, const std::vector<std::string>& more = {}) {
    std::vector<std::string> command = {"mpm-driver", "run", scene.string(), "--output", output.string(), "--quiet"};
    command.insert(command.end(), more.begin(), more.end());
    return run_to_end(command, cache);
}

double last_of(const fs::path& output, const std::string& column) {
    return talik::read_csv((output / "history.csv").string()).values(column).back();
}

} // namespace

TEST_CASE("a frozen vertical cut stands: the same cut falls when its ice melts", "[lockstep][eq8][thaw]") {
    TemporaryFolder folder;
    for (const bool thaws : {false, true}) {
        const fs::path output = folder / (thaws ? "warm" : "cold");
        const Finished run = run_scene(written(folder, "scene.toml", cut(thaws ? warm : cold)), output, folder / "cache");
        CAPTURE(run.text, thaws);
        REQUIRE(run.end.code == 0);
        const double strain = last_of(output, "mean_strain_yy");
        if (thaws) {
            CHECK(strain < -0.02); // it sinks by centimetres
            CHECK(last_of(output, "ice_m3") < 1e-6);
        } else {
            CHECK(strain > -2e-3); // settled a little under its own weight, for good
            CHECK(last_of(output, "largest_speed_m_per_s") < 0.02);
        }
        CHECK(last_of(output, "balance_heat") < 1e-12);
    }
}

TEST_CASE("bonds are activated in the bodies that a stage names, and nowhere else", "[lockstep][eq6]") {
    TemporaryFolder folder;
    std::string text = cut(cold);
    text.replace(text.find("activates = [\"bonds\"]"), 21, "activates = [\"bonds\"]\nactivates_in = [\"left\"]");
    const Finished run = run_scene(written(folder, "scene.toml", text), folder / "out", folder / "cache", {"--until", "0.01"});
    CAPTURE(run.text);
    REQUIRE(run.end.code == 0);
    const talik::Hdf5File file = talik::Hdf5File::open((folder / "out" / "fields.h5").string());
    const auto bonds = file.read<double>("/output_000001/bonds").values, body = file.read<double>("/output_000001/body").values;
    for (std::size_t p = 0; p < bonds.size(); ++p) CHECK((bonds[p] > 0.0) == (body[p] == 0.0));
}

TEST_CASE("a run cut while it thaws and bonds form anew ends with the bytes of the run that was not cut", "[lockstep][restart][rebond][thaw]") {
    TemporaryFolder folder;
    const fs::path cache = folder / "cache", whole = folder / "whole", part = folder / "part";
    // Thaws and freezes within each 0.1 days, with swelling: every state of this file's effects is in the checkpoint.
    std::string text = cut("0\namplitude = \"60 kW/m^3\"\nperiod = \"0.1 d\"", "rebond_on_freezing = true\n");
    text.insert(text.find("[domain]"), "[phase_change_strain]\n");
    const fs::path scene = written(folder, "scene.toml", text);
    const Finished first = run_scene(scene, whole, cache, {"--until", "0.25"});
    CAPTURE(first.text);
    REQUIRE(first.end.code == 0);
    REQUIRE(run_scene(scene, part, cache, {"--until", "0.18"}).end.code == 0);
    const Finished second = run_scene(scene, part, cache, {"--until", "0.25", "--restart", checkpoints(part).front().string()});
    CAPTURE(second.text);
    REQUIRE(second.end.code == 0);
    CHECK(content(whole / "history.csv") == content(part / "history.csv"));
    const fs::path last = checkpoints(whole).back().filename();
    for (const char* file : {"driver.h5", "rve/farm.h5", "rve/law.h5"}) CHECK(differences(whole / last / file, part / last / file).empty());
}

TEST_CASE("the shipped slope slides when its heater is on, and stands when it is off", "[lockstep][thaw][long]") {
    TemporaryFolder folder;
    const auto farthest = [&](const std::string& begins) { // displacement of any point at 1.5 s, m
        const fs::path output = folder / begins;
        Program run({"mpm-driver", "run", TALIK_SOURCE_DIR "/cases/thaw-slope/quick.toml", "--output", output.string(), "--quiet", "--until", "1.5",
                     "--set", "heat.heater.0.begins=\"" + begins + "\""}, folder / "cache");
        const End end = run.wait(1500.0);
        CAPTURE(run.text());
        REQUIRE(end.code == 0);
        const talik::Hdf5File file = talik::Hdf5File::open((output / "fields.h5").string());
        std::string last;
        for (const auto& name : file.children("/")) last = name.rfind("output_", 0) == 0 ? std::max(last, name) : last;
        const auto displacement = file.read<double>("/" + last + "/displacement").values;
        double most = 0.0;
        for (std::size_t i = 0; i + 2 < displacement.size(); i += 3) most = std::max(most, std::hypot(displacement[i], displacement[i + 1]));
        return most;
    };
    CHECK(farthest("0.4 s") > 0.1);    // decimetres, and on its way (0.4 m in the README's run)
    CHECK(farthest("1 h") < 0.01);  // what gravity's start has settled: millimetres
}
