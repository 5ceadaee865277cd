#include "rve-farm/packing/k0_path.hpp"

#include <cmath>

#include "rve-farm/backend/farm.hpp"
#include "rve-farm/packing/prepare.hpp"
#include "tests/support/catch.hpp"

using namespace talik;
using namespace talik::farm;

namespace {

RveSpec specification() {
    RveSpec spec;
    spec.packing.discs = 60;
    spec.packing.void_ratio = 0.19;
    spec.packing.void_ratio_tolerance = 5e-3;
    spec.packing.pressure = 1e3;
    spec.packing.seed = 3;
    spec.packing.k0 = K0Spec{4, "linear", 4e3, 16e3};
    return spec;
}

const std::vector<Packing>& snapshots() { // prepared once for all tests
    static const std::vector<Packing> kept = prepare_packings(specification(), 1);
    return kept;
}

} // namespace

TEST_CASE("the levels of a K0 path reach from its lowest to its highest stress, evenly or in one ratio", "[k0]") {
    CHECK(K0Spec{3, "linear", 2e3, 8e3}.stresses() == std::vector<double>{2e3, 5e3, 8e3});
    const auto geometric = K0Spec{3, "geometric", 2e3, 8e3}.stresses();
    CHECK(geometric[0] == 2e3);
    CHECK(std::abs(geometric[1] - 4e3) < 1e-9);
    CHECK(std::abs(geometric[2] - 8e3) < 1e-9);
    CHECK(K0Spec{1, "linear", 2e3, 8e3}.stresses() == std::vector<double>{8e3});
}

TEST_CASE("a snapshot of a K0 path, put into a farm, rests at its vertical stress with the lateral stress it was kept with", "[k0][eq49]") {
    const RveSpec spec = specification();
    const auto levels = spec.packing.k0->stresses();
    REQUIRE(snapshots().size() == levels.size());
    std::vector<int> each = {0, 1, 2, 3};
    Farm farm(spec.parameters, snapshots(), each);
    std::vector<std::uint32_t> ids = {0, 1, 2, 3};
    std::vector<double> still(16, 0.0);
    std::vector<Answer> later(4);
    for (std::size_t k = 0; k < 4; ++k) {
        const Answer now = farm.measure(static_cast<int>(k));
        INFO("level " << k << ", K0 " << now.stress[0] / now.stress[1]);
        CHECK(std::abs(now.stress[1] + levels[k]) < 2e-3 * levels[k]); // held within 1e-3, and stopping the discs changes nothing
        CHECK(std::abs(now.stress[2]) < 2e-3 * levels[k]);             // held at 0 within the same
        CHECK(std::abs(now.stress[0] + snapshots()[k].lateral_stress) < 1e-9 * levels[k]); // rounding of positions
        CHECK(now.unbalanced_force < 1e-3); // settled to 1e-4; on import, forces are those of the rounded positions
        // Lateral stress at rest: sands have K0 of 0.3 to 0.6 (Jaky: 1 - sin phi), and no cohesionless ground at rest more
        // than 1 or less than Rankine's active (1 - sin phi)/(1 + sin phi) = 0.2 for phi = 42 degrees.
        CHECK(now.stress[0] / now.stress[1] > 0.2);
        CHECK(now.stress[0] / now.stress[1] < 1.0);
    }
    for (int k = 0; k < 20; ++k) farm.advance(ids, still, {}, 1e-3, 0, later);
    for (std::size_t k = 0; k < 4; ++k) CHECK(std::abs(later[k].stress[1] + levels[k]) < 5e-3 * levels[k]); // at rest: it stays
}

TEST_CASE("along a K0 path there is no lateral strain: the cells keep their width and grow shorter with the load", "[k0]") {
    double height = 1e9;
    for (const Packing& p : snapshots()) {
        CHECK(std::abs(p.cell(0, 0) - snapshots()[0].cell(0, 0)) < 1e-3 * p.cell(0, 0)); // only the shear that holds its stress at 0 turns the cell a little
        CHECK(p.cell.determinant() < height);
        height = p.cell.determinant();
    }
}

TEST_CASE("snapshots keep the tangential forces of their history", "[k0]") {
    for (const Packing& p : snapshots()) {
        double sum = 0.0;
        for (const PackedContact& c : p.contacts) sum += std::abs(c.tangential_force);
        CHECK(sum > 0.0);
    }
}
