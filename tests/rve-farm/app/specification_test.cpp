#include "rve-farm/app/specification.hpp"

#include "common/base/error.hpp"
#include "common/io/text_file.hpp"
#include "common/scene/rve_tables.hpp"
#include "tests/support/text.hpp"
#include "tests/support/temporary_file.hpp"

using namespace talik;
using namespace talik::farm;

namespace {

const std::string path = test_file("specification_test.toml");
const std::string sound = "[rve.packing]\nvoid_ratio = 0.2\n[test]\npath = \"biaxial\"\n";

std::string problem_of(const std::string& text, bool element = true) {
    write_file_atomically(path, text);
    std::string dump;
    try {
        if (element) read_element_specification(path, {}, dump);
        else read_pack_specification(path, {}, dump);
    } catch (const Error& e) {
        return e.what();
    }
    return "";
}

} // namespace

TEST_CASE("an element test is read in SI units, with the tables of a scene") {
    write_file_atomically(path, "title = \"t\"\n" + sound + "rate = \"6 %/min\"\npressure = \"50 kPa\"\n[rve.bond]\nnormal_strength = \"1 MPa\"\n");
    std::string dump;
    const ElementSpec spec = read_element_specification(path, {"test.strain=0.05"}, dump);
    CHECK(spec.test.path == "biaxial");
    CHECK(spec.test.rate == Approx(1e-3));
    CHECK(spec.test.pressure == 5e4);
    CHECK(spec.test.strain == 0.05);
    CHECK(spec.rve.parameters.bond->normal_strength == 1e6);
    write_file_atomically(path, dump); // the dump is a specification of the same content
    std::string again;
    read_element_specification(path, {}, again);
    CHECK(again == dump);
    write_file_atomically(path + ".h5", "");
    write_file_atomically(path, "[rve.packing]\nfile = \"" + path + ".h5\"\n[test]\npath = \"isochoric\"\n");
    read_element_specification(path, {}, dump);
    write_file_atomically(path, dump);
    CHECK_NOTHROW(read_element_specification(path, {}, again));
}

TEST_CASE("faults of specifications are named with line, key and mend") {
    CHECK(problem_of(sound) == "");
    CHECK_CONTAINS(problem_of("[test]\npath = \"biaxial\"\n"), ":1: rve: is missing");
    CHECK_CONTAINS(problem_of("[rve.packing]\nvoid_ratio = 0.2\n[test]\npath = \"triaxial\"\n"), ":4: test.path: \"triaxial\" is not one of its choices (did you mean \"biaxial\"?");
    CHECK_CONTAINS(problem_of(sound + "activate_bonds = true\n"), "test.activate_bonds: needs the table [rve.bond]");
    CHECK_CONTAINS(problem_of(sound + "rate = \"100 1/s\"\n"), "test.step: moves by more than 1 % in one macro step");
    CHECK(problem_of("[rve.packing]\nvoid_ratio = 0.2\n", false) == "");
    CHECK_CONTAINS(problem_of("[rve.packing]\nfile = \"" + path + "\"\n", false), "is given to a preparation");
    CHECK_CONTAINS(problem_of("[rve.packing]\nvoid_ratio = \"0.2 m\"\n", false), "is a length, not a number");
}

TEST_CASE("the specification that a scene hands to `pack` reads back to the same packing, and its fingerprint sees only that") {
    RveSpec rve;
    rve.packing.void_ratio = 0.2;
    const std::string fingerprint = scene::packing_fingerprint(rve);
    write_file_atomically(path, scene::packing_specification(rve));
    std::string dump;
    CHECK(scene::packing_fingerprint(read_pack_specification(path, {}, dump)) == fingerprint);
    rve.parameters.bond = BondParameters();
    rve.parameters.time_step = 2e-5;
    CHECK(scene::packing_fingerprint(rve) == fingerprint);
    rve.parameters.contact.friction = 0.4;
    CHECK(scene::packing_fingerprint(rve) != fingerprint);
}
