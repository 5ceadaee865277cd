#include "common/scene/schema.hpp"

#include <algorithm>
#include <functional>

#include "common/base/error.hpp"
#include "tests/support/text.hpp"

using namespace talik;
using namespace talik::scene;

namespace {

struct Bond {
    double strength = 1e7;
};

struct Wall {
    std::string name, side;
    double friction = 0.0;
};

struct Small {
    std::string title;
    double pressure = 1e5;
    std::optional<double> step;
    std::uint64_t seed = 1;
    int discs = 400;
    bool quiet = false;
    Eigen::Vector2d size = Eigen::Vector2d::Zero();
    std::vector<Eigen::Vector2d> outline;
    std::vector<std::string> moves;
    std::optional<Bond> bond;
    std::vector<Wall> walls;
};

Table<Small> small() {
    Table<Bond> bond("Bonds of ice.");
    bond.quantity("strength", &Bond::strength, Dimension::pressure, positive(), "c_n");
    Table<Wall> wall("Rigid walls.");
    wall.text("name", &Wall::name, "its name", required)
        .choice("side", &Wall::side, {"left", "right"}, "which side it bounds", required)
        .number("friction", &Wall::friction, between(0, 2), "Coulomb");
    Table<Small> table("A small scene.");
    table.text("title", &Small::title, "for plots")
        .quantity("pressure", &Small::pressure, Dimension::pressure, not_negative(), "all around")
        .optional_quantity("step", &Small::step, Dimension::time, positive(), "of time", "auto")
        .whole("seed", &Small::seed, any(), "of every draw")
        .whole("discs", &Small::discs, at_least(1), "in an RVE")
        .flag("quiet", &Small::quiet, "no words")
        .components("size", &Small::size, Dimension::length, positive(), "width, height", required)
        .points("outline", &Small::outline, Dimension::length, 0, "a polygon")
        .texts("moves", &Small::moves, {}, "walls that move")
        .optional_table<Bond>("bond", &Small::bond, bond)
        .tables("wall", &Small::walls, wall)
        .check([](const Small& s, const Place& at) {
            if (s.discs > 1000 && !s.bond) at.fault("discs", "too many without bonds", "add [bond]");
        });
    return table;
}

Small read_small(const std::string& text, Faults& faults, const std::vector<std::string>& overrides = {}) {
    Value document = parse_document(text, "s.toml");
    for (const auto& o : overrides) apply_override(document, o);
    Small out;
    small().read(document, "", out, faults);
    return out;
}

// All faults of a text, a line each.
std::string faults_of(const std::string& text, const std::vector<std::string>& overrides = {}) {
    Faults faults;
    read_small(text, faults, overrides);
    std::string lines;
    for (const auto& f : faults) lines += f.text() + "\n";
    return lines;
}

std::string error_of(const std::function<void()>& action) {
    try {
        action();
    } catch (const Error& e) {
        return e.what();
    }
    return "";
}

const std::string sound = "size = [\"1 m\", 2]\n";

} // namespace

TEST_CASE("a sound document fills the struct in SI units, and what it leaves out keeps its default") {
    Faults faults;
    const Small s = read_small("pressure = \"20 kPa\"\nstep = \"1 ms\"\nseed = 7\nquiet = true\nsize = [\"10 cm\", 2]\n"
                               "outline = [[0, 0], [\"1 m\", 0], [0, \"50 cm\"]]\nmoves = [\"plate\"]\n[bond]\n[[wall]]\nname = \"plate\"\nside = \"left\"\n", faults);
    CHECK(faults.empty());
    CHECK(s.pressure == 2e4);
    CHECK(s.step == 1e-3);
    CHECK(s.seed == 7);
    CHECK(s.discs == 400);
    CHECK(s.quiet);
    CHECK(s.size == Eigen::Vector2d(0.1, 2.0));
    REQUIRE(s.outline.size() == 3);
    CHECK(s.outline[2] == Eigen::Vector2d(0.0, 0.5));
    CHECK(s.moves == std::vector<std::string>{"plate"});
    REQUIRE(s.bond);
    CHECK(s.bond->strength == 1e7);
    REQUIRE(s.walls.size() == 1);
    CHECK(s.walls[0].side == "left");
}

TEST_CASE("a table that is absent leaves its effect off, and the word for none leaves a value empty") {
    Faults faults;
    const Small s = read_small(sound + "step = \"auto\"\n", faults);
    CHECK(faults.empty());
    CHECK_FALSE(s.bond);
    CHECK_FALSE(s.step);
}

