#include "rve-farm/packing/prepare.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/error.hpp"
#include "rve-farm/backend/farm.hpp"
#include "rve-farm/packing/random_discs.hpp"
#include "tests/support/text.hpp"

using namespace talik;
using namespace talik::farm;

namespace {

RveSpec hundred_discs(double void_ratio) {
    RveSpec spec;
    spec.packing.discs = 100;
    spec.packing.void_ratio = void_ratio;
    return spec;
}

bool same_bits(const Packing& a, const Packing& b) {
    const auto forces = [](const Packing& p) {
        std::vector<double> all;
        for (const auto& c : p.contacts) all.push_back(c.tangential_force);
        return all;
    };
    return a.cell == b.cell && a.x == b.x && a.y == b.y && a.radius == b.radius && forces(a) == forces(b);
}

// As a run imports it: its own step and damping.
Answer imported(const RveSpec& spec, const Packing& packing) { return Farm(spec.parameters, {packing}, {0}).measure(0); }

std::string problem_of(const RveSpec& spec) {
    try {
        prepare_packing(spec, spec.packing.seed);
    } catch (const Error& e) {
        CHECK(e.code() == ExitCode::bad_input);
        return e.what();
    }
    return "";
}

} // namespace

TEST_CASE("random discs have the radii and the void ratio asked for, and none touches another, images included") {
    const RveSpec spec = hundred_discs(0.2);
    const Packing p = random_discs(spec, 7, 0, 1.0);
    CHECK(p.void_ratio() == Approx(1.0).epsilon(1e-12));
    CHECK(*std::min_element(p.radius.begin(), p.radius.end()) >= spec.packing.radius_min);
    CHECK(*std::max_element(p.radius.begin(), p.radius.end()) <= spec.packing.radius_max);
    double mean = 0.0;
    for (double r : p.radius) mean += r / 100.0;
    CHECK(mean == Approx(3.75e-3).margin(3.0 * 7.2e-5)); // three standard errors: width / sqrt(12 * 100)
    int touching = 0;
    for (std::size_t i = 0; i < 100; ++i)
        for (std::size_t j = 0; j < i; ++j)
            for (int a = -1; a <= 1; ++a)
                for (int b = -1; b <= 1; ++b)
                    touching += std::hypot(p.x[j] - p.x[i] + a * p.cell(0, 0), p.y[j] - p.y[i] + b * p.cell(1, 1)) < p.radius[i] + p.radius[j];
    CHECK(touching == 0);
    CHECK_FALSE(same_bits(p, random_discs(spec, 8, 0, 1.0)));
    CHECK_FALSE(same_bits(p, random_discs(spec, 7, 1, 1.0)));
}

TEST_CASE("a prepared packing has the void ratio, the isotropic stress and the rest that were asked for", "[eq49]") {
    for (const double void_ratio : {0.170, 0.203, 0.225}) {
        const RveSpec spec = hundred_discs(void_ratio);
        const Packing p = prepare_packing(spec, 3);
        const Answer a = imported(spec, p);
        CAPTURE(void_ratio, a.void_ratio, a.stress[0], a.stress[1], a.stress[2], a.unbalanced_force);
        CHECK(std::abs(a.void_ratio - void_ratio) <= spec.packing.void_ratio_tolerance);
        // What `pack` promises: every component of the stress within 0.2 % of the pressure.
        CHECK(std::abs(a.stress[0] + 1e5) < 200.0);
        CHECK(std::abs(a.stress[1] + 1e5) < 200.0);
        CHECK(std::abs(a.stress[2]) < 200.0);
        CHECK(a.unbalanced_force < 1e-4);
        CHECK(a.coordination_number > 3.0); // jammed: 3 with friction, 4 without, in the plane
        CHECK(p.pressure == 1e5);
        CHECK(p.stable_step > 1e-5);
    }
}

TEST_CASE("the same seed gives the same packing to the bit, for any number of threads: another seed another packing") {
    RveSpec spec = hundred_discs(0.203);
    spec.packing.count = 2;
    spec.packing.seed = 5;
    const auto one = prepare_packings(spec, 1), two = prepare_packings(spec, 2);
    REQUIRE(one.size() == 2);
    CHECK(same_bits(one[0], two[0]));
    CHECK(same_bits(one[1], two[1]));
    CHECK_FALSE(same_bits(one[0], one[1]));
    CHECK(one[1].seed == 6);
}

TEST_CASE("the packing does not depend on the step and damping of the run it is for") {
    RveSpec spec = hundred_discs(0.203);
    const Packing p = prepare_packing(spec, 5);
    spec.parameters.time_step = 2e-5;
    spec.parameters.damping = 0.0;
    CHECK(same_bits(p, prepare_packing(spec, 5)));
}

TEST_CASE("a void ratio out of reach is refused with the range that can be reached") {
    for (const double void_ratio : {0.05, 0.5}) {
        const std::string problem = problem_of(hundred_discs(void_ratio));
        CHECK_CONTAINS(problem, "is out of reach for seed 1");
        CHECK_CONTAINS(problem, "100 discs of these sizes at 100 kPa with friction 0.5 reach about 0.1");
    }
}

TEST_CASE("a target inside the reachable range that is missed for its tolerance is said to be too tight, not out of reach") {
    RveSpec spec = hundred_discs(0.2);
    spec.packing.discs = 8; // a handful of discs jumps past a target: contacts open one by one
    spec.packing.void_ratio_tolerance = 1e-6;
    const std::string problem = problem_of(spec);
    CAPTURE(problem);
    CHECK_FALSE(contains(problem, "out of reach"));
    CHECK((contains(problem, "with 8 discs the tolerance of 1e-06 is too tight") || contains(problem, "sub-steps (seed 1")));
}

TEST_CASE("a packing that does not come to rest is given up after a bounded number of sub-steps, with what was reached") {
    RveSpec spec = hundred_discs(0.2);
    spec.packing.discs = 4;
    spec.packing.pressure = 1e-2; // compaction takes sqrt(k_n / (p t)) times the sub-steps: 3000 times those at 100 kPa
    const std::string problem = problem_of(spec);
    CHECK_CONTAINS(problem, "no packing of void ratio 0.2 within 16000000 sub-steps (seed 1, draw ");
    CHECK_CONTAINS(problem, "with an unbalanced force of");
}

TEST_CASE("discs from CSV with their contacts are kept as they are: discs alone are brought to the pressure") {
    const std::string yade = TALIK_SOURCE_DIR "/tests/reference/yade/packing_medium_";
    RveSpec spec;
    spec.packing.particles = yade + "particles.csv";
    spec.packing.contacts = yade + "contacts.csv";
    const Packing kept = prepare_packings(spec, 1).at(0);
    CHECK(kept.contacts.size() == 767); // README of the reference
    spec.packing.contacts.clear();
    const Answer pressed = imported(spec, prepare_packings(spec, 1).at(0));
    CHECK(pressed.stress[0] == Approx(-1e5).epsilon(0.002));
    CHECK(pressed.stress[1] == Approx(-1e5).epsilon(0.002));
    CHECK(std::abs(pressed.stress[2]) < 200.0); // the reference left 5.7 kPa of shear, ours does not
}
