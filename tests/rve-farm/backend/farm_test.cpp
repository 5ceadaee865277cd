#include "rve-farm/backend/farm.hpp"

#include "common/base/error.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/rve_samples.hpp"

using namespace talik;
using namespace talik::farm;

namespace {

const std::vector<int> sizes = {1, 2, 31, 33, 127, 400, 401};

std::vector<Packing> packings() {
    std::vector<Packing> all;
    for (int discs : sizes) all.push_back(samples::disordered(discs));
    return all;
}

// A farm of all sizes after some macro steps of compression, shear and rotation, with bonds that break.
Farm driven(FarmOptions options, bool bonds, bool fluctuation) {
    RveParameters parameters;
    if (bonds) parameters.bond = BondParameters{3e6, 3e6, 1};
    parameters.fluctuation_stress = fluctuation;
    std::vector<int> table;
    for (int k = 0; k < static_cast<int>(sizes.size()); ++k) table.push_back(k);
    Farm farm(parameters, packings(), table, std::move(options));
    if (bonds) farm.activate_bonds();
    std::vector<std::uint32_t> ids;
    std::vector<double> increments, ice;
    for (std::uint32_t id = 0; id < sizes.size(); ++id) {
        ids.push_back(id);
        for (double g : {-1e-3, 3e-3, -1e-3, 5e-4}) increments.push_back(g * (1 + 0.1 * id));
        ice.push_back(1 - 0.05 * id);
    }
    std::vector<Answer> answers(ids.size());
    for (int k = 0; k < 12; ++k) farm.advance(ids, increments, ice, 1e-3, 50, answers);
    for (const Answer& answer : answers) REQUIRE(answer.status == Status::ok);
    CHECK(farm.rves_done() == 12 * sizes.size());
    return farm;
}

void check_same(const Farm& a, const Farm& b) {
    for (int id = 0; id < a.size(); ++id) {
        INFO(sizes[static_cast<std::size_t>(id)] << " discs");
        CHECK(samples::same_bits(a, id, b, id));
    }
}

} // namespace

TEST_CASE("one thread and two give the same bits, at every size", "[team]") {
    FarmOptions one, two;
    one.threads = 1, two.threads = 2;
    check_same(driven(one, true, false), driven(two, true, false));
}

TEST_CASE("phases visited in scrambled order give the same bits, at every size and with every effect", "[team]") {
    for (bool bonds : {false, true})
        for (bool fluctuation : {false, true}) {
            FarmOptions shuffled;
            shuffled.shuffle_seed = 42;
            FarmOptions plain;
            plain.level = Level::plain;
            for (Precision precision : {Precision::single_, Precision::double_}) {
                plain.precision = shuffled.precision = precision;
                check_same(driven(plain, bonds, fluctuation), driven(shuffled, bonds, fluctuation));
            }
        }
}

TEST_CASE("a saved RVE goes on with the same bits, in another farm too", "[checkpoint]") {
    Farm farm = driven({}, true, true), other = driven({}, true, true);
    for (int id = 0; id < farm.size(); ++id) {
        std::vector<std::byte> bytes;
        farm.save(id, bytes);
        const Answer first = samples::step(farm, {1e-3, 2e-3, 0, -1e-3}, 1e-3, 50, 1, id);
        for (int k = 0; k < 5; ++k) samples::step(other, {-1e-3, 0, 0, 0}, 1e-3, 50, 1, id); // elsewhere
        CHECK(other.load(id, bytes) == bytes.size());
        const Answer second = samples::step(other, {1e-3, 2e-3, 0, -1e-3}, 1e-3, 50, 1, id);
        CHECK(first.stress == second.stress);
        CHECK(samples::same_bits(farm, id, other, id));
        CHECK_THROWS_AS(other.load(id, std::span(bytes).first(bytes.size() - 1)), Error); // cut short
    }
}

TEST_CASE("a packing taken out of an RVE and put into another has the same stress, contacts and bonds", "[packing]") {
    const Farm farm = driven({}, true, false);
    RveParameters parameters = farm.parameters();
    for (int id = 0; id < farm.size(); ++id) {
        const Answer before = farm.measure(id), after = Farm(parameters, {farm.packing(id)}, {0}).measure(0);
        CHECK(after.contacts == before.contacts);
        CHECK(after.bonds == before.bonds);
        // Positions turned into fixed axes and back: 1e-17 m of overlaps of 1e-4 m.
        for (std::size_t k = 0; k < 3; ++k)
            CHECK(std::abs(after.stress[k] - before.stress[k]) < 1e-11 * (std::abs(samples::mean_pressure(before)) + 1e5));
    }
}

TEST_CASE("any subset of the RVEs may be advanced, and the others stay as they are", "[subset]") {
    RveParameters parameters;
    Farm farm(parameters, {samples::disordered(31)}, {0, 0, 0}), alone(parameters, {samples::disordered(31)}, {0});
    const std::vector<std::uint32_t> ids = {2, 0};
    const std::vector<double> increments = {1e-4, 0, 0, 0, 0, 2e-4, 0, 0};
    std::vector<Answer> answers(2);
    farm.advance(ids, increments, {}, 1e-3, 0, answers);
    CHECK(samples::same_bits(farm, 1, alone, 0));
    CHECK(samples::step(alone, {1e-4, 0, 0, 0}, 1e-3).stress == answers[0].stress);
    const Answer now = farm.measure(0);
    for (std::size_t k = 0; k < 3; ++k) // from the positions, not from what has moved since: the rounding of an overlap
        CHECK(std::abs(now.stress[k] - answers[1].stress[k]) < 1e-12 * samples::mean_pressure(now));
}

TEST_CASE("no sub-steps given: as many as the time step of the parameters needs", "[clock]") {
    RveParameters parameters; // 1e-5 s
    Farm automatic(parameters, {samples::disordered(31)}, {0}), explicitly(parameters, {samples::disordered(31)}, {0});
    CHECK(samples::step(automatic, {1e-4, 0, 0, 0}, 1e-3).stress == samples::step(explicitly, {1e-4, 0, 0, 0}, 1e-3, 100).stress);
    CHECK(samples::step(automatic, {1e-4, 0, 0, 0}, 1.01e-3).stress ==
          samples::step(explicitly, {1e-4, 0, 0, 0}, 1.01e-3, 101).stress);
}

TEST_CASE("a packing made for other discs, or malformed, is refused with a remedy", "[fault]") {
    RveParameters parameters;
    Packing packing = samples::lattice(4, 0.02);
    packing.thickness = 1.0;
    CHECK_THROWS_AS(Farm(parameters, {packing}, {0}), Error);
    packing = samples::lattice(4, 0.02);
    packing.radius[2] = -1;
    CHECK_THROWS_AS(Farm(parameters, {packing}, {0}), Error);
    packing = samples::lattice(4, 0.02);
    packing.contacts.push_back({0, 9, {0, 0}, 0.0, false});
    CHECK_THROWS_AS(Farm(parameters, {packing}, {0}), Error);
    packing = samples::lattice(4, 0.02);
    CHECK_THROWS_AS(Farm(parameters, {packing}, {1}), Error);
    CHECK_THROWS_AS(Farm(parameters, {packing}, {0}).activate_bonds(), Error); // no [bond] in the parameters
}
