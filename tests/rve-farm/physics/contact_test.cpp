#include "rve-farm/physics/contact.hpp"

#include "tests/support/catch.hpp"

using namespace talik::farm;

namespace {
const ContactLaw<double> law{2e6, 1e6, 0.5}; // N/m, N/m, -
}

TEST_CASE("a contact pushes by its normal stiffness times the overlap, and never pulls", "[eq5]") {
    CHECK(law.limited(law.elastic(1e-4, 0, 0)).normal == Approx(200.0)); // 2e6 N/m * 1e-4 m
    CHECK(law.limited(law.elastic(0, 0, 0)).normal == 0.0);
    CHECK(law.limited(law.elastic(-1e-4, 0, 0)).normal == 0.0);
}

TEST_CASE("the tangential force opposes the slip and adds up over the sub-steps", "[eq5]") {
    const ContactForce<double> once = law.limited(law.elastic(1e-4, 0, 3e-5));
    CHECK(once.tangential == Approx(-30.0)); // -1e6 N/m * 3e-5 m
    CHECK(law.limited(law.elastic(1e-4, once.tangential, 2e-5)).tangential == Approx(-50.0));
    CHECK(law.limited(law.elastic(1e-4, once.tangential, -3e-5)).tangential == Approx(0.0).margin(1e-12));
}

TEST_CASE("the tangential force is cut at the friction coefficient times the normal force, either way", "[eq5]") {
    CHECK(law.limited(law.elastic(1e-4, 0, 2e-4)).tangential == Approx(-100.0)); // 0.5 * 200 N
    CHECK(law.limited(law.elastic(1e-4, 0, -2e-4)).tangential == Approx(100.0));
    CHECK(law.limited(law.elastic(-1e-6, 80, 0)).tangential == 0.0); // an open contact forgets
}

TEST_CASE("steady sliding dissipates the friction force times the slip", "[eq5][energy]") {
    const double limit = 100, slip = 1e-5; // N, m
    const ContactForce<double> trial = law.elastic(1e-4, -limit, slip);
    CHECK(law.friction_loss(-limit, trial.tangential, law.limited(trial).tangential) == Approx(limit * slip));
    CHECK(law.friction_loss(-30, -40, -40) == 0.0); // sticking loses nothing
}
