#include <cmath>

#include "mpm-driver/shape/ugimp.hpp"
#include "tests/support/catch.hpp"

using namespace talik::driver;

namespace {

// Eq. (24), piece by piece as printed: x the distance point - node, h the cell, l the half-size.
double printed_weight(double x, double h, double l) {
    const double d = std::abs(x);
    if (d >= h + l) return 0.0;
    if (d > h - l) return (h + l - d) * (h + l - d) / (4.0 * h * l);
    if (d > l) return 1.0 - d / h;
    return 1.0 - (x * x + l * l) / (2.0 * h * l);
}

// Eq. (25).
double printed_slope(double x, double h, double l) {
    const double d = std::abs(x), sign = x < 0.0 ? -1.0 : 1.0;
    if (d >= h + l) return 0.0;
    if (d > h - l) return -sign * (h + l - d) / (2.0 * h * l);
    if (d > l) return -sign / h;
    return -x / (h * l);
}

} // namespace

TEST_CASE("the three uGIMP weights and slopes are those of the printed pieces", "[eq24][eq25]") {
    const double h = 0.25;
    for (const double lambda : {0.5, 0.25, 1.0 / 6.0, 0.125})
        for (int k = 0; k <= 997; ++k) {
            const double centre = 3.0 + k / 997.0; // cells; passes every piece and every kink
            const auto w = ugimp_weights(centre, lambda, h);
            for (int node = 0; node < 8; ++node) {
                const int a = node - w.first_node;
                const double value = a >= 0 && a < 3 ? w.value[a] : 0.0, slope = a >= 0 && a < 3 ? w.slope[a] : 0.0;
                // Tolerance: a few roundings of numbers of order 1 (slopes: 1/h and 1/(2 lambda h)).
                CHECK(std::abs(value - printed_weight((centre - node) * h, h, lambda * h)) < 1e-14);
                CHECK(std::abs(slope - printed_slope((centre - node) * h, h, lambda * h)) < 2e-12);
            }
        }
}

TEST_CASE("uGIMP weights add up to one and reproduce linear fields", "[eq24][eq25]") {
    for (const double lambda : {0.5, 0.25, 0.125})
        for (int k = 0; k < 401; ++k) {
            const double centre = 5.0 + 2.0 * k / 401.0, h = 0.1;
            const auto w = ugimp_weights(centre, lambda, h);
            double sum = 0.0, slopes = 0.0, position = 0.0, unit = 0.0;
            for (int a = 0; a < 3; ++a) {
                sum += w.value[a];
                slopes += w.slope[a];
                position += w.value[a] * (w.first_node + a);
                unit += w.slope[a] * h * (w.first_node + a);
            }
            CHECK(std::abs(sum - 1.0) < 1e-15);
            CHECK(slopes == 0.0); // exactly: the middle slope is the rest
            CHECK(std::abs(position - centre) < 1e-14);
            CHECK(std::abs(unit - 1.0) < 1e-12); // node numbers of 7 times slopes of up to 4 with edges of 7 cells' rounding
        }
}

TEST_CASE("a uGIMP slope is the derivative of its weight", "[eq25]") {
    const double h = 0.1, lambda = 0.25, step = 1e-6; // cells
    for (int k = 0; k < 199; ++k) {
        const double centre = 5.0 + (k + 0.37) / 199.0;
        const auto at = ugimp_weights(centre, lambda, h);
        for (int a = 0; a < 3; ++a) {
            const int node = at.first_node + a;
            const double difference = (printed_weight((centre + step - node) * h, h, lambda * h) -
                                       printed_weight((centre - step - node) * h, h, lambda * h)) / (2.0 * step * h);
            // Weights are piecewise quadratic: central differences are exact but for rounding 1e-16/1e-7 and kinks (step * curvature).
            CHECK(std::abs(at.slope[a] - difference) < 1e-4);
        }
    }
}
