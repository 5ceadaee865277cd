#include "rve-farm/physics/damping.hpp"

#include "rve-farm/kernel/disc_step.hpp"

#include "tests/support/catch.hpp"
#include "tests/support/rve_samples.hpp"

using namespace talik;
using namespace talik::farm;

TEST_CASE("local damping weakens the force that drives a motion and strengthens the one that brakes it", "[damping]") {
    const LocalDamping<double> damping{0.2};
    CHECK(damping.damped(10.0, 1.0) == Approx(8.0));
    CHECK(damping.damped(10.0, -1.0) == Approx(12.0));
    CHECK(damping.damped(-10.0, 1.0) == Approx(-12.0));
    CHECK(damping.damped(0.0, 1.0) == 0.0); // free flight is not damped
}

TEST_CASE("a disc at rest is damped from the first kick, because the velocity is that of its middle", "[damping]") {
    const struct {
        LocalDamping<double> damping{0.2};
    } physics;
    double damped = 0;
    CHECK(kicked(physics, 10.0, 0.0, 0.1, 1.0, damped) == Approx(0.8));
    CHECK(damped == Approx(8.0));
    CHECK(kicked(physics, 10.0, -0.4, 0.1, 1.0, damped) == Approx(0.4)); // v + dt/2 a = 0.1: driven
    CHECK(damped == Approx(8.0));
    CHECK(kicked(physics, 10.0, -0.6, 0.1, 1.0, damped) == Approx(0.6)); // v + dt/2 a = -0.1: braked
    CHECK(damped == Approx(12.0));
}

TEST_CASE("damping acts on the non-affine motion alone: a uniform strain of a perfect lattice dissipates nothing", "[damping]") {
    RveParameters parameters;
    Farm farm(parameters, {samples::lattice(36, 0.02)}, {0});
    Answer answer;
    for (int k = 0; k < 10; ++k) answer = samples::step(farm, {-1e-5, 0, 0, -1e-5}, 1e-3);
    // By symmetry no disc leaves the affine motion; what rounding lets it do is nothing beside the work.
    CHECK(answer.work > 0);
    CHECK(std::abs(answer.damping_dissipation) < 1e-12 * answer.work);
}

TEST_CASE("with damping a shaken assembly comes to rest, and the ledger says where the energy went", "[damping][energy]") {
    RveParameters parameters;
    Farm farm(parameters, {samples::disordered(36)}, {0});
    const Answer start = farm.measure(0);
    Answer answer;
    double largest_kinetic = 0;
    for (int k = 0; k < 100; ++k) {
        answer = samples::step(farm, {0, 0, 0, 0}, 1e-3);
        largest_kinetic = std::max(largest_kinetic, answer.kinetic_energy);
    }
    CHECK(answer.kinetic_energy < 1e-6 * largest_kinetic);
    CHECK(answer.damping_dissipation > 0.1 * largest_kinetic);
    CHECK(answer.work == 0.0);
    // Second order in the step, which is a quarter of the critical one: contacts that open and close weigh most.
    CHECK(std::abs(samples::ledger_error(start, answer)) < 1e-3 * start.stored_energy);
}
