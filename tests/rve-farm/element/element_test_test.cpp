#include "tests/support/rve_samples.hpp"
#include "rve-farm/element/element_test.hpp"

#include <cmath>
#include <filesystem>

#include "common/io/csv_table.hpp"
#include "common/io/hdf5_file.hpp"
#include "common/packing/packing_csv.hpp"
#include "common/base/error.hpp"
#include "rve-farm/element/element_doubts.hpp"
#include "rve-farm/element/element_output.hpp"
#include "tests/support/text.hpp"
#include "tests/support/temporary_file.hpp"

using namespace talik;
using namespace talik::farm;

namespace {

const std::string yade = TALIK_SOURCE_DIR "/tests/reference/yade/";

const Packing& medium() {
    static const Packing packing = read_packing_csv(yade + "packing_medium_particles.csv", yade + "packing_medium_contacts.csv");
    return packing;
}

ElementTest test_of(const std::string& path, double strain) {
    ElementTest test;
    test.path = path;
    test.strain = strain;
    test.rows = 10;
    return test;
}

ElementCurve run(const ElementTest& test, const RveParameters& parameters = {}) { return run_element_test(test, parameters, {medium()}, samples::threads(1)).at(0); }

} // namespace

TEST_CASE("every path follows its strains, and the void ratio follows the area of the cell") {
    for (const std::string path : {"isotropic", "biaxial", "isochoric", "simple_shear"}) {
        const ElementCurve curve = run(test_of(path, 0.002));
        REQUIRE(curve.size() == 11);
        const ElementRow &begin = curve.front(), &end = curve.back();
        CAPTURE(path);
        CHECK(begin.time == 0.0);
        CHECK(end.time == Approx(0.02)); // strain / rate
        if (path == "simple_shear") {
            CHECK(end.gamma == Approx(0.002).epsilon(1e-12));
            CHECK(end.strain_yy == 0.0);
        } else {
            CHECK(end.strain_yy == Approx(-0.002).epsilon(1e-12));
        }
        if (path == "isochoric") CHECK(end.strain_xx == Approx(0.002).epsilon(1e-12));
        if (path == "isotropic") CHECK(end.strain_xx == Approx(-0.002).epsilon(1e-12));
        // A / A0 = exp(eps_xx + eps_yy), to the rounding of 4000 sub-steps
        CHECK(1.0 + end.answer.void_ratio == Approx((1.0 + begin.answer.void_ratio) * std::exp(end.strain_xx + end.strain_yy)).epsilon(1e-11));
    }
}

TEST_CASE("the biaxial test holds the lateral stress", "[eq49]") {
    for (const ElementRow& row : run(test_of("biaxial", 0.01)))
        if (row.strain_yy < -0.0015) CHECK(row.answer.stress[0] == Approx(-1e5).epsilon(0.003)); // the servo's first steps apart
}

TEST_CASE("the isochoric test from the reference packing follows the reference curve", "[eq49]") {
    const CsvTable reference = read_csv(yade + "isochoric_medium.csv");
    ElementTest test = test_of("isochoric", 0.005);
    test.rows = 5;
    const ElementCurve curve = run(test);
    const auto strain = reference.values("eps_yy_ln"), sxx = reference.values("sxx"), syy = reference.values("syy");
    for (std::size_t k = 1; k < curve.size(); ++k) {
        std::size_t row = 1;
        while (strain[row] > curve[k].strain_yy) ++row; // first reference row beyond; between the two linearly
        const double w = (curve[k].strain_yy - strain[row - 1]) / (strain[row] - strain[row - 1]);
        CAPTURE(curve[k].strain_yy);
        // 0.5 % of the pressure to 1 % strain is what two independent codes agree on.
        CHECK(curve[k].answer.stress[0] == Approx(sxx[row - 1] + w * (sxx[row] - sxx[row - 1])).margin(500.0));
        CHECK(curve[k].answer.stress[1] == Approx(syy[row - 1] + w * (syy[row] - syy[row - 1])).margin(500.0));
    }
}

TEST_CASE("bonds activated before loading strengthen the assembly as in the reference, without ice they do not", "[eq6][eq7][eq8]") {
    ElementTest test = test_of("biaxial", 0.01);
    test.forget_shear_forces = test.settle = test.activate_bonds = true; // prepared as the reference was: see its README
    RveParameters parameters;
    parameters.bond = BondParameters(); // c = 10 MPa
    const ElementCurve bonded = run(test, parameters);
    test.ice_saturation = 0.0; // beta_b = 0
    const ElementCurve thawed = run(test, parameters);
    CHECK(bonded.front().answer.bonds > 740); // 770 in the reference, whose servo ended in another state at rest
    for (std::size_t k = 1; k < bonded.size(); ++k) CHECK(bonded[k].answer.bonds <= bonded[k - 1].answer.bonds);
    CHECK(bonded.back().answer.bonds + bonded.back().answer.broken_bonds == bonded.front().answer.bonds);
    // biaxial_bonded_beta{1,0}.csv at 1 % logarithmic strain; repeated runs and codes agree within 1.5 % up to there.
    CHECK(bonded.back().answer.stress[1] == Approx(-176538.0).epsilon(0.015));
    CHECK(thawed.back().answer.stress[1] == Approx(-154017.0).epsilon(0.015));
}

