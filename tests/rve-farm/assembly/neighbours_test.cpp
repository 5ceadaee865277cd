#include "rve-farm/assembly/neighbours.hpp"

#include "common/base/error.hpp"
#include "rve-farm/kernel/macro_step.hpp"
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
        for (int k = 0; k < 40; ++k) answer = samples::step(farm, {0, 5e-4, 0, 0}, 1e-3);
        return std::pair(answer, farm.assembly(0).numbers().rebuilds);
    };
    const auto [narrow, narrow_rebuilds] = response(5e-5);
    const auto [wide, wide_rebuilds] = response(2e-3);
    CHECK(narrow_rebuilds > 2 * wide_rebuilds);
    // 2 % of shear in 4000 sub-steps: chunks, wrapping and reduction at other times differ by rounding, which collisions amplify
    // (1e-9 to 3e-7 of the pressure here, 1e-5 and more at 5 %).
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

TEST_CASE("small discs crowded among large ones get the widest skin that there is room for", "[neighbours]") {
    // 200 discs of 20 mm, apart; 200 of 0.5 mm on a tight lattice: within the widest skin, 0.3 mean radii = 3 mm, each of
    // these has some forty neighbours, and the room is for under ten.
    Packing packing;
    packing.cell << 0.88, 0, 0, 0.52;
    for (int i = 0; i < 200; ++i) {
        packing.x.push_back(0.044 * (i % 20));
        packing.y.push_back(0.044 * (i / 20));
        packing.radius.push_back(0.020);
        packing.x.push_back(0.1 + 0.001 * (i % 20));
        packing.y.push_back(0.45 + 0.001 * (i / 20));
        packing.radius.push_back(0.0005);
    }
    RveParameters parameters;
    parameters.time_step = 1e-7; // s; the smallest are light
    Farm farm(parameters, {packing}, {0});
    Assembly& rve = farm.assembly(0);
    AssemblyNumbers& n = *rve.view().numbers;
    n.skin = n.widest_skin;
    REQUIRE(rebuild_neighbours(rve.view(), rve.columns()) == Status::ok);
    CHECK(n.contact_count <= n.contact_capacity);
    CHECK(n.skin < n.widest_skin);
    CHECK(n.skin > n.narrowest_skin);
    CHECK(samples::step(farm, {1e-4, 0, 0, 0}, 1e-5).status == Status::ok);
}

TEST_CASE("a list that there is no room for leaves the skin of the one that stays", "[neighbours]") {
    Farm farm(RveParameters{}, {samples::disordered(127)}, {0});
    Assembly& rve = farm.assembly(0);
    AssemblyNumbers& n = *rve.view().numbers;
    samples::step(farm, {1e-3, 0, 0, 0}, 1e-3); // not at rest: a rebuild would choose a wider skin
    const double skin = n.skin = 0.1 * n.mean_radius;
    const std::int64_t room = n.contact_capacity;
    n.contact_capacity = 10;
    CHECK(rebuild_neighbours(rve.view(), rve.columns()) == Status::contact_list_full);
    n.contact_capacity = room;
    CHECK(n.skin == skin);
}

TEST_CASE("after a list that there was no room for, the one that stays is walked with the images that the discs now have", "[neighbours]") {
    const auto stress = [](bool rebuild_in_vain) {
        Farm farm(RveParameters{}, {samples::disordered(127)}, {0});
        samples::step(farm, {1e-4, 0, 0, 0}, 1e-3);
        Assembly& rve = farm.assembly(0);
        AssemblyView& s = rve.view();
        s.x[0] += s.numbers->cell_xx, s.y[0] += s.numbers->cell_yx; // the same disc, seen a cell further on: a rebuild wraps it
        for (int c = 0; c < s.contact_count(); ++c) s.image_x[c] += (s.first[c] == 0) - (s.second[c] == 0);
        rve.layout().forget();
        samples::step(farm, {1e-5, 0, 0, 0}, 1e-4);
        if (rebuild_in_vain) {
            const std::int64_t room = s.numbers->contact_capacity;
            s.numbers->contact_capacity = 10;
            CHECK(make_list(rve, rve.layout().shape) == Status::contact_list_full);
            s.numbers->contact_capacity = room;
        }
        return samples::step(farm, {1e-5, 0, 0, 0}, 1e-4);
    };
    const Answer stays = stress(false), wrapped = stress(true);
    REQUIRE(stays.status == Status::ok);
    for (int k = 0; k < 3; ++k) CHECK(std::abs(wrapped.stress[k] - stays.stress[k]) < 1e-9 * samples::mean_pressure(stays)); // a rounding of one position
}

TEST_CASE("a skin many times as wide as the discs is refused", "[neighbours]") {
    RveParameters parameters;
    parameters.skin = 1.0; // m, of discs of 4 mm
    CHECK_THROWS_AS(Farm(parameters, {samples::disordered(64)}, {0}), Error);
}
