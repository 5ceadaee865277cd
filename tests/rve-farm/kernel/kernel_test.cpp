#include "rve-farm/kernel/kernel.hpp"

#include <cmath>
#include <cstdlib>
#include <new>

#include "rve-farm/assembly/neighbours.hpp"
#include "tests/reference/naive_rve.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/rve_samples.hpp"

using namespace talik;
using namespace talik::farm;

namespace {

const std::vector<int> sizes = {1, 31, 33, 127, 400, 401, 2000};

struct Choice {
    Level level;
    Precision precision;
    std::string name() const { return std::string(name_of(level)) + " " + name_of(precision); }
};

std::vector<Choice> choices() {
    std::vector<Choice> all;
    for (Level level : levels_of_this_machine())
        for (Precision precision : {Precision::single_, Precision::double_}) all.push_back({level, precision});
    return all;
}

RveParameters parameters(bool bonds, bool fluctuation, double damping = 0.2) {
    RveParameters p;
    p.damping = damping;
    p.fluctuation_stress = fluctuation;
    if (bonds) p.bond = BondParameters{2e6, 2e6, 1.0}; // weak: some break on the way
    return p;
}

Farm farm_of(const Choice& choice, const RveParameters& p, const Packing& packing) {
    FarmOptions options;
    options.level = choice.level;
    options.precision = choice.precision;
    Farm farm(p, {packing}, {0}, options);
    if (p.bond) farm.activate_bonds();
    return farm;
}

// The difference in stress over the first pressure: in double after 150 sub-steps of a heap that is far from rest, where
// contacts that open and slide amplify rounding; in single of each macro step from the same state. (A contact that closes one
// sub-step later misses k_t times the slip of that sub-step, 0.03 N or 0.1 Pa of 3e5 Pa at this rate.)
double tolerance(Precision precision) { return precision == Precision::double_ ? 1e-11 : 1e-6; }

double difference(const Answer& a, const Answer& b) {
    double largest = 0;
    for (std::size_t k = 0; k < 3; ++k) largest = std::max(largest, std::abs(a.stress[k] - b.stress[k]));
    return largest;
}

[[maybe_unused]] std::size_t allocations = 0; // of this program, counted below

} // namespace

