#include "mpm-driver/app/scene_schema.hpp"

#include <filesystem>
#include <fstream>

#include "common/base/error.hpp"
#include "common/io/text_file.hpp"
#include "mpm-driver/app/scene_tables.hpp"
#include "tests/support/text.hpp"
#include "tests/support/temporary_file.hpp"

using namespace talik;
using namespace talik::driver;

namespace {

const std::string path = test_file("scene_test.toml");
const std::string cases = TALIK_SOURCE_DIR "/cases/biaxial/";

const std::string sound = R"(
[domain]
size = ["1 m", "2 m"]
cell = "0.1 m"
[[body]]
name = "block"
box = [["0.2 m", "0 m"], ["0.8 m", "1 m"]]
law = "elastic"
density = "2000 kg/m^3"
[elastic]
young = "10 MPa"
poisson = 0.3
[[wall]]
name = "plate"
side = "top"
position = "1 m"
velocity = "-1 mm/s"
[[stage]]
name = "push"
duration = "1 s"
moves = ["plate"]
)";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const auto at = text.find(from);
    REQUIRE(at != std::string::npos);
    return text.replace(at, from.size(), to);
}

std::string faults_of(const std::string& text, const std::vector<std::string>& overrides = {}) {
    write_file_atomically(path, text);
    std::string lines;
    for (const auto& fault : check_scene(path, overrides)) lines += replaced(fault.text() + "\n", test_file(""), "");
    return lines;
}

std::string error_of(const std::string& text, const std::vector<std::string>& overrides = {}) {
    write_file_atomically(path, text);
    try {
        read_scene(path, overrides);
    } catch (const Error& e) {
        return e.what();
    }
    return "";
}

} // namespace

TEST_CASE("every scene that is shipped is sound") {
    int scenes = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(TALIK_SOURCE_DIR "/cases")) {
        if (entry.path().extension() != ".toml") continue;
        const std::string text = read_text_file(entry.path());
        if (!contains(text, "[[stage]]")) continue; // a specification for rve-farm
        ++scenes;
        std::string lines;
        for (const auto& fault : check_scene(entry.path().string())) lines += fault.text() + "\n";
        CAPTURE(entry.path().string());
        CHECK(lines == "");
    }
    CHECK(scenes >= 6);
}

TEST_CASE("a scene is read in SI units") {
    const Scene s = read_scene(cases + "dense.toml");
    CHECK(s.confining_pressure == 1e5);
    CHECK(s.domain.origin == Vector(-0.24, 0.0));
    CHECK(s.domain.cell == 0.08);
    REQUIRE(s.bodies.size() == 1);
    REQUIRE(s.bodies[0].polygon.size() == 4); // a box is its four corners, counter-clockwise
    CHECK(s.bodies[0].polygon[2] == Vector(0.48, 0.96));
    REQUIRE(s.rve);
    CHECK(s.rve->packing.void_ratio == 0.161);
    CHECK(s.rve->packing.radius_min == 2.5e-3);
    CHECK(s.rve->parameters.time_step == 2.4e-5);
    CHECK(s.rve->parameters.contact.friction == 0.5);
    CHECK_FALSE(s.rve->parameters.bond);
    CHECK_FALSE(s.elastic);
    REQUIRE(s.walls.size() == 2);
    CHECK(s.walls[1].velocity == -0.1);
    REQUIRE(s.stages.size() == 1);
    CHECK(s.stages[0].duration == 1.49);
    CHECK(s.stages[0].moves == std::vector<std::string>{"plate"});
    CHECK_FALSE(s.step.fixed);
    CHECK(read_scene(cases + "paper-dense.toml").step.fixed == 1e-3);
}

