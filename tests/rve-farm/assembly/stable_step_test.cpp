#include "rve-farm/assembly/stable_step.hpp"

#include <cmath>

#include "common/base/error.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/rve_samples.hpp"

using namespace talik;
using namespace talik::farm;

namespace {
const ContactLaw<double> contact{1e6, 1e6, 0.5};
}

TEST_CASE("two discs on one spring: the stable step is that of their relative motion", "[step]") {
    Packing packing;
    packing.cell << 0.04, 0, 0, 0.04;
    packing.x = {0.010, 0.010 + 0.008 - 1e-5};
    packing.y = {0.02, 0.02};
    packing.radius = {0.004, 0.004};
    const Farm farm(RveParameters{}, {packing}, {0});
    const double m = 2650 * M_PI * 0.004 * 0.004 * 0.1; // kg
    // Tangential mode: u_y of both, and both rolling: k_t (2/m + 2 / (m/2)) = 6 k_t / m; along the normal 2 k_n / m.
    CHECK(omega_squared_of_contacts(farm.assembly(0).view(), contact) == Approx(6e6 / m).epsilon(1e-5));
}

TEST_CASE("the estimates are ordered: list, contacts, power iteration", "[step]") {
    const Farm farm(RveParameters{}, {samples::disordered(127)}, {0});
    const AssemblyView& s = farm.assembly(0).view();
    const double list = omega_squared_bound_of_list(s, contact), bound = omega_squared_bound_of_contacts(s, contact),
                 exact = omega_squared_of_contacts(s, contact);
    CHECK(list >= bound);
    CHECK(bound >= exact);
    CHECK(exact > 0);
}

TEST_CASE("a step just below the limit is stable, one just above it is refused at the start and taken in smaller ones on the way", "[step]") {
    RveParameters parameters;
    parameters.damping = 0;
    parameters.contact.friction = 1e9;
    const Packing packing = samples::lattice(36, 0.04, 0, 0.002, 3);
    const double limit = Farm(parameters, {packing}, {0}).largest_stable_step(0);

    parameters.time_step = 0.98 * limit;
    Farm stable(parameters, {packing}, {0});
    Answer answer;
    for (int k = 0; k < 20; ++k) answer = samples::step(stable, {0, 0, 0, 0}, 98 * limit, 100);
    CHECK(answer.status == Status::ok);
    CHECK(answer.kinetic_energy < answer.stored_energy);

    const Answer helped = samples::step(stable, {0, 0, 0, 0}, 102 * limit, 100);
    CHECK(helped.status == Status::ok);
    CHECK(helped.split_steps == 1);
    const Answer refused = samples::step(stable, {0, 0, 0, 0}, 1e5 * limit, 100); // far beyond what a network can grow to
    CHECK(refused.status == Status::unstable_step);
    CHECK(refused.largest_stable_step == Approx(limit).epsilon(0.02)); // the overlaps have moved a little
    CHECK(samples::step(stable, {0, 0, 0, 0}, 98 * limit, 100).status == Status::ok); // refused is not harmed

    parameters.time_step = 1.02 * limit;
    try {
        Farm unstable(parameters, {packing}, {0});
        FAIL("accepted");
    } catch (const Error& error) {
        CHECK(error.code() == ExitCode::bad_input);
        CHECK(error.remedy().find("largest stable step") != std::string::npos);
    }
}
