// Faults of a scene in what stages, packings by depth and thaw ask for.
#include "common/base/error.hpp"
#include "mpm-driver/app/scene_schema.hpp"
#include "tests/mpm-driver/app/scene_text.hpp"
#include "tests/support/text.hpp"

using namespace talik;
using namespace talik::driver;

namespace {

const std::string sound = R"toml(
[domain]
size = ["1 m", "2 m"]
cell = "0.1 m"
[[body]]
name = "ground"
box = [[0, 0], [1, 1]]
law = "rve"
material = "soil"
temperature = "-2 C"
[rve.packing]
void_ratio = 0.2
pressure = "1 kPa"
[rve.packing.k0]
levels = 4
[rve.contact]
friction = 0.5
[rve.bond]
rebond_on_freezing = true
[phase_change_strain]
expansion = 0.09
[heat]
[[heat.material]]
name = "soil"
porosity = 0.43
grain_heat_capacity = "900 J/(kg K)"
grain_conductivity = "2.92 W/(m K)"
[[stage]]
name = "rest"
duration = "1 s"
gravity = [0, -2]
[[stage]]
name = "load"
duration = "1 s"
gravity = [0, -10]
gravity_ramp = "0.5 s"
activates = ["bonds"]
activates_in = ["ground"]
)toml";

const tests::SceneText scene("coupling_scene_test.toml", sound);
std::string faults_of(const std::string& text) { return scene.faults_of(text); }
std::string broken(const std::string& from, const std::string& to) { return scene.broken(from, to); }

} // namespace

TEST_CASE("what is wrong with packings by depth, stages and thaw in a scene is said with its line, its key and the mend") {
    CHECK(faults_of(sound) == "");
    CHECK_CONTAINS(broken("gravity = [0, -2]", "gravity = [0, 2]"), ":31: stage.0.gravity: is not downward, but [rve.packing.k0] takes the stress of depth from it");
    CHECK_CONTAINS(broken("gravity = [0, -2]", "gravity = [0, -2]\ngravity_ramp = \"0.1 s\""), "stage.0.gravity_ramp: is given beside packings that are at the stress of full gravity already");
    CHECK_CONTAINS(broken("levels = 4", "levels = 4\nstress_min = \"2 kPa\""), "rve.packing.k0.stress_min: is given without the other end");
    CHECK_CONTAINS(broken("levels = 4", "stress_min = \"2 kPa\"\nstress_max = \"1 kPa\""), "rve.packing.k0.stress_max: is smaller than stress_min");
    CHECK_CONTAINS(broken("levels = 4", "stress_min = \"0.5 kPa\"\nstress_max = \"1 kPa\""), "rve.packing.pressure: 1000 Pa, where the K0 path begins, is above its lowest stress of 500 Pa");
    CHECK_CONTAINS(broken("gravity_ramp = \"0.5 s\"", "gravity_ramp = \"2 s\""), "stage.1.gravity_ramp: 2 s is longer than the stage");
    CHECK_CONTAINS(broken("activates_in = [\"ground\"]", "activates_in = [\"grund\"]"), "stage.1.activates_in: \"grund\" is no body of RVEs in this scene");
    CHECK_CONTAINS(broken("activates = [\"bonds\"]\n", ""), "stage.1.activates_in: is given for a stage that activates nothing");
    CHECK_CONTAINS(broken("rebond_on_freezing = true", "rebond_ice_saturation = 0"), "rve.bond.rebond_ice_saturation");
    CHECK_CONTAINS(broken("expansion = 0.09", "expansion = 9"), "phase_change_strain.expansion");
}

TEST_CASE("swelling without heat is refused") {
    std::string text = sound;
    const auto from = text.find("[heat]"), to = text.find("[[stage]]");
    text.erase(from, to - from);
    for (const char* key : {"material = \"soil\"\n", "temperature = \"-2 C\"\n"}) text.erase(text.find(key), std::string(key).size());
    CHECK_CONTAINS(faults_of(text), "phase_change_strain: is given in a scene without heat");
}
