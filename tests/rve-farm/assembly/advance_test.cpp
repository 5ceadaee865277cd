#include "rve-farm/kernel/macro_step.hpp"

#include <cmath>

#include "rve-farm/physics/stress.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/rve_samples.hpp"

using namespace talik;
using namespace talik::farm;

TEST_CASE("a rigid rotation of the cell rotates the stress and does nothing else", "[eq49][rotation]") {
    RveParameters parameters;
    const Packing packing = samples::disordered(127);
    Farm turned(parameters, {packing}, {0}), still(parameters, {packing}, {0});
    for (Farm* farm : {&turned, &still}) { // a state with shear stress and with motion left in it
        for (int k = 0; k < 10; ++k) samples::step(*farm, {1e-4, 2e-4, 2e-4, -1e-4}, 1e-3);
    }
    const int steps = 200;
    const double angle = 2 * M_PI / steps; // one turn
    Answer a, b;
    for (int k = 1; k <= steps; ++k) {
        a = samples::step(turned, {0, -angle, angle, 0}, 1e-3);
        b = samples::step(still, {0, 0, 0, 0}, 1e-3);
        const Virial<double> expected =
            Virial<double>{b.stress[0], b.stress[1], b.stress[2]}.turned(std::cos(k * angle), std::sin(k * angle));
        const double tolerance = 1e-12 * samples::mean_pressure(b); // per turn, the law's own figure
        CHECK(std::abs(a.stress[0] - expected.xx) < tolerance);
        CHECK(std::abs(a.stress[1] - expected.yy) < tolerance);
        CHECK(std::abs(a.stress[2] - expected.xy) < tolerance);
    }
    CHECK(std::abs(b.stress[2]) > 1e-2 * samples::mean_pressure(b)); // there was something to rotate
    // Nothing else: in co-rotated axes every disc and contact is the same, in bits.
    const AssemblyView &s = turned.assembly(0).view(), &t = still.assembly(0).view();
    for (int i = 0; i < s.disc_count(); ++i) {
        CHECK(s.x[i] == t.x[i]);
        CHECK(s.velocity_y[i] == t.velocity_y[i]);
        CHECK(s.spin[i] == t.spin[i]);
    }
    CHECK(a.kinetic_energy == b.kinetic_energy);
    CHECK(a.friction_dissipation == b.friction_dissipation);
}

TEST_CASE("an increment too large for the given sub-steps is split into more, and counted", "[split]") {
    RveParameters parameters;
    const Packing packing = samples::disordered(31);
    Farm once(parameters, {packing}, {0}), many(parameters, {packing}, {0});
    const Answer a = samples::step(once, {-2e-3, 0, 0, 0}, 1e-4, 10); // 2e-4 per sub-step: twice what is followed
    const Answer b = samples::step(many, {-2e-3, 0, 0, 0}, 1e-4, 20);
    CHECK(a.split_steps == 1);
    CHECK(b.split_steps == 0);
    CHECK(a.stress == b.stress);
    CHECK(samples::step(once, {-1e-4, 0, 0, 0}, 1e-4, 10).split_steps == 1); // small again: not split
}

TEST_CASE("an RVE that has lost all contacts answers zero stress, and can be recompressed", "[eq49]") {
    RveParameters parameters;
    Farm farm(parameters, {samples::disordered(36)}, {0});
    Answer answer;
    for (int k = 0; k < 60; ++k) answer = samples::step(farm, {1e-2, 0, 0, 1e-2}, 1e-2);
    CHECK(answer.contacts == 0);
    CHECK(answer.stress == std::array<double, 3>{0, 0, 0});
    CHECK(answer.stiffness == 0.0);
    for (int k = 0; k < 1000 && samples::mean_pressure(answer) < 1e4; ++k) answer = samples::step(farm, {-2e-3, 0, 0, -2e-3}, 1e-2);
    CHECK(answer.status == Status::ok);
    CHECK(samples::mean_pressure(answer) >= 1e4);
}

TEST_CASE("a request that is no number, and discs that explode, are statuses and not crashes", "[status]") {
    RveParameters parameters;
    Farm farm(parameters, {samples::disordered(31)}, {0});
    CHECK(samples::step(farm, {std::nan(""), 0, 0, 0}, 1e-3).status == Status::bad_request);
    CHECK(samples::step(farm, {0, 1e300, 0, 0}, 1e-3).status == Status::bad_request);
    CHECK(samples::step(farm, {0, 0, 0, 0}, 1e-3).status == Status::ok); // refused requests have changed nothing
    farm.assembly(0).view().velocity_x[3] = 1e6; // m/s: ten metres in a sub-step
    CHECK(samples::step(farm, {0, 0, 0, 0}, 1e-3).status == Status::not_finite);
    for (int disc = 0; disc < 31; ++disc) { // whichever it is
        Farm other(parameters, {samples::disordered(31)}, {0});
        other.assembly(0).view().velocity_x[disc] = std::nan("");
        const Status status = samples::step(other, {0, 0, 0, 0}, 1e-5, 1).status;
        CHECK(status == Status::not_finite);
        CHECK(other.assembly(0).numbers().rebuilds == 1); // seen before it reached the neighbours
    }
}