TEST_CASE("rules across tables name the key, and only where they are broken") {
    CHECK(faults_of(sound) == "");
    const auto broken = [](const std::string& from, const std::string& to) { return faults_of(replaced(sound, from, to)); };
    CHECK(broken("cell = \"0.1 m\"", "cell = \"0.3 m\"") ==
          "scene_test.toml:3: domain.size: its width of 1 m is no whole number of cells of 0.3 m (take 1.2 m)\n"
          "scene_test.toml:3: domain.size: its height of 2 m is no whole number of cells of 0.3 m (take 2.1 m)\n");
    CHECK_CONTAINS(broken("[\"0.8 m\", \"1 m\"]", "[\"1.8 m\", \"1 m\"]"), "scene_test.toml:7: body.0.box: its corner (1.8, 0) m lies outside the domain");
    CHECK_CONTAINS(broken("[\"0.8 m\", \"1 m\"]", "[\"0.2 m\", \"1 m\"]"), "body.0.box: has no area");
    CHECK_CONTAINS(broken("box = [[\"0.2 m\", \"0 m\"], [\"0.8 m\", \"1 m\"]]", "polygon = [[0, 0], [1, 1], [1, 0], [0, 1.5]]"), "body.0.polygon: crosses itself");
    CHECK_CONTAINS(broken("box = [[\"0.2 m\", \"0 m\"], [\"0.8 m\", \"1 m\"]]\n", ""), "body.0.polygon: is missing (give the body a box or a polygon)");
    CHECK_CONTAINS(broken("law = \"elastic\"", "law = \"elastic\"\npolygon = [[0, 0], [1, 0], [1, 1]]"), "is given beside a box");
    CHECK_CONTAINS(broken("law = \"elastic\"", "law = \"elastic\"\npoints_per_cell = 5"), "body.0.points_per_cell: 5 is no square");
    CHECK_CONTAINS(broken("density = \"2000 kg/m^3\"\n", ""), "body.0.density: is missing");
    CHECK_CONTAINS(broken("law = \"elastic\"", "law = \"rve\""), "body.0.law: \"rve\" needs the table [rve]");
    CHECK_CONTAINS(broken("law = \"elastic\"", "law = \"rve\""), "elastic: is given, but no body has this law");
    CHECK_CONTAINS(broken("moves = [\"plate\"]", "moves = [\"plat\"]"), "scene_test.toml:21: stage.0.moves: \"plat\" is no wall of this scene (its walls are: plate)");
    CHECK_CONTAINS(broken("velocity = \"-1 mm/s\"\n", ""), "stage.0.moves: the wall \"plate\" has no velocity");
    CHECK_CONTAINS(broken("moves = [\"plate\"]", "activates = [\"bonds\"]"), "stage.0.activates: \"bonds\" needs the table [rve.bond]");
    CHECK_CONTAINS(broken("moves = [\"plate\"]", "activates = [\"bond\"]"), "did you mean \"bonds\"?");
    CHECK_CONTAINS(broken("position = \"1 m\"", "position = \"3 m\""), "wall.0.position: 3 m lies outside the domain");
    CHECK_CONTAINS(broken("position = \"1 m\"", "position = \"1 m\"\nkind = \"fixed\"\nfriction = 0.3"), "wall.0.friction: is given for a wall that sticks");
    CHECK_CONTAINS(broken("poisson = 0.3", "poisson = 0.5"), "elastic.poisson: 0.5 is out of range");
    CHECK_CONTAINS(broken("young = \"10 MPa\"", "young = \"-10 MPa\""), "elastic.young: -1e+07 Pa is out of range");
    CHECK_CONTAINS(broken("duration = \"1 s\"\n", ""), "stage.0.duration: is missing");
    CHECK_CONTAINS(broken("cell = \"0.1 m\"", "cell = \"1e-6 m\""), "scene_test.toml:4: domain.cell: 1e-06 m makes 2e+12 cells of this domain");
    CHECK_CONTAINS(broken("cell = \"0.1 m\"", "cell = 1e-300"), "domain.cell: 1e-300 m makes inf cells");
    CHECK_CONTAINS(broken("position = \"1 m\"", "position = \"0.9 m\""), "wall.0.position: the top wall at 0.9 m cuts through body \"block\"");
    CHECK_CONTAINS(broken("[[stage]]", "[[wall]]\nname = \"base\"\nside = \"bottom\"\nposition = \"1.5 m\"\n[[stage]]"),
                   "wall.0.position: the top wall at 1 m leaves no room to the bottom wall \"base\" at 1.5 m");
    CHECK_CONTAINS(broken("name = \"plate\"", "name = \"plate,1\""), "wall.0.name: \"plate,1\" is no name for a wall");
    CHECK_CONTAINS(broken("[[wall]]", "[[body]]\nname = \"block\"\nbox = [[0, 0], [0.2, 1]]\nlaw = \"elastic\"\ndensity = 2000\n[[wall]]"), "body.1.name: \"block\" is also the name of body.0");
    CHECK_CONTAINS(broken("law = \"elastic\"", "law = \"elastic\"\nvelocity = [1e5, 0]"), "body.0.velocity: 100000 m/s is no speed of ground");
    CHECK_CONTAINS(broken("2000 kg/m^3", "0.5 kg/m^3"), "body.0.density");
    CHECK_CONTAINS(broken("moves = [\"plate\"]", "moves = [\"plate\", \"plate\"]"), "stage.0.moves: names the wall \"plate\" twice");
    CHECK_CONTAINS(faults_of(replaced(sound, "duration = \"1 s\"", "duration = \"1 s\"\ngrid_damping = 1e5"), {"step.fixed=1e-4"}), "stage.0.grid_damping: 100000 1/s times the step of 0.0001 s is 10");
    CHECK(faults_of(replaced(sound, "duration = \"1 s\"", "duration = \"1 s\"\ngrid_damping = 9e3"), {"step.fixed=1e-4"}) == ""); // alpha dt = 0.9
    CHECK_CONTAINS(faults_of(""), "body: is missing (add at least one [[body]]");
    CHECK_CONTAINS(faults_of("[domain\n"), "scene_test.toml:1: ");
}

