#include "mpm-driver/heat/freezing_curve.hpp"

#include <cmath>

#include "common/io/text_file.hpp"
#include "tests/mpm-driver/fault_text.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/temporary_file.hpp"

using namespace talik;
using namespace talik::driver;
using namespace talik::driver::tests;

namespace {

ThermalMaterialSpec curve(const std::string& kind) {
    ThermalMaterialSpec spec;
    spec.curve = kind;
    return spec;
}

// Its integral by Simpson's rule on 2000 pieces, K.
double integral_by_rule(const FreezingCurve& f, double from) {
    const int pieces = 2000;
    const double d = (f.top() - from) / pieces;
    double sum = 0.0;
    for (int i = 0; i < pieces; ++i) {
        const double a = from + i * d, end = i + 1 == pieces ? std::nextafter(f.top(), -1e9) : a + d;
        sum += d / 6.0 * (f.fraction(a) + 4.0 * f.fraction(a + 0.5 * d) + f.fraction(end));
    }
    return sum;
}

void check_calculus(const FreezingCurve& f, double from, double tolerance) {
    double before = 2.0;
    for (double t = from; t < f.top(); t += 0.0137 * (f.top() - from)) {
        CHECK(f.fraction(t) <= before); // never grows with temperature
        before = f.fraction(t);
        const double d = 1e-6 * (f.top() - from);
        CHECK(f.slope(t) == Approx((f.fraction(t + d) - f.fraction(t - d)) / (2 * d)).margin(1e-5)); // central difference
    }
    CHECK(f.integral(from) == Approx(integral_by_rule(f, from)).epsilon(tolerance));
}

} // namespace

TEST_CASE("coarse soil freezes along a ramp between T0 and T_res, or at once where the ramp has no width", "[eq38][eq39]") {
    ThermalMaterialSpec spec = curve("ramp");
    spec.freezing_temperature = -0.1;
    spec.residual_temperature = -1.1;
    spec.residual_saturation = 0.2;
    const FreezingCurve ramp(spec, 1.0);
    CHECK(ramp.fraction(0.0) == 0.0);
    CHECK(ramp.fraction(-0.6) == Approx(0.4)); // half of the 0.8 that freezes
    CHECK(ramp.fraction(-5.0) == Approx(0.8));
    CHECK(ramp.integral(-2.1) == Approx(0.5 * 0.8 + 0.8)); // triangle and rectangle, K
    spec.residual_temperature = -0.1;
    const FreezingCurve sharp(spec, 1.0);
    CHECK(sharp.jump() == Approx(0.8));
    CHECK(sharp.fraction(-0.1000001) == Approx(0.8));
    CHECK(sharp.fraction(-0.0999999) == 0.0);
    CHECK(sharp.integral(-1.1) == Approx(0.8));
}

TEST_CASE("fine soil keeps the water w = wbar + (w0 - wbar) exp(a (T - T0)): more than its pores hold is cut and told", "[eq4][eq40]") {
    const double all = 0.427 * 1000.0 / (0.573 * 2650.0); // what the pores hold: 0.2812
    const FreezingCurve consistent(curve("fine"), all);
    CHECK(consistent.excess() == 0.0);
    CHECK(consistent.jump() == Approx(0.0).margin(1e-15));
    const double w = 0.058 + (all - 0.058) * std::exp(-0.16 * 5.0); // at -5 C
    CHECK(consistent.fraction(-5.0) == Approx(1.0 - w / all));
    check_calculus(consistent, -30.0, 1e-12); // Simpson's rule on 2000 pieces of a smooth curve: about 1e-14
    ThermalMaterialSpec printed = curve("fine");
    printed.water_content = 0.285; // the paper's: theta_s = -0.006 at T0
    const FreezingCurve cut(printed, all);
    CHECK(0.427 * cut.excess() == Approx(0.006).margin(5e-4));
    CHECK(cut.top() < 0.0);
    CHECK(cut.fraction(cut.top() - 1e-9) == Approx(0.0).margin(1e-8));
}

TEST_CASE("the saturation curve leaves S_res + (1 - S_res) exp(-((T - T0)/W)^2) of the water liquid", "[eq41]") {
    ThermalMaterialSpec spec = curve("saturation");
    spec.residual_saturation = 0.05;
    const FreezingCurve f(spec, 1.0);
    CHECK(1.0 - f.fraction(-0.5) == Approx(0.05 + 0.95 * std::exp(-1.0)));
    CHECK(1.0 - f.fraction(-5.0) == Approx(0.05));
    check_calculus(f, -3.0, 1e-12);
}

TEST_CASE("a table of unfrozen saturation is read straight between its rows, and refused where it is not monotonic", "[curve]") {
    const std::string file = test_file("curve.csv");
    ThermalMaterialSpec spec = curve("table");
    spec.curve_file = file;
    write_file_atomically(file, "temperature_C,unfrozen_saturation\n-4,0.1\n-1,0.4\n-0.5,1\n");
    const FreezingCurve f(spec, 1.0);
    CHECK(f.top() == -0.5);
    CHECK(f.fraction(-2.5) == Approx(0.75));
    check_calculus(f, -3.9, 1e-6); // corners within pieces of 0.0017 K
    const auto fault = [&](const std::string& rows) {
        write_file_atomically(file, "temperature_C,unfrozen_saturation\n" + rows);
        return fault_of([&] { FreezingCurve(spec, 1.0); });
    };
    CHECK(says(fault("-4,0.4\n-1,0.1\n0,1\n"), "curve.csv:3: the freezing curve is not monotonic: 0.1 of the water is unfrozen at -1 C, 0.4 at -4 C"));
    CHECK(says(fault("-1,0.4\n-4,0.1\n"), "curve.csv:3: its temperature is not above that of the row before"));
    CHECK(says(fault("-4,0.4\n0,1.2\n"), "an unfrozen saturation of 1.2 is not in [0, 1]"));
    CHECK(says(fault("-4,0.4\n0,0.9\n"), "0.9 of the water is unfrozen in the warmest row"));
}

TEST_CASE("a temperature that is no number freezes to no number, and is looked up in no table", "[curve]") {
    const double none = std::nan("");
    for (const char* kind : {"ramp", "saturation"}) {
        const FreezingCurve f(curve(kind), 1.0); // a ramp of no width is a table of one row
        CAPTURE(kind);
        CHECK(std::isnan(f.fraction(none)));
        f.slope(none); // reads nothing beyond the table (with sanitizers)
    }
}
