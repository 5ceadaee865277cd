// Bonds of any strength, and all of them failing at once, on every kernel.
#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "tests/hard/every_kernel.hpp"
#include "tests/hard/hard_case.hpp"
#include "tests/hard/rve_figures.hpp"

using namespace talik;
using namespace talik::farm;
using namespace talik::hard;

namespace {

RveParameters bonded(double strength, bool rebond = false) {
    RveParameters p;
    p.bond = BondParameters{strength, strength, 1.0, rebond, 0.5};
    return p;
}

Farm settled(const KernelChoice& kernel, const RveParameters& p, int discs) {
    Farm farm = kernel.farm_of(p, samples::disordered(discs));
    for (int k = 0; k < 30; ++k) samples::step(farm, {0, 0, 0, 0}, 1e-3, 100);
    farm.activate_bonds();
    return farm;
}

// Of the bonds that hold: the largest of tension and shear over the strength that ice leaves.
double largest_load(const Farm& farm, double ice) {
    const AssemblyView& s = farm.assembly(0).view();
    double most = 0;
    for (int c = 0; c < s.contact_count(); ++c) {
        if (!is_bonded(s, c)) continue;
        const double radius = std::min(s.radius[s.first[c]], s.radius[s.second[c]]);
        const double strength = ice * farm.parameters().bond->normal_strength * radius * radius; // N
        const double normal = farm.parameters().contact.normal_stiffness * geometry_of(s, c).overlap;
        most = std::max({most, -normal / strength, std::abs(s.tangential_force[c]) / strength});
    }
    return most;
}

} // namespace

TEST_CASE("bonds of strengths over six decades hold up to their strength and no more", "[hard][rve][bond]") {
    HardCase hard("RVE", "bond strengths 1e3 to 1e9 Pa", "bonds hold beyond their strength, or breaking makes energy");
    const Invariant strength{"largest load of a bond over its strength", 1 + 1e-6, "Eqs. (6), (7): sixteen roundings of single (6e-8)"};
    for (const KernelChoice& kernel : every_kernel())
        for (double c : {1e3, 1e6, 1e9}) {
            Farm farm = settled(kernel, bonded(c), 64);
            const Answer start = farm.measure(0);
            Answer answer;
            for (int k = 0; k < 100; ++k) answer = samples::step(farm, {3e-4, 5e-4, 0, -1e-4}, 1e-3, 100);
            REQUIRE(answer.status == Status::ok);
            const std::string variant = fmt::format("{}, {:g} Pa", kernel.name(), c);
            hard.holds(strength, largest_load(farm, 1), variant);
            hard.holds(closed_ledger, ledger_residual(start, answer), variant);
        }
}

TEST_CASE("all bonds under load failing in one sub-step keep the ledger and throw nothing away", "[hard][rve][bond]") {
    HardCase hard("RVE", "all bonds failing in one step", "the stored tension turns to motion at a blow: discs fly through each other");
    const Invariant motion{"kinetic energy over what the bonds had stored", 1, "energy: nothing else feeds it"};
    const Invariant left{"bonds in tension or shear that still hold without ice", 0, "Eq. (8)"};
    for (const KernelChoice& kernel : every_kernel()) {
        Farm farm = settled(kernel, bonded(1e8), 64);
        for (int k = 0; k < 40; ++k) samples::step(farm, {1e-3, 1e-3, 0, 1e-3}, 1e-3, 100); // pulled by 4 % on all sides
        const Answer start = farm.measure(0);
        REQUIRE(start.bonds > 100);
        Answer answer;
        double most = 0;
        for (int k = 0; k < 100; ++k) {
            answer = samples::step(farm, {0, 0, 0, 0}, 1e-4, 10, 0.0);
            REQUIRE(answer.status == Status::ok);
            most = std::max(most, answer.kinetic_energy);
        }
        hard.holds(motion, most / start.stored_energy, kernel.name());
        hard.holds(left, largest_load(farm, 1) > 0 ? 1 : 0, kernel.name());
        hard.holds(closed_ledger, ledger_residual(start, answer), kernel.name());
    }
}

TEST_CASE("fifty cycles of thaw and frost under shear with bonds that form anew keep the ledger and stay in bounds", "[hard][rve][bond]") {
    HardCase hard("RVE", "50 freeze-thaw cycles under load, with re-bonding", "bonds form in tension, energy is pumped in cycle by cycle");
    const Invariant strength{"largest load of a bond over its strength", 1 + 1e-6, "Eqs. (6), (7): sixteen roundings of single (6e-8)"};
    for (const KernelChoice& kernel : every_kernel()) {
        Farm farm = settled(kernel, bonded(2e6, true), 64);
        for (int k = 0; k < 20; ++k) samples::step(farm, {0, 1e-3, 0, 0}, 1e-3, 100);
        const Answer start = farm.measure(0);
        Answer answer;
        double load = 0, held = 0;
        for (int k = 0; k < 50 * 20; ++k) {
            const double ice = 0.5 + 0.5 * std::cos(2 * M_PI * k / 20.0);
            answer = samples::step(farm, {0, 1e-4, 0, 0}, 1e-3, 50, ice);
            REQUIRE(answer.status == Status::ok);
            if (ice > 0.1) load = std::max(load, largest_load(farm, ice));
            held = std::max(held, held_over_fed(start, answer));
        }
        hard.holds(strength, load, kernel.name());
        hard.holds(first_law, held, kernel.name());
        hard.holds(closed_ledger, ledger_residual(start, answer), kernel.name());
    }
}