TEST_CASE("each kind of fault is named with file, line, key and mend") {
    CHECK(faults_of(sound + "presure = 3\n") == "s.toml:2: presure: is no key of this file (did you mean \"pressure\"?)\n");
    CHECK_CONTAINS(faults_of(sound + "volcano = 3\n"), "s.toml:2: volcano: is no key of this file (known here: title, pressure,");
    CHECK_CONTAINS(faults_of(sound + "[[wall]]\nname = \"a\"\nside = \"left\"\nfrictoin = 1\n"), "s.toml:5: wall.0.frictoin: is no key of [wall.0] (did you mean \"friction\"?)");
    CHECK_CONTAINS(faults_of(sound + "pressure = true\n"), "s.toml:2: pressure: is true or false (give a pressure such as \"1.5 Pa\")");
    CHECK_CONTAINS(faults_of(sound + "pressure = \"3 mm\"\n"), "s.toml:2: pressure: \"3 mm\" is a length, not a pressure");
    CHECK_CONTAINS(faults_of(sound + "pressure = \"3 bananas\"\n"), "unknown unit \"bananas\"");
    CHECK_CONTAINS(faults_of(sound + "pressure = \"3 b\\nc\"\n"), "s.toml:2: pressure: \"3 b\\nc\" has an unknown unit \"b\\nc\" (");
    CHECK_CONTAINS(faults_of(sound + "pressure = \"-3 kPa\"\n"), "s.toml:2: pressure: -3000 Pa is out of range (give a value >= 0 Pa)");
    CHECK_CONTAINS(faults_of(sound + "pressure = inf\n"), "out of range");
    CHECK_CONTAINS(faults_of(sound + "discs = 2.5\n"), "s.toml:2: discs: is a number (give a whole number)");
    CHECK_CONTAINS(faults_of(sound + "discs = 0\n"), "discs: 0 is out of range");
    CHECK_CONTAINS(faults_of(sound + "discs = 99999999999\n"), "discs: 99999999999 is out of range");
    CHECK_CONTAINS(faults_of(sound + "seed = -1\n"), "seed: -1 is out of range");
    CHECK_CONTAINS(faults_of(sound + "quiet = 1\n"), "quiet: is a whole number (give true or false)");
    CHECK_CONTAINS(faults_of(sound + "title = 1\n"), "title: is a whole number (give a text in quotes)");
    CHECK_CONTAINS(faults_of("size = [1]\n"), "s.toml:1: size: has 1 values");
    CHECK_CONTAINS(faults_of("size = [1, -1]\n"), "s.toml:1: size.1: -1 m is out of range");
    CHECK_CONTAINS(faults_of(sound + "outline = [[0, 0], [1, 1]]\n"), "outline: has 2 points");
    CHECK_CONTAINS(faults_of(sound + "outline = [[0, 0], [1, 1], [1]]\n"), "outline.2: has 1 values");
    CHECK_CONTAINS(faults_of(sound + "moves = \"plate\"\n"), "moves: is a text (give a list of texts");
    CHECK_CONTAINS(faults_of(sound + "[[wall]]\nname = \"a\"\nside = \"lefd\"\n"), "s.toml:4: wall.0.side: \"lefd\" is not one of its choices (did you mean \"left\"?");
    CHECK_CONTAINS(faults_of(sound + "[[wall]]\nside = \"left\"\n"), "s.toml:2: wall.0.name: is missing");
    CHECK_CONTAINS(faults_of(sound + "[wall]\nside = \"left\"\n"), "wall: is a table (give it as [[wall]]");
    CHECK_CONTAINS(faults_of(sound + "bond = 3\n"), "s.toml:2: bond: is a whole number (give a table)");
    CHECK_CONTAINS(faults_of(""), "s.toml:1: size: is missing");
    CHECK_CONTAINS(faults_of(sound + "discs = 2000\n"), "s.toml:2: discs: too many without bonds (add [bond])");
}

TEST_CASE("one pass names every fault of a file, and rules across keys wait until the keys are sound") {
    const std::string lines = faults_of("pressure = \"1 m\"\ndiscs = 2000\nquiet = 3\n[bnd]\n");
    CHECK(std::count(lines.begin(), lines.end(), '\n') == 4); // unit, kind, unknown table, missing size
    CHECK_FALSE(contains(lines, "too many"));
}

