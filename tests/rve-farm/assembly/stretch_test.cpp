#include "rve-farm/assembly/stretch.hpp"

#include <cmath>

#include <unsupported/Eigen/MatrixFunctions>

#include "tests/support/catch.hpp"
#include "tests/support/rve_samples.hpp"

using namespace talik;
using namespace talik::farm;

namespace {
Matrix matrix(double xx, double xy, double yx, double yy) {
    Matrix m;
    m << xx, xy, yx, yy;
    return m;
}
} // namespace

TEST_CASE("rotation times stretch is the exponential of the displacement gradient", "[eq45]") {
    const Matrix gradients[] = {matrix(0.1, 0, 0, -0.2), matrix(0, 0.3, 0, 0),     matrix(0, -0.4, 0.4, 0),
                                matrix(0.1, 0.5, -0.3, 0.2), matrix(1e-9, 2e-9, -1e-9, 3e-9), matrix(0.2, 0.1, -0.1, 0.2)};
    for (const Matrix& g : gradients) {
        const Stretch stretch = stretch_of(g(0, 0), g(0, 1), g(1, 0), g(1, 1), 0);
        const Symmetric d = stretch.change();
        const double c = std::cos(stretch.rotation), s = std::sin(stretch.rotation);
        const Matrix product = matrix(c, -s, s, c) * matrix(1 + d.xx, d.xy, d.xy, 1 + d.yy);
        const Matrix exact = g.exp();
        CHECK((product - exact).norm() < 1e-15 * 4); // a few roundings of numbers of size one
        const Symmetric e = stretch.change_seen_from_the_end(); // I - U^-1
        const Matrix unit = matrix(1 - e.xx, -e.xy, -e.xy, 1 - e.yy) * matrix(1 + d.xx, d.xy, d.xy, 1 + d.yy);
        CHECK((unit - Matrix::Identity()).norm() < 1e-15 * 4);
    }
}

TEST_CASE("a pure rotation has no stretch, in bits, and a rotated frame sees the stretch turned", "[eq45]") {
    for (double angle : {1e-9, 1e-3, 0.3, 1.0}) {
        const Symmetric d = stretch_of(0, -angle, angle, 0, 0.7).change();
        CHECK(d.xx == 0.0);
        CHECK(d.yy == 0.0);
        CHECK(d.xy == 0.0);
    }
    const Symmetric quarter = stretch_of(0.1, 0, 0, -0.1, std::acos(0.0)).change(); // frame turned by 90 degrees
    CHECK(quarter.yy == Approx(std::expm1(0.1)));
    CHECK(quarter.xx == Approx(std::expm1(-0.1)));
}

TEST_CASE("the cell follows the exponential of the motion exactly, through rotation, shear and reductions", "[eq45]") {
    RveParameters parameters;
    Farm farm(parameters, {samples::lattice(36, -0.3)}, {0}); // without contacts: the cell alone
    Matrix expected = farm.cell(0);
    const Matrix g = matrix(1e-4, 4e-3, -1e-3, -2e-4);
    for (int k = 0; k < 1000; ++k) samples::step(farm, {g(0, 0), g(0, 1), g(1, 0), g(1, 1)}, 1e-3, 100);
    expected = (1000 * g).exp() * expected;
    // The lattice, not the basis, is what must agree: the old basis in multiples of the new one is whole numbers.
    const Matrix multiples = farm.cell(0).inverse() * expected;
    const Matrix whole = multiples.array().round().matrix();
    // 1e5 sub-steps with compensated sums: what is left is the rounding of the two exponentials and of the products.
    INFO("relative error " << (farm.cell(0) * whole - expected).norm() / expected.norm());
    CHECK((farm.cell(0) * whole - expected).norm() < 1e-13 * expected.norm());
    CHECK(std::abs(whole.determinant() - 1) < 1e-9);
}