TEST_CASE("settling brings all three stresses to the pressure before loading") {
    ElementTest test = test_of("isotropic", 1e-4);
    test.settle = test.forget_shear_forces = true;
    test.pressure = 1.2e5;
    const Answer start = run(test).front().answer;
    CHECK(start.stress[0] == Approx(-1.2e5).epsilon(0.002));
    CHECK(start.stress[1] == Approx(-1.2e5).epsilon(0.002));
    CHECK(std::abs(start.stress[2]) < 0.002 * 1.2e5);
}

TEST_CASE("many RVEs side by side give the curves that each gives alone, for any number of threads") {
    const Packing loose = read_packing_csv(yade + "packing_loose_particles.csv", yade + "packing_loose_contacts.csv");
    const ElementTest test = test_of("biaxial", 0.002);
    const auto both = run_element_test(test, {}, {medium(), loose, medium()}, samples::threads(2));
    const auto alone = run_element_test(test, {}, {loose}, samples::threads(1));
    for (std::size_t k = 0; k < alone[0].size(); ++k) {
        CHECK(both[1][k].answer.stress == alone[0][k].answer.stress);
        CHECK(both[0][k].answer.stress == both[2][k].answer.stress);
    }
}

TEST_CASE("files of an element test hold the curves, compression positive, and their mean and standard deviation") {
    const std::string folder = test_file("element_files");
    ElementRow a, b;
    a.strain_yy = b.strain_yy = -0.01;
    a.answer.stress = {-1e5, -2e5, 3.0};
    b.answer.stress = {-1e5, -4e5, 5.0};
    write_element_curves(folder, "of an earlier test", "", {{a}, {a}, {a}});
    write_element_curves(folder, "by hand", "title = \"by hand\"", {{a}, {b}});
    CHECK_FALSE(std::filesystem::exists(folder + "/rve-0002.csv")); // of the earlier test: not of this one
    const CsvTable one = read_csv(folder + "/rve-0001.csv"), mean = read_csv(folder + "/mean.csv");
    CHECK(one.values("stress_yy_compression_Pa") == std::vector<double>{4e5});
    CHECK(one.values("log_strain_yy_compression") == std::vector<double>{0.01});
    CHECK(one.values("stress_xy_tension_positive_Pa") == std::vector<double>{5.0});
    CHECK(mean.values("stress_yy_compression_Pa") == std::vector<double>{3e5});
    CHECK(mean.values("stress_yy_compression_Pa_sd").at(0) == Approx(std::sqrt(2.0) * 1e5)); // of two values: their distance / sqrt(2)
    const Hdf5File file = Hdf5File::open(folder + "/curves.h5");
    CHECK(file.read<double>("/rve/0001/stress_yy_compression_Pa").values == std::vector<double>{4e5});
    CHECK(file.read<double>("/mean/stress_ratio_yy_to_xx").values == std::vector<double>{3.0});
    CHECK(contains(file.read_text("/specification"), "by hand"));
}

TEST_CASE("a pressure that was not held is said, and curves that mean nothing are refused") {
    ElementTest test = test_of("biaxial", 0.1);
    Packing packing = medium();
    packing.pressure = test.pressure;
    CHECK(doubts_before(test, {packing}).empty());
    packing.pressure = 0.5 * test.pressure;
    CHECK(doubts_before(test, {packing}).size() == 1);
    test.settle = true;
    CHECK(doubts_before(test, {packing}).empty());

    ElementRow row;
    row.answer.void_ratio = 0.2;
    const auto ended_at = [&](double share) { // of the pressure to be held
        row.answer.stress = {-share * test.pressure, -3e5, 0.0};
        return std::vector<ElementCurve>{{row}};
    };
    CHECK(doubts_after(test, ended_at(1.04)).empty());
    CHECK(doubts_after(test, ended_at(0.9)).size() == 1);
    CHECK_NOTHROW(refuse_nonsense(test, ended_at(0.9)));
    CHECK_THROWS_AS(refuse_nonsense(test, ended_at(0.3)), Error);
    test.path = "isochoric"; // holds no stress
    CHECK_NOTHROW(refuse_nonsense(test, ended_at(0.3)));
    row.answer.void_ratio = -0.1;
    CHECK_THROWS_AS(refuse_nonsense(test, ended_at(1.0)), Error);
}

TEST_CASE("a test of more macro steps, or a macro step of more DEM sub-steps, than can be counted is refused") {
    ElementTest test;
    test.path = "isotropic", test.strain = 1e-3, test.rate = 0.1, test.step = 1e-300;
    CHECK_THROWS_WITH(run(test), Catch::Contains("more than 1e9"));
    RveParameters parameters;
    parameters.time_step = 1e-13, test.step = 1e-3;
    CHECK_THROWS_WITH(run(test, parameters), Catch::Contains("too many DEM sub-steps"));
}