TEST_CASE("a body without a point and two bodies on the same ground are named with their line, neighbours are not") {
    const auto with = [](const std::string& body) { return faults_of(replaced(sound, "[[wall]]", "[[body]]\nname = \"other\"\nlaw = \"elastic\"\ndensity = 2000\n" + body + "\n[[wall]]")); };
    CHECK_CONTAINS(with("box = [[0, 0], [0.02, 1]]"), "scene_test.toml:17: body.1.box: holds no point: points stand 0.05 m apart");
    CHECK_CONTAINS(with("box = [[0.79, 0], [1, 1]]"), "scene_test.toml:17: body.1.box: overlaps body.0 \"block\": the same ground would be there twice");
    CHECK_CONTAINS(with("polygon = [[0.5, 0.5], [1, 0.5], [1, 1]]"), "body.1.polygon: overlaps body.0 \"block\"");
    CHECK(with("box = [[0.8, 0], [1, 1]]") == "");
    CHECK(with("polygon = [[0.8, 0], [1, 0], [1, 1], [0.8, 1]]") == "");
    CHECK(with("polygon = [[0.8, 0], [1, 0], [0.8, 1]]") == "");
}

TEST_CASE("a body whose points stand for less ground than its outline is warned of, from one percent on") {
    const auto warnings = [](const std::string& corner) {
        write_file_atomically(path, replaced(sound, "[\"0.8 m\", \"1 m\"]", corner));
        return seeding_warnings(read_scene(path));
    };
    CHECK(warnings("[0.8, 1]").empty());
    CHECK(warnings("[0.8, 0.999]").empty());
    REQUIRE(warnings("[0.47, 1]").size() == 1);
    CHECK_CONTAINS(warnings("[0.47, 1]")[0], "body \"block\": its outline encloses 0.27 m2, its points stand for 0.25 m2 (-7.4 %)");
}

