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
law = "none"
material = "soil"
temperature = "-2 C"
[heat]
[[heat.material]]
name = "soil"
porosity = 0.43
grain_heat_capacity = "900 J/(kg K)"
grain_conductivity = "2.92 W/(m K)"
residual_temperature = "-0.5 C"
[[heat.boundary]]
name = "surface"
side = "top"
value = 5
[[heat.heater]]
name = "heater"
line = [["0.5 m", "0.2 m"], ["0.5 m", "0.6 m"]]
temperature = "20 C"
[[stage]]
name = "thaw"
duration = "20 d"
)toml";

const tests::SceneText heat_text("heat_scene_test.toml", sound);
std::string faults_of(const std::string& text) { return heat_text.faults_of(text); }
std::string broken(const std::string& from, const std::string& to) { return heat_text.broken(from, to); }

} // namespace

TEST_CASE("what is wrong with heat in a scene is said with its line, its key and the mend") {
    CHECK(faults_of(sound) == "");
    CHECK_CONTAINS(broken("porosity = 0.43", "porosity = 1.2"), "heat_scene_test.toml:14: heat.material.0.porosity: 1.2 is out of range");
    CHECK_CONTAINS(broken("porosity = 0.43", "porosity = 0"), "heat.material.0.porosity: 0 is out of range");
    CHECK_CONTAINS(broken("\"-0.5 C\"", "\"0.5 C\""), "heat_scene_test.toml:17: heat.material.0.residual_temperature: T_res = 0.5 C is above T0 = 0 C");
    CHECK_CONTAINS(broken("grain_conductivity = \"2.92 W/(m K)\"\n", ""), "heat.material.0.grain_conductivity: is missing: a material needs its conductivity (add grain_conductivity");
    CHECK_CONTAINS(broken("grain_heat_capacity = \"900 J/(kg K)\"\n", ""), "heat.material.0.grain_heat_capacity: is missing");
    CHECK_CONTAINS(broken("[\"0.5 m\", \"0.2 m\"], [\"0.5 m\", \"0.6 m\"]", "[\"0.5 m\", \"1.2 m\"], [\"0.5 m\", \"1.6 m\"]"), "heat_scene_test.toml:24: heat.heater.0.line: lies outside the ground: no body is there (put the heater where a body is)");
    CHECK_CONTAINS(broken("material = \"soil\"", "material = \"sand\""), "body.0.material: \"sand\" is no [[heat.material]] of this scene (give one of: soil)");
    CHECK_CONTAINS(broken("temperature = \"-2 C\"\n", ""), "body.0.temperature: is missing");
    CHECK_CONTAINS(broken("temperature = \"-2 C\"", "temperature = \"-2 kPa\""), "\"-2 kPa\" is a pressure, not a temperature");
    CHECK_CONTAINS(broken("value = 5\n", ""), "heat.boundary.0.value: is missing");
    CHECK_CONTAINS(broken("value = 5\n", "value = 5\namplitude = 3\n"), "heat.boundary.0.period: is missing beside an amplitude");
    CHECK_CONTAINS(broken("name = \"heater\"", "name = \"surface\""), "heat.heater.0.name: \"surface\" is the name of two causes of heat");
    CHECK_CONTAINS(broken("[heat]", "[heat]\nstability = 1.5"), "heat.stability: 1.5 is out of range");
    CHECK_CONTAINS(broken("[heat]\n", "[heat]\nformulation = \"capacity\"\n[[heat.material]]\nname = \"sharp\"\nporosity = 1\n"), "heat.formulation: \"capacity\" cannot freeze material \"sharp\", whose ramp has no width");
    CHECK_CONTAINS(broken("residual_temperature = \"-0.5 C\"", "curve = \"fine\"\nwater_content = 0.05"), "heat.material.0.residual_water_content: 0.058 is more than the water content 0.05 at T0: the freezing curve would not be monotonic");
    CHECK_CONTAINS(broken("residual_temperature = \"-0.5 C\"", "anisotropy = [1, 1, 2]"), "heat.material.0.anisotropy: [1, 1, 2] is no conductivity");
    CHECK_CONTAINS(broken("residual_temperature = \"-0.5 C\"", "curve = \"table\"\ncurve_file = \"absent.csv\""), "absent.csv\" does not exist (mend the path: it is meant relative to the scene)");
    write_file_atomically(test_file("wavy.csv"), "temperature_C,unfrozen_saturation\n-4,0.4\n-1,0.1\n0,1\n");
    CHECK_CONTAINS(broken("residual_temperature = \"-0.5 C\"", "curve = \"table\"\ncurve_file = \"" + test_file("wavy.csv") + "\""), "wavy.csv:3: heat: the freezing curve is not monotonic");
    // C h^2 / (2 k) of the frozen soil: (0.57 * 2650 * 900 + 430 * 2100) * 0.01 / (2 * 2.92^0.57 * 2.24^0.43) = 4342 s
    CHECK_CONTAINS(broken("[[stage]]", "[step]\nfixed = \"2 h\"\n[[stage]]"), "heat_scene_test.toml:27: step.fixed: 7200 s is beyond the largest stable step of heat in material \"soil\", 4342 s");
    CHECK(broken("[[stage]]", "[step]\nfixed = \"1 h\"\n[[stage]]") == "");
    CHECK_CONTAINS(broken("law = \"none\"", "law = \"elastic\""), "body.0.law: \"elastic\" needs the table [elastic]");
    CHECK_CONTAINS(broken("[[stage]]", "[[body]]\nname = \"other\"\nbox = [[0, 1], [1, 2]]\nlaw = \"elastic\"\nmaterial = \"soil\"\ntemperature = 0\n[elastic]\nyoung = 1e6\npoisson = 0.2\n[[stage]]"),
                   "body.0.law: \"none\" is given beside bodies with a law");
}

TEST_CASE("the hash of a scene sees what the files hold that it names") {
    const std::string table = test_file("surface.csv"), path = test_file("heat_hash_test.toml"), value = "value = 5";
    write_file_atomically(path, std::string(sound).replace(sound.find(value), value.size(), "file = \"surface.csv\""));
    const auto hash_with = [&](const std::string& last) {
        write_file_atomically(table, "time_s,value\n0,5\n" + last);
        return read_scene(path).hash;
    };
    const std::string first = hash_with("86400,7\n");
    CHECK(hash_with("86400,8\n") != first);
    CHECK(hash_with("86400,7\n") == first);
}

TEST_CASE("bodies of a mixture have its density where the scene gives none") {
    REQUIRE(faults_of(sound) == ""); // which writes the file
    CHECK(*read_scene(heat_text.path).bodies[0].density == Approx(0.57 * 2650 + 430));
    CHECK(*read_scene(heat_text.path, {"body.0.density=1800"}).bodies[0].density == 1800.0);
}
