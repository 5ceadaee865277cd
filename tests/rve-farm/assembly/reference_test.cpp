// The optimised path against an RVE written from the equations alone.
#include <cmath>

#include "tests/reference/naive_rve.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/rve_samples.hpp"

using namespace talik;
using namespace talik::farm;

namespace {

struct Case {
    const char* name;
    int discs;
    double damping;
    bool bonds;
    Matrix increment; // of a macro step of 20 sub-steps
};

Matrix gradient(double xx, double xy, double yx, double yy) {
    Matrix m;
    m << xx, xy, yx, yy;
    return m;
}

void compare(const Case& c) {
    RveParameters parameters;
    parameters.damping = c.damping;
    if (c.bonds) parameters.bond = BondParameters{2e6, 2e6, 1.0}; // weak: some break on the way
    const Packing packing = samples::disordered(c.discs);
    Farm farm(parameters, {packing}, {0});
    reference::NaiveRve naive(parameters, packing);
    if (c.bonds) {
        farm.activate_bonds();
        naive.bond_all();
        REQUIRE(naive.bonds() > c.discs);
    }
    const int bonds_at_start = naive.bonds();
    // Two orders of summation and two forms of the same formula differ by rounding, which contacts that open and slide
    // amplify over 400 sub-steps: 1e-10 of the first pressure, and of the work it does on the whole cell.
    const Answer start = farm.measure(0);
    const double scale = 1e-10 * samples::mean_pressure(start), energy = scale * start.cell_area * parameters.thickness;
    for (int macro = 0; macro < 20; ++macro) { // 400 sub-steps
        const Matrix& g = c.increment;
        const double ice = macro < 10 ? 1.0 : 0.5; // half of the strength thaws away
        naive.ice_saturation = ice;
        naive.advance(g, 2e-4, 20);
        const Answer answer = samples::step(farm, {g(0, 0), g(0, 1), g(1, 0), g(1, 1)}, 2e-4, 20, ice);
        REQUIRE(answer.status == Status::ok);
        const Matrix stress = naive.stress();
        INFO(c.name << ", macro step " << macro);
        CHECK(std::abs(answer.stress[0] - stress(0, 0)) < scale);
        CHECK(std::abs(answer.stress[1] - stress(1, 1)) < scale);
        CHECK(std::abs(answer.stress[2] - stress(0, 1)) < scale);
        CHECK(std::abs(answer.work - naive.work) < energy);
        CHECK(std::abs(answer.friction_dissipation - naive.friction_dissipation) < energy);
        CHECK(std::abs(answer.damping_dissipation - naive.damping_dissipation) < energy);
        CHECK(std::abs(answer.bond_dissipation - naive.bond_dissipation) < energy);
        CHECK(answer.bonds == naive.bonds());
    }
    if (c.bonds) CHECK(naive.bonds() < bonds_at_start); // the case has shown what it is for
    else CHECK(naive.friction_dissipation > 0);
}

} // namespace

TEST_CASE("the farm's RVE and one written from the equations alone give the same stress and energies", "[eq5][eq6][eq49]") {
    compare({"compression", 20, 0.2, false, gradient(-5e-4, 0, 0, -3e-4)});
    compare({"shear and rotation, undamped", 24, 0.0, false, gradient(0, 2e-3, 0, 0)});
    compare({"shear against rotation, damped", 31, 0.2, false, gradient(1e-4, -1e-3, 3e-3, -2e-4)});
    compare({"bonded extension", 24, 0.2, true, gradient(8e-4, 0, 0, 2e-4)});
    compare({"bonded shear, undamped", 33, 0.0, true, gradient(2e-4, 2e-3, -1e-3, 2e-4)});
}