TEST_CASE("a missing packing is a fault of the scene, named with its line") {
    const std::string scene = replaced(replaced(sound, "law = \"elastic\"", "law = \"rve\""), "[elastic]\nyoung = \"10 MPa\"\npoisson = 0.3\n", "[rve.packing]\nfile = \"absent.h5\"\n");
    CHECK_CONTAINS(faults_of(scene), "scene_test.toml:11: rve.packing.file: ");
    CHECK_CONTAINS(faults_of(scene), "absent.h5\" does not exist (prepare it (rve-farm pack)");
    CHECK_CONTAINS(faults_of(scene, {"rve.packing.void_ratio=0.2"}), "is given beside another source of the packing");
    const auto prepared = [&](const std::string& rest) { return faults_of(replaced(scene, "file = \"absent.h5\"", "void_ratio = 0.2\n" + rest)); };
    CHECK(prepared("") == "");
    CHECK_CONTAINS(prepared("discs = 100001"), "rve.packing.discs");
    CHECK_CONTAINS(prepared("radius_min = \"1e-5 m\""), "rve.packing.radius_min: is less than a hundredth of radius_max");
    CHECK_CONTAINS(prepared("[rve.contact]\nnormal_stiffness = 1e4"), "the pressure presses discs into each other by about 1 of their size");
    CHECK_CONTAINS(prepared("[rve.contact]\nnormal_stiffness = 1e15"), "beyond the precision of positions");
    CHECK_CONTAINS(prepared("[rve.contact]\ntangential_stiffness = 1e9"), "rve.contact.tangential_stiffness: is more than 100 times");
    CHECK_CONTAINS(prepared("[rve]\nskin = 1"), "rve.skin: 1 m is more than ten times the largest radius");
    CHECK_CONTAINS(faults_of(replaced(scene, "file = \"absent.h5\"", "discs = 100")), "rve.packing.void_ratio: is missing");
    CHECK_CONTAINS(faults_of(replaced(scene, "file = \"absent.h5\"", "void_ratio = 0.2\nradius_max = \"1 mm\"")), "radius_max: is smaller than radius_min");
}

TEST_CASE("the error of a scene is its first fault and the number of the others") {
    const std::string two = replaced(replaced(sound, "cell =", "cel ="), "poisson =", "poison =");
    CHECK_CONTAINS(error_of(two), "scene_test.toml:4: domain.cel: is no key of [domain] (did you mean \"cell\"?; and 3 more: `mpm-driver check` lists them)");
    CHECK(error_of(sound) == "");
}

TEST_CASE("the hash of a scene sees its content, not its comments, order, units or file") {
    write_file_atomically(path, sound);
    const Scene a = read_scene(path);
    write_file_atomically(path + "2", replaced(replaced("# a comment" + sound, "\"10 MPa\"", "1e7"), "name = \"block\"\n", "") + "[step]\nsafety = 0.5\n");
    write_file_atomically(path + "2", replaced(read_text_file(path + "2"), "law = \"elastic\"\n", "law = \"elastic\"\nname = \"block\"\n"));
    const Scene b = read_scene(path + "2");
    CHECK(a.hash == b.hash);
    CHECK(a.hash.size() == 16);
    CHECK(read_scene(path, {"elastic.poisson=0.2"}).hash != a.hash);
    write_file_atomically(path + "3", scene_dump(a)); // the dump is a scene of the same content
    CHECK(read_scene(path + "3").hash == a.hash);
    const Scene shipped = read_scene(cases + "dense.toml");
    write_file_atomically(path + "3", scene_dump(shipped));
    CHECK(read_scene(path + "3").hash == shipped.hash);
}

TEST_CASE("docs/scene.md is what the table of keys says", "[docs]") {
    // Mend with: mpm-driver --help-scene-markdown > docs/scene.md
    const bool page_is_the_table = read_text_file(TALIK_SOURCE_DIR "/docs/scene.md") == scene_markdown();
    CHECK(page_is_the_table);
}
