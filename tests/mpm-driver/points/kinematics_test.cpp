#include "mpm-driver/points/kinematics.hpp"
#include "tests/support/catch.hpp"

using namespace talik;
using namespace talik::driver;

TEST_CASE("the exponential of a spin is the rotation by its angle") {
    for (const double angle : {1e-9, 1e-5, 9e-5, 1.1e-4, 0.3, 3.0}) {
        Matrix spin;
        spin << 0.0, -angle, angle, 0.0;
        CHECK((exponential(spin) - rotation(angle)).cwiseAbs().maxCoeff() < 1e-15); // roundings of numbers up to 1
        CHECK(polar_angle(exponential(spin)) == Approx(angle).epsilon(1e-7));
    }
}

TEST_CASE("the exponential of a sum of commuting parts is their product, and inverts with the sign") {
    Matrix a;
    a << 0.02, 0.31, -0.07, 0.05;
    CHECK((exponential(a) * exponential(-a) - Matrix::Identity()).cwiseAbs().maxCoeff() < 1e-15);
    CHECK((exponential(0.5 * a) * exponential(0.5 * a) - exponential(a)).cwiseAbs().maxCoeff() < 1e-15);
    CHECK(std::abs(exponential(a).determinant() - std::exp(a.trace())) < 1e-15);
}

TEST_CASE("the logarithmic strain of a stretch is the logarithm of its lengths, whatever the rotation before it", "[eq48]") {
    Matrix stretch;
    stretch << 1.3, 0.0, 0.0, 0.7;
    const Matrix strain = logarithmic_strain(stretch * rotation(0.8));
    CHECK(std::abs(strain(0, 0) - std::log(1.3)) < 1e-14);
    CHECK(std::abs(strain(1, 1) - std::log(0.7)) < 1e-14);
    CHECK(std::abs(strain(0, 1)) < 1e-14);
    // sqrt(1/2 e:e) of the deviator: half the difference of the two lengths' logarithms
    CHECK(equivalent_strain(stretch) == Approx(0.5 * std::log(1.3 / 0.7)).epsilon(1e-13));
    CHECK(equivalent_strain(rotation(0.4)) < 1e-7); // the square root of a rounding
}
