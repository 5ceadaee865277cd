#include "rve-farm/physics/stress.hpp"

#include <cmath>

#include "tests/support/catch.hpp"
#include "tests/support/rve_samples.hpp"

using namespace talik;
using namespace talik::farm;

TEST_CASE("two discs pressed together along x: the stress is the force times the branch over the volume, negative", "[eq49]") {
    RveParameters parameters; // k_n = 1e6 N/m, t = 0.1 m
    Packing packing;
    packing.cell << 0.04, 0, 0, 0.05;
    packing.x = {0.010, 0.010 + 0.008 - 1e-5};
    packing.y = {0.02, 0.02};
    packing.radius = {0.004, 0.004};
    const Farm farm(parameters, {packing}, {0});
    const Answer answer = farm.measure(0);
    CHECK(answer.stress[0] == Approx(-10.0 * (0.008 - 1e-5) / (0.04 * 0.05 * 0.1))); // f = 1e6 * 1e-5 = 10 N
    CHECK(answer.stress[1] == 0.0);
    CHECK(answer.stress[2] == 0.0);
    CHECK(answer.coordination_number == 1.0); // 2 Nc / N
    // Voigt: k b^2 / V along x.
    CHECK(answer.stiffness == Approx(1e6 * std::pow(0.008 - 1e-5, 2) / (0.04 * 0.05 * 0.1)));
}

TEST_CASE("the forces of the contacts on all discs cancel: the momentum of an undamped assembly is kept", "[eq49]") {
    RveParameters parameters;
    parameters.damping = 0;
    Farm farm(parameters, {samples::disordered(127)}, {0});
    samples::step(farm, {0, 0, 0, 0}, 1e-4, 10);
    const AssemblyView& s = farm.assembly(0).view();
    double x = 0, y = 0, sum = 0;
    for (int i = 0; i < s.disc_count(); ++i) {
        x += s.mass[i] * s.velocity_x[i], y += s.mass[i] * s.velocity_y[i];
        sum += s.mass[i] * std::hypot(s.velocity_x[i], s.velocity_y[i]);
    }
    REQUIRE(sum > 0);
    CHECK(std::abs(x) < 1e-13 * sum); // pairs are equal and opposite in bits: what is left is the order of the sums
    CHECK(std::abs(y) < 1e-13 * sum);
}

TEST_CASE("turning a stress leaves its mean and turns its axes", "[eq49]") {
    const Virial<double> stress{-100, -300, 0};
    const Virial<double> quarter = stress.turned(0, 1);
    CHECK(quarter.xx == -300);
    CHECK(quarter.yy == -100);
    const Virial<double> eighth = stress.turned(std::sqrt(0.5), std::sqrt(0.5)); // by 45 degrees, counter-clockwise
    CHECK(eighth.xx == Approx(-200));
    CHECK(eighth.xy == Approx(100));
}

TEST_CASE("the kinetic stress of moving discs is a pressure, there where the effect is on and nowhere else", "[eq49]") {
    Packing packing = samples::lattice(4, -0.5); // apart: no contacts
    packing.velocity_x = {1, -1, 1, -1};
    packing.velocity_y = {0, 0, 0, 0};
    packing.spin = {0, 0, 0, 0};
    RveParameters parameters;
    CHECK(Farm(parameters, {packing}, {0}).measure(0).stress[0] == 0.0);
    parameters.fluctuation_stress = true;
    const Answer answer = Farm(parameters, {packing}, {0}).measure(0);
    const double mass = 2650 * M_PI * 0.004 * 0.004 * 0.1; // kg
    CHECK(answer.stress[0] == Approx(-4 * mass / (answer.cell_area * 0.1))); // -(1/V) sum m v_x^2
    CHECK(answer.stress[1] == 0.0);
}
