#include "rve-farm/kernel/macro_step.hpp"

#include "tests/support/catch.hpp"
#include "tests/support/rve_samples.hpp"

using namespace talik;
using namespace talik::farm;

namespace {

// The best kernel, watched: how many sub-steps it has run, and beyond which length of a chunk it claims to have exploded.
std::int64_t substeps_run = 0;
int longest_sound_chunk = 0;

template <Precision precision>
const Kernel& watched() {
    static const Kernel watched_kernel = [] {
        Kernel k = kernel(best_level(), precision);
        k.run = [](const RveParameters& p, const ChunkRequest& request, AssemblyView& s, const ColumnChoice& columns, const SlotLayout& layout, WorkMemory& memory) {
            substeps_run += request.substeps;
            if (request.substeps <= longest_sound_chunk) return kernel(best_level(), precision).run(p, request, s, columns, layout, memory);
            ChunkOutcome outcome;
            outcome.finite = false;
            return outcome;
        };
        return k;
    }();
    return watched_kernel;
}

MacroStep shear(double rate, int substeps) {
    const double dt = 1e-5 * substeps, strain = rate * dt;
    return {strain / 2, strain / 3, 0, -strain / 2, dt, substeps, 1};
}

} // namespace

TEST_CASE("of long macro steps few sub-steps are run in vain", "[kernel][chunks]") {
    longest_sound_chunk = 1000000;
    for (const Kernel* k : {&watched<Precision::single_>(), &watched<Precision::double_>()})
        for (double rate : {1e-3, 1e-1, 1.0}) // 1/s
            for (int substeps : {100, 1000, 10000}) {
                const RveParameters p;
                Assembly rve(p, samples::disordered(127));
                const Stepper stepper{p, k, false, {}};
                REQUIRE(advance(stepper, rve, shear(rate, 2000)).status == Status::ok); // the heap comes to rest
                substeps_run = 0;
                for (int done = 0; done < 10000; done += substeps) REQUIRE(advance(stepper, rve, shear(rate, substeps)).status == Status::ok);
                INFO(name_of(k->precision) << ", " << rate << " 1/s, " << substeps << " sub-steps");
                CHECK(static_cast<double>(substeps_run) < 1.25 * 10000); // where chunks did not look ahead: up to 4 times
            }
}

TEST_CASE("a chunk that explodes for its length alone is taken in shorter ones and what explodes in a single sub-step is a fault", "[kernel][chunks][status]") {
    const RveParameters p;
    Assembly rve(p, samples::disordered(64));
    const Stepper stepper{p, &watched<Precision::double_>(), false, {}};
    longest_sound_chunk = 7;
    CHECK(advance(stepper, rve, shear(0.1, 100)).status == Status::ok);
    longest_sound_chunk = 0;
    CHECK(advance(stepper, rve, shear(0.1, 100)).status == Status::not_finite);
}

TEST_CASE("bonds without force balance: the unbalanced force is zero and not 0 / 0", "[kernel][bond]") {
    Packing touching; // powers of two: the overlap is zero in bits
    touching.cell << 1, 0, 0, 1;
    touching.x = {0.25, 0.5};
    touching.y = {0.5, 0.5};
    touching.radius = {0.125, 0.125};
    touching.contacts.push_back({0, 1, {0, 0}, 0, true});
    RveParameters p;
    p.bond = BondParameters{};
    Farm farm(p, {touching}, {0});
    CHECK(farm.measure(0).contacts == 1);
    CHECK(farm.measure(0).unbalanced_force == 0);
    CHECK(samples::step(farm, {0, 0, 0, 0}, 1e-3).unbalanced_force == 0);
}
