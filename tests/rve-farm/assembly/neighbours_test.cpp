#include "rve-farm/assembly/neighbours.hpp"

#include "tests/support/catch.hpp"
#include "tests/support/rve_samples.hpp"

using namespace talik;
using namespace talik::farm;

TEST_CASE("linked cells find the same candidates in the same order as all pairs of all images", "[neighbours]") {
    for (int discs : {127, 401}) {
        Farm farm(RveParameters{}, {samples::disordered(discs)}, {0, 0});
        for (int k = 0; k < 40; ++k) // also in a skewed cell
            for (int id : {0, 1}) samples::step(farm, {0, 8e-3, 0, 0}, 8e-3, 80, 1, id);
        Assembly &a = farm.assembly(0), &b = farm.assembly(1);
        REQUIRE(rebuild_neighbours(a.view(), a.columns(), Search::linked_cells) == Status::ok);
        REQUIRE(rebuild_neighbours(b.view(), b.columns(), Search::brute_force) == Status::ok);
        CHECK(a.view().contact_count() > discs);
        CHECK(samples::same_bits(farm, 0, farm, 1));
    }
}

TEST_CASE("a rebuild changes nothing that a contact remembers", "[neighbours]") {
    RveParameters parameters;
    parameters.bond = BondParameters{};
    Farm farm(parameters, {samples::disordered(127)}, {0});
    farm.activate_bonds();
    const Answer before = samples::step(farm, {0, 2e-4, 0, 0}, 1e-3);
    Assembly& rve = farm.assembly(0);
    for (int k = 0; k < 3; ++k) REQUIRE(rebuild_neighbours(rve.view(), rve.columns()) == Status::ok);
    const Answer after = farm.measure(0);
    CHECK(after.bonds == before.bonds);
    CHECK(after.contacts == before.contacts);
    CHECK(after.stored_energy == Approx(before.stored_energy).epsilon(1e-14)); // the order of the sum is the same
    CHECK(after.work == Approx(before.work).epsilon(1e-12));                    // booked per slot, then in the totals
    CHECK(after.stress[0] == Approx(before.stress[0]).epsilon(1e-13));
}

TEST_CASE("the skin changes the list, not the response", "[neighbours]") {
    const auto response = [](double skin) {
        RveParameters parameters;
        parameters.skin = skin;
        Farm farm(parameters, {samples::disordered(64)}, {0});
        Answer answer;
        for (int k = 0; k < 100; ++k) answer = samples::step(farm, {0, 5e-4, 0, 0}, 1e-3);
        return std::pair(answer, farm.assembly(0).numbers().rebuilds);
    };
    const auto [narrow, narrow_rebuilds] = response(5e-5);
    const auto [wide, wide_rebuilds] = response(2e-3);
    CHECK(narrow_rebuilds > 2 * wide_rebuilds);
    // 5 % of shear in 10^4 sub-steps: wrapping and reduction at other times differ by rounding, which collisions amplify.
    // A contact that the narrow list had missed would show at once, as 1e-3 and more.
    CHECK(std::abs(narrow.stress[1] - wide.stress[1]) < 1e-5 * samples::mean_pressure(wide));
}

TEST_CASE("a bond is kept in the list however far it has been stretched", "[neighbours][eq6]") {
    RveParameters parameters;
    parameters.bond = BondParameters{1e12, 1e12, 1};
    Farm farm(parameters, {samples::lattice(36, 0.002)}, {0});
    farm.activate_bonds();
    Answer answer;
    for (int k = 0; k < 50; ++k) answer = samples::step(farm, {1e-2, 0, 0, 1e-2}, 1e-2);
    CHECK(answer.bonds == 108);
    CHECK(farm.assembly(0).numbers().rebuilds > 2);
    const double opening = 0.008 * (std::exp(0.5) * (1 - 0.001) - 1); // m, far beyond the skin of 0.6 mm
    CHECK(answer.stored_energy == Approx(108 * 0.5 * 1e6 * opening * opening).epsilon(1e-6));
}
