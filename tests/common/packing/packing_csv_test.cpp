#include <fstream>

#include "common/base/error.hpp"
#include "common/packing/packing_csv.hpp"
#include "tests/support/text.hpp"
#include "tests/support/temporary_file.hpp"

using namespace talik;

namespace {

const std::string yade = TALIK_SOURCE_DIR "/tests/reference/yade/";

// Eq. (49), tension positive: sigma = -1/(A t) sum f x b, with the linear normal spring k_n (Eq. 5a).
Matrix stress_of(const Packing& p, double normal_stiffness) {
    Matrix sum = Matrix::Zero();
    for (const auto& c : p.contacts) {
        const auto a = static_cast<std::size_t>(c.first), b = static_cast<std::size_t>(c.second);
        const Vector branch = Vector(p.x[b] - p.x[a], p.y[b] - p.y[a]) + p.cell * Vector(c.image[0], c.image[1]);
        const Vector n = branch.normalized(), t(-n[1], n[0]);
        const double overlap = p.radius[a] + p.radius[b] - branch.norm();
        const Vector force = normal_stiffness * overlap * n + c.tangential_force * t; // on the second disc
        sum += force * branch.transpose();
    }
    return -sum / (p.cell.determinant() * p.thickness);
}

std::string problem_of(const std::string& discs, const std::string& contacts = "") {
    const std::string discs_file = test_file("csv_test_discs.csv"), contacts_file = test_file("csv_test_contacts.csv");
    std::ofstream(discs_file) << discs;
    std::ofstream(contacts_file) << contacts;
    try {
        read_packing_csv(discs_file, contacts.empty() ? "" : contacts_file);
    } catch (const Error& e) {
        return e.what();
    }
    return "";
}

const std::string two_discs = "# cell_h00=0.1 cell_h01=0 cell_h10=0 cell_h11=0.1\nx,y,radius\n0.01,0.05,0.005\n0.0199,0.05,0.005\n";

} // namespace

TEST_CASE("the stress recomputed from the contacts of the reference packings is their pressure of 100 kPa", "[eq49]") {
    for (const std::string name : {"medium", "loose"}) {
        const Packing p = read_packing_csv(yade + "packing_" + name + "_particles.csv", yade + "packing_" + name + "_contacts.csv");
        REQUIRE(p.disc_count() == 400);
        const Matrix stress = stress_of(p, 1e6); // k_n of the reference, N/m
        // Their servo stopped within 0.2 % of the pressure; the text's ten digits add nothing to that.
        CHECK(stress(0, 0) == Approx(-1e5).epsilon(0.002));
        CHECK(stress(1, 1) == Approx(-1e5).epsilon(0.002));
        CHECK(p.pressure == Approx(-0.5 * stress.trace()).epsilon(1e-6)); // recomputed from ten digits of overlap
        // The couple of the tangential forces: the stress is symmetric up to the unbalanced moments, 1e-4 of the pressure.
        CHECK(stress(0, 1) == Approx(stress(1, 0)).margin(50.0));
    }
}

TEST_CASE("the shear stress of the reference packing needs the sign of its tangential forces", "[eq49]") {
    const Packing p = read_packing_csv(yade + "packing_medium_particles.csv", yade + "packing_medium_contacts.csv");
    // First row of isochoric_medium.csv, the same state: sxy = 5679.21 Pa. Tolerance: digits of the text.
    CHECK(stress_of(p, 1e6)(0, 1) == Approx(5679.21).margin(50.0));
    CHECK(p.void_ratio() == Approx(0.2044).margin(1e-4)); // README of the reference
}

TEST_CASE("discs alone make a packing at rest without contacts") {
    std::ofstream(test_file("csv_test_simple.csv")) << two_discs;
    const Packing p = read_packing_csv(test_file("csv_test_simple.csv"));
    CHECK(p.disc_count() == 2);
    CHECK(p.contacts.empty());
    CHECK(p.velocity_x.empty());
    CHECK(p.cell(1, 1) == 0.1);
}

TEST_CASE("a contact across the cell's edge gets the image that its normal asks for") {
    const std::string across = "# cell_h00=0.1 cell_h01=0 cell_h10=0 cell_h11=0.1\nx,y,radius\n0.001,0.05,0.005\n0.0911,0.05,0.005\n";
    std::ofstream(test_file("csv_test_a.csv")) << across;
    std::ofstream(test_file("csv_test_b.csv")) << "id1,id2,nx,ny,overlap,ftx,fty\n0,1,-1,0,1e-4,0,3\n";
    const Packing p = read_packing_csv(test_file("csv_test_a.csv"), test_file("csv_test_b.csv"));
    REQUIRE(p.contacts.size() == 1);
    CHECK(p.contacts[0].image == std::array<int, 2>{-1, 0});
    CHECK(p.contacts[0].tangential_force == Approx(-3.0)); // t = (-n_y, n_x) = (0, -1)
}

TEST_CASE("a fault in a packing's text is one line with file, line, problem and mend") {
    CHECK_CONTAINS(problem_of("# cell_h00=0.1 cell_h01=0 cell_h10=0 cell_h11=0.1\nx,y,radius\n0,0,-1\n"), "csv_test_discs.csv:3: the radius is not positive");
    CHECK_CONTAINS(problem_of("# cell_h00=0.1 cell_h01=0 cell_h10=0 cell_h11=0.1\nx,y,radius\n0,zero,1\n"), ":3: \"zero\" in column \"y\"");
    CHECK_CONTAINS(problem_of("# cell_h00=0.1 cell_h01=0 cell_h10=0 cell_h11=0.1\nx,y,radius\n0,0\n"), ":3: 2 values");
    CHECK_CONTAINS(problem_of("# cell_h00=0.1 cell_h01=0 cell_h10=0 cell_h11=0.1\nx,y,r\n0,0,1\n"), "no column \"radius\"");
    CHECK_CONTAINS(problem_of("x,y,radius\n0,0,1\n"), "no cell_h00");
    CHECK_CONTAINS(problem_of("# cell_h00=0.1 cell_h01=0 cell_h10=0 cell_h11=0.1\nx,y,radius\n0,0,1\n0.01,0,1\n0,0,2\n"), "csv_test_discs.csv:5: the disc lies where that of line 3 lies");
    CHECK_CONTAINS(problem_of("# cell_h00=0.1 cell_h01=0.02 cell_h10=0 cell_h11=0.1\nx,y,radius\n0,0.03,1\n0.12,0.13,2\n"), ":4: the disc lies where that of line 3 lies");
    CHECK_CONTAINS(problem_of(two_discs, "id1,id2,nx,ny,overlap,ftx,fty\n0,7,1,0,1e-4,0,0\n"), "csv_test_contacts.csv:2: id2 = 7 is no disc");
    CHECK_CONTAINS(problem_of(two_discs, "id1,id2,nx,ny,overlap,ftx,fty\n0,1,0,1,1e-4,0,0\n"), "do not fit the positions");
    CHECK_CONTAINS(problem_of(two_discs, "id1,id2,nx,ny,overlap,ftx,fty\n0,1,2,0,1e-4,0,0\n"), "length is not 1");
}
