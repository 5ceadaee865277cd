#include "common/packing/packing_file.hpp"

#include <filesystem>

#include "common/base/error.hpp"
#include "common/io/hdf5_file.hpp"
#include "common/io/text_file.hpp"
#include "common/packing/packing_csv.hpp"
#include "tests/support/text.hpp"
#include "tests/support/temporary_file.hpp"

using namespace talik;

namespace {

const std::string path = test_file("packing_test.h5");

std::string problem_of_reading(const std::string& file) {
    try {
        read_packings(file);
    } catch (const Error& e) {
        return e.what();
    }
    return "";
}

} // namespace

TEST_CASE("a packing file returns every field of every packing, bit by bit, in order") {
    const std::string yade = TALIK_SOURCE_DIR "/tests/reference/yade/packing_";
    Packing first = read_packing_csv(yade + "medium_particles.csv", yade + "medium_contacts.csv");
    first.seed = 42;
    first.stiffness = 8e6;
    first.stable_step = 4e-5;
    first.vertical_stress = 2e4, first.lateral_stress = 9e3;
    first.contacts[3].bonded = true;
    Packing second = read_packing_csv(yade + "loose_particles.csv"); // no contacts
    second.velocity_x.clear(), second.velocity_y.clear(), second.spin.clear();
    write_packings(path, "test", {first, second}, "discs = 400");
    const auto read = read_packings(path);
    REQUIRE(read.size() == 2);
    CHECK(read[0].cell == first.cell);
    CHECK(read[0].x == first.x);
    CHECK(read[0].y == first.y);
    CHECK(read[0].radius == first.radius);
    CHECK(read[0].velocity_x == first.velocity_x);
    CHECK(read[0].velocity_y == first.velocity_y);
    CHECK(read[0].spin == first.spin);
    CHECK(read[0].thickness == first.thickness);
    CHECK(read[0].grain_density == first.grain_density);
    CHECK(read[0].pressure == first.pressure);
    CHECK(read[0].seed == 42);
    CHECK(read[0].stiffness == 8e6);
    CHECK(read[0].stable_step == 4e-5);
    CHECK(read[0].vertical_stress == 2e4);
    CHECK(read[0].lateral_stress == 9e3);
    REQUIRE(read[0].contacts.size() == first.contacts.size());
    for (std::size_t c = 0; c < first.contacts.size(); ++c) {
        CHECK(read[0].contacts[c].first == first.contacts[c].first);
        CHECK(read[0].contacts[c].second == first.contacts[c].second);
        CHECK(read[0].contacts[c].image == first.contacts[c].image);
        CHECK(read[0].contacts[c].tangential_force == first.contacts[c].tangential_force);
        CHECK(read[0].contacts[c].bonded == first.contacts[c].bonded);
    }
    CHECK(read[1].velocity_x.empty());
    CHECK(read[1].contacts.empty());
    CHECK(Hdf5File::open(path).read_text("/specification") == "discs = 400");
}

TEST_CASE("a packing file that is missing, of another kind or inconsistent is named with the mend") {
    CHECK_CONTAINS(problem_of_reading("absent.h5"), "absent.h5: does not exist");
    Hdf5File::create(path, "test", "talik-fields 1").close();
    CHECK_CONTAINS(problem_of_reading(path), "has the format \"talik-fields 1\"");
    std::filesystem::remove(path);
    Packing p;
    p.x = p.y = p.radius = {0.5};
    p.contacts.push_back({0, 3, {0, 0}, 0.0, false});
    write_packings(path, "test", {p});
    CHECK_CONTAINS(problem_of_reading(path), "a contact names a disc that is not there");
}

TEST_CASE("packings replace a packing file, damaged or not, and nothing else") {
    const auto problem = [](const std::string& file) {
        try {
            check_place_of_packings(file);
        } catch (const Error& e) {
            return std::string(e.what());
        }
        return std::string();
    };
    Packing p = read_packing_csv(TALIK_SOURCE_DIR "/tests/reference/yade/packing_loose_particles.csv");
    const std::string file = test_file("replaced.h5");
    CHECK(problem(file) == "");
    write_packings(file, "test", {p});
    CHECK(problem(file) == "");
    std::filesystem::resize_file(file, 1000);
    CHECK(problem(file) == "");
    std::filesystem::resize_file(file, 0);
    CHECK(problem(file) == "");
    write_file_atomically(file, "a thesis");
    CHECK_CONTAINS(problem(file), "is there already, and is no file of the format");
    Hdf5File::create(file, "test", "talik-fields 1").close();
    CHECK_CONTAINS(problem(file), "is there already, and has the format \"talik-fields 1\"");
    CHECK_CONTAINS(problem("/dev/null"), "is no regular file");
    CHECK_CONTAINS(problem(std::filesystem::path(file).parent_path().string()), "is a folder");
}