TEST_CASE("a fault of syntax is one line with its position") {
    const std::string error = error_of([] { parse_document("a = 1\nb = = 2\n", "s.toml"); });
    CHECK_CONTAINS(error, "s.toml:2: ");
    CHECK_FALSE(contains(error, "\n"));
    CHECK_CONTAINS(error_of([] { read_document("absent.toml"); }), "absent.toml");
}

TEST_CASE("several faults become one error that counts the others") {
    Faults faults;
    read_small("pressure = \"1 m\"\nquiet = 3\n" + sound, faults);
    CHECK_CONTAINS(error_of([&] { throw_if_any(faults, "`check` lists them"); }), "s.toml:1: pressure: ");
    CHECK_CONTAINS(error_of([&] { throw_if_any(faults, "`check` lists them"); }), "; and 1 more: `check` lists them)");
    CHECK_NOTHROW(throw_if_any({}, ""));
}

TEST_CASE("overrides reach into tables and lists, make absent tables, and are named as --set when they are wrong") {
    const std::string walls = sound + "[[wall]]\nname = \"a\"\nside = \"left\"\n";
    Faults faults;
    const Small s = read_small(walls, faults, {"wall.0.friction=0.3", "bond.strength=5 MPa", "pressure=\"7 kPa\"", "title=plain words", "size=[3, \"4 m\"]"});
    CHECK(faults.empty());
    CHECK(s.walls[0].friction == 0.3);
    CHECK(s.bond->strength == 5e6);
    CHECK(s.pressure == 7e3);
    CHECK(s.title == "plain words");
    CHECK(s.size == Eigen::Vector2d(3.0, 4.0));
    CHECK_CONTAINS(faults_of(walls, {"wall.0.friction=3"}), "--set: wall.0.friction: 3 is out of range");
    CHECK_CONTAINS(faults_of(walls, {"bnod.strength=3"}), "--set: bnod: is no key of this file (did you mean \"bond\"?)");
    CHECK_CONTAINS(error_of([&] { faults_of(walls, {"wall.1.friction=3"}); }), "--set: wall.1.friction: there is no place \"1\" in a list of 1");
    CHECK_CONTAINS(error_of([&] { faults_of(walls, {"pressure"}); }), "there is no \"=\"");
    CHECK_CONTAINS(error_of([&] { faults_of(walls, {"title=\xff"}); }), "--set: title: is no text in UTF-8");
    CHECK(faults_of(walls, {"title=B\xc3\xb6schung\nof 1\t%"}) == "");
}

TEST_CASE("the dump is itself a document of the same content, and does not see comments, order or units") {
    const auto dump_of = [](const std::string& text) {
        Faults faults;
        const Small s = read_small(text, faults);
        REQUIRE(faults.empty());
        return small().dump(s);
    };
    const std::string a = dump_of("title = \"quoted \\\"words\\\"\"\nsize = [\"1 m\", \"2.5 mm\"]\npressure = \"0.1 kPa\"\n[bond]\nstrength = \"10 MPa\"\n[[wall]]\nname = \"w\"\nside = \"left\"\n");
    const std::string b = dump_of("# comment\npressure = 100.0\ntitle = \"quoted \\\"words\\\"\"\nsize = [1, 0.0025]\n[[wall]]\nside = \"left\"\nname = \"w\"\n[bond]\nstrength = 1e7\n");
    CHECK(a == b);
    CHECK(dump_of(a) == a);
    CHECK(fingerprint(a) == fingerprint(b));
    CHECK(fingerprint(a) != fingerprint(dump_of(sound)));
    CHECK(fingerprint("a") == "af63dc4c8601ec8c"); // published test value of the 64-bit FNV-1a hash
}

TEST_CASE("help and documentation show every key with its units, default, range and meaning") {
    std::vector<Section> sections;
    small().describe("", sections);
    for (const std::string& text : {help_text(sections), markdown("Scene", "How to write one.", sections)}) {
        for (const std::string word : {"pressure", "Pa, kPa, MPa, GPa", "100000 Pa", ">= 0 Pa", "all around", "\"auto\"", "[bond]", "Present means on",
                                       "[[wall]]", "\"left\" or \"right\"", "in [0, 2]", "required", "400"})
            CHECK_CONTAINS(text, word);
    }
}