// Address sanitizers bring their own new and delete, and check that they match.
#if !defined(__SANITIZE_ADDRESS__)
[[gnu::noinline]] void* operator new(std::size_t size) {
    ++allocations;
    if (void* memory = std::malloc(size ? size : 1)) return memory;
    throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
#endif

TEST_CASE("every level and precision gives the stress of the plain kernel, at every size and with every effect", "[kernel][eq5][eq49]") {
    for (int discs : sizes)
        for (bool bonds : {false, true})
            for (bool fluctuation : {false, true}) {
                const Packing packing = samples::disordered(discs);
                const RveParameters p = parameters(bonds, fluctuation);
                Farm plain = farm_of({Level::plain, Precision::double_}, p, packing);
                const double pressure = std::abs(samples::mean_pressure(plain.measure(0))) + 1e3; // one disc alone has none
                std::vector<Answer> expected;
                std::vector<std::vector<std::byte>> states(3);
                for (int k = 0; k < 3; ++k) {
                    plain.save(0, states[static_cast<std::size_t>(k)]);
                    expected.push_back(samples::step(plain, {-5e-5, 2e-4, -1e-4, 3e-5}, 5e-4, 50));
                }
                for (const Choice& choice : choices()) {
                    Farm farm = farm_of(choice, p, packing);
                    for (int k = 0; k < 3; ++k) {
                        if (choice.precision == Precision::single_) farm.load(0, states[static_cast<std::size_t>(k)]); // each step for itself
                        const Answer answer = samples::step(farm, {-5e-5, 2e-4, -1e-4, 3e-5}, 5e-4, 50);
                        INFO(choice.name() << ", " << discs << " discs, bonds " << bonds << ", fluctuation " << fluctuation << ", step " << k);
                        REQUIRE(answer.status == Status::ok);
                        CHECK(difference(answer, expected[static_cast<std::size_t>(k)]) < tolerance(choice.precision) * pressure);
                        CHECK(answer.bonds == expected[static_cast<std::size_t>(k)].bonds);
                    }
                }
            }
}

TEST_CASE("every level in double follows an RVE written from the equations alone, energies and bonds included", "[kernel][eq5][eq6][eq49]") {
    for (Level level : levels_of_this_machine())
        for (bool bonds : {false, true}) {
            const Packing packing = samples::disordered(33);
            const RveParameters p = parameters(bonds, false);
            Farm farm = farm_of({level, Precision::double_}, p, packing);
            reference::NaiveRve naive(p, packing);
            if (bonds) naive.bond_all();
            Matrix gradient;
            gradient << 2e-4, 2e-3, -1e-3, 2e-4;
            const Answer start = farm.measure(0);
            const double scale = 1e-10 * samples::mean_pressure(start), energy = scale * start.cell_area * p.thickness; // as in reference_test.cpp
            for (int k = 0; k < 10; ++k) {
                naive.advance(gradient, 2e-4, 20);
                const Answer answer = samples::step(farm, {2e-4, 2e-3, -1e-3, 2e-4}, 2e-4, 20);
                const Matrix stress = naive.stress();
                INFO(name_of(level) << ", bonds " << bonds << ", macro step " << k);
                CHECK(std::abs(answer.stress[0] - stress(0, 0)) < scale);
                CHECK(std::abs(answer.stress[1] - stress(1, 1)) < scale);
                CHECK(std::abs(answer.stress[2] - stress(0, 1)) < scale);
                CHECK(std::abs(answer.work - naive.work) < energy);
                CHECK(std::abs(answer.friction_dissipation - naive.friction_dissipation) < energy);
                CHECK(std::abs(answer.damping_dissipation - naive.damping_dissipation) < energy);
                CHECK(std::abs(answer.bond_dissipation - naive.bond_dissipation) < energy);
                CHECK(answer.bonds == naive.bonds());
            }
        }
}

TEST_CASE("on the slots of any level the lanes and a scrambled team do the same", "[kernel][team]") {
    for (const Choice& choice : choices())
        for (int discs : {1, 33, 400}) {
            const Kernel& k = kernel(choice.level, choice.precision);
            const RveParameters p = parameters(true, true);
            Assembly lanes(p, samples::disordered(discs)), team(p, samples::disordered(discs));
            for (Assembly* rve : {&lanes, &team}) rve->layout().update(rve->view(), k.shape);
            ChunkRequest request;
            request.stretch = stretch_of(-1e-5, 4e-5, -2e-5, 1e-5, 0);
            request.substeps = 20;
            request.sub_step = request.first_kick = 1e-5;
            request.displacement_allowed = 1;
            WorkMemory memory;
            const ChunkOutcome a = k.run(p, request, lanes.view(), lanes.columns(), lanes.layout(), memory);
            const ChunkOutcome b = run_shuffled(7, choice.precision, p, request, team.view(), team.columns(), team.layout(), memory);
            INFO(choice.name() << ", " << discs << " discs");
            REQUIRE((a.accepted && b.accepted));
            const double pressure = std::abs(samples::mean_pressure(b.answer)) + 1e3;
            CHECK(difference(a.answer, b.answer) < (choice.precision == Precision::double_ ? 1e-12 : 1e-6) * pressure);
            CHECK(a.answer.work == Approx(b.answer.work).epsilon(1e-5).margin(1e-12));
            CHECK(a.answer.friction_dissipation == Approx(b.answer.friction_dissipation).epsilon(1e-4).margin(1e-12));
        }
}

TEST_CASE("planted faults are caught: a partner exchanged, a force row misplaced, a contact left out of the list", "[kernel][planted]") {
    const Kernel& k = kernel(best_level(), Precision::double_);
    const RveParameters p = parameters(false, false);
    ChunkRequest request;
    request.stretch = stretch_of(-1e-5, 4e-5, -2e-5, 1e-5, 0);
    request.substeps = 20;
    request.sub_step = request.first_kick = 1e-5;
    request.displacement_allowed = 1;
    const auto run = [&](auto&& spoil) {
        Assembly rve(p, samples::disordered(127));
        rve.layout().update(rve.view(), k.shape);
        spoil(rve);
        WorkMemory memory;
        return k.run(p, request, rve.view(), rve.columns(), rve.layout(), memory).answer;
    };
    const Answer sound = run([](Assembly&) {});
    const double noticed = 1e-6 * samples::mean_pressure(sound); // a hundred thousand times what the comparisons above allow
    CHECK(difference(sound, run([](Assembly& rve) { std::swap(rve.layout().partner[0], rve.layout().partner[1]); })) > noticed);
    CHECK(difference(sound, run([](Assembly& rve) { std::swap(rve.layout().incoming_of_sets[0], rve.layout().incoming_of_sets[9]); })) > noticed);
    CHECK(difference(sound, run([](Assembly& rve) {
                         AssemblyView& s = rve.view();
                         --s.numbers->contact_count; // the last one of the list
                         rve.layout().forget();
                         rve.layout().update(s, rve.layout().shape);
                     })) > noticed);
}

TEST_CASE("a disc that outruns the list makes the chunk be taken again on a fresh one, with the response of a wide list", "[kernel][neighbours]") {
    const auto thrown = [](double skin, Level level) {
        RveParameters p;
        p.skin = skin;
        Farm farm = farm_of({level, Precision::double_}, p, samples::disordered(64));
        farm.assembly(0).view().velocity_x[5] = 1.0; // m/s: 1 mm in the macro step
        const Answer answer = samples::step(farm, {0, 0, 0, 0}, 1e-3, 100);
        return std::pair(answer, farm.assembly(0).numbers());
    };
    for (Level level : levels_of_this_machine()) {
        const auto [narrow, numbers] = thrown(5e-5, level);
        const auto [wide, others] = thrown(3e-3, level);
        INFO(name_of(level));
        CHECK(numbers.rebuilds > others.rebuilds + 2);
        CHECK(numbers.retaken_chunks > 0);
        CHECK(difference(narrow, wide) < 1e-9 * samples::mean_pressure(wide)); // a missed contact would show as 1e-3 and more
    }
}

#if !defined(__SANITIZE_ADDRESS__)
TEST_CASE("nothing is allocated in a macro step once the thread has met the RVE", "[kernel]") {
    for (const Choice& choice : choices()) {
        Farm farm = farm_of(choice, parameters(true, true), samples::disordered(127));
        const std::array<double, 4> increment = {0, 1e-3, 0, 0};
        const std::uint32_t id = 0;
        const double ice = 1;
        Answer answer;
        const auto step = [&] { farm.advance(std::span(&id, 1), increment, std::span(&ice, 1), 1e-3, 100, std::span(&answer, 1)); };
        for (int k = 0; k < 30; ++k) step(); // rebuilds among them
        const std::size_t before = allocations;
        for (int k = 0; k < 5; ++k) step();
        const std::size_t in_steps = allocations - before;
        INFO(choice.name());
        CHECK(in_steps == 0);
    }
}
#endif
