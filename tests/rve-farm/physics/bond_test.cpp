#include "rve-farm/physics/bond.hpp"

#include "tests/support/catch.hpp"
#include "tests/support/rve_samples.hpp"

using namespace talik;
using namespace talik::farm;

namespace {
const BrittleBond<double> bond{1e7, 2e7}; // c_n, c_t in Pa
const double radius = 2e-3;                    // m: c_n r^2 = 40 N, c_t r^2 = 80 N

// A triangular lattice, pressed together by 1e-5 m and bonded. By symmetry its discs follow the cell and do not spin, so
// every bond's opening and slip are known.
Farm bonded_lattice(const BondParameters& strength, double friction) {
    RveParameters parameters;
    parameters.bond = strength;
    parameters.contact.friction = friction;
    Farm farm(parameters, {samples::lattice(16, 1e-5 / 0.004)}, {0});
    farm.activate_bonds();
    return farm;
}
} // namespace

TEST_CASE("a bond holds tension up to beta c_n r^2 and breaks beyond it", "[eq6]") {
    CHECK_FALSE(bond.breaks({-39.9, 0}, radius, 1.0));
    CHECK(bond.breaks({-40.1, 0}, radius, 1.0));
}

TEST_CASE("a bond holds shear up to beta c_t r^2 either way and breaks beyond it", "[eq7]") {
    for (double sign : {-1.0, 1.0}) {
        CHECK_FALSE(bond.breaks({10, sign * 79.9}, radius, 1.0));
        CHECK(bond.breaks({10, sign * 80.1}, radius, 1.0));
    }
}

TEST_CASE("the strength of bonds is proportional to the ice saturation", "[eq8]") {
    BondParameters frozen;
    frozen.strength_factor = 0.5;
    CHECK(frozen.strength_at(1.0) == 0.5);
    CHECK(frozen.strength_at(0.25) == 0.125);
    CHECK(frozen.strength_at(0.0) == 0.0);
    CHECK(bond.breaks({-10.1, 0}, radius, 0.25));
    CHECK_FALSE(bond.breaks({-9.9, 0}, radius, 0.25));
}

TEST_CASE("compression alone never breaks a bond, not even one without strength", "[eq6]") {
    CHECK_FALSE(bond.breaks({1e9, 0}, radius, 0.0));
    CHECK_FALSE(bond.breaks({0, 0}, radius, 0.0));
}

TEST_CASE("a bonded assembly holds together in tension, and lets go for good beyond its strength", "[eq6]") {
    Farm farm = bonded_lattice({1e7, 1e7, 1.0}, 0.5); // F_nb = 160 N: breaks at a tension of 1.6e-4 m
    const int bonds = farm.measure(0).bonds;
    REQUIRE(bonds == 48); // three per disc
    const auto stretch = [&](double opening) { // of every branch, m, in 100 sub-steps
        return samples::step(farm, {opening / 0.008, 0, 0, opening / 0.008}, 1e-3);
    };
    Answer answer;
    for (double opened = -1e-5; opened < 1.4e-4; opened += 2e-6) answer = stretch(2e-6);
    CHECK(answer.bonds == bonds);
    CHECK(answer.stress[0] > 0); // pulls
    for (int k = 0; k < 30; ++k) answer = stretch(2e-6);
    CHECK(answer.bonds == 0);
    CHECK(answer.broken_bonds == bonds);
    CHECK(answer.contacts == 0);
    CHECK(answer.stress[0] == 0.0);
    // F_nb^2 / 2 k_n each; the last sub-step's stretch of 2e-8 m is 1e-4 of the opening.
    CHECK(answer.bond_dissipation == Approx(bonds * 160.0 * 160.0 / 2e6).epsilon(1e-3));
    for (int k = 0; k < 130; ++k) answer = stretch(-2e-6);
    CHECK(answer.stress[0] < 0); // pressed together again: contacts, no bonds
    CHECK(answer.bonds == 0);
}

TEST_CASE("bonds survive any compression", "[eq6]") {
    Farm farm = bonded_lattice({1.0, 1e12, 1.0}, 0.5); // next to no tensile strength
    Answer answer;
    for (int k = 0; k < 100; ++k) answer = samples::step(farm, {-2e-4, 0, 0, -2e-4}, 1e-3);
    CHECK(answer.bonds == 48);
    CHECK(samples::mean_pressure(answer) > 1e5);
}

TEST_CASE("while bonded, the tangential force is not cut at the Coulomb limit: the broken bond obeys it on the same step",
          "[eq5][eq7]") {
    Farm farm = bonded_lattice({1e12, 1e7, 1.0}, 0.1); // f_n = 10 N, mu f_n = 1 N, F_tb = 160 N
    double largest = 0; // |f_t| of an intact bond
    for (int k = 0; k < 4000 && farm.measure(0).broken_bonds == 0; ++k) {
        for (const PackedContact& contact : farm.packing(0).contacts)
            if (contact.bonded) largest = std::max(largest, std::abs(contact.tangential_force));
        samples::step(farm, {0, 1e-5, 1e-5, 0}, 1e-5, 1); // pure shear: u_t = gamma/2 |b| at the contacts along x
    }
    CHECK(largest > 159);
    CHECK(largest <= 160);
    const Packing packing = farm.packing(0);
    int broken = 0;
    for (const PackedContact& contact : packing.contacts) {
        if (contact.bonded) continue;
        ++broken;
        CHECK(std::abs(contact.tangential_force) < 1.5); // mu f_n, the overlap along x being what it was to 10 %
    }
    CHECK(broken > 0);
}
