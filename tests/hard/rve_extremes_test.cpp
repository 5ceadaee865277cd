// RVEs of extreme grains, contacts and numbers, on every kernel.
#include <algorithm>
#include <cmath>

#include "common/physics/clock.hpp"
#include "rve-farm/assembly/stable_step.hpp"
#include "tests/hard/every_kernel.hpp"
#include "tests/hard/hard_case.hpp"
#include "tests/hard/rve_figures.hpp"

using namespace talik;
using namespace talik::farm;
using namespace talik::hard;

namespace {

// Large discs on a lattice of sixteen, a small one of a twentieth of their size in each of its gaps.
Packing one_to_twenty() {
    Packing packing = samples::lattice(16, 0.02);
    const double large = packing.radius.front(), pitch = packing.cell(0, 0) / 4;
    for (int i = 0; i < 16; ++i) {
        packing.x.push_back(packing.x[static_cast<std::size_t>(i)] + pitch / 2);
        packing.y.push_back(packing.y[static_cast<std::size_t>(i)] + pitch / (2 * std::sqrt(3.0)));
        packing.radius.push_back(large / 20);
    }
    return packing;
}

Vector momentum(const Farm& farm) { // kg m/s
    const AssemblyView& s = farm.assembly(0).view();
    Vector sum = Vector::Zero();
    for (int i = 0; i < s.disc_count(); ++i) sum += s.mass[i] * Vector(s.velocity_x[i], s.velocity_y[i]);
    return sum;
}

// 1/2 sum m v^2 of the half step, J: never negative, as the answer's energy at the positions' time may be near the limit.
double moving_energy(const Farm& farm) {
    const AssemblyView& s = farm.assembly(0).view();
    double sum = 0;
    for (int i = 0; i < s.disc_count(); ++i) sum += s.mass[i] * (s.velocity_x[i] * s.velocity_x[i] + s.velocity_y[i] * s.velocity_y[i] + s.spin[i] * s.spin[i] * s.radius[i] * s.radius[i] / 2) / 2;
    return sum;
}

// Of all contacts: the largest |f_t| / f_n.
double mobilised_friction(const Farm& farm) {
    const AssemblyView& s = farm.assembly(0).view();
    double most = 0;
    for (int c = 0; c < s.contact_count(); ++c) {
        const double normal = farm.parameters().contact.normal_stiffness * geometry_of(s, c).overlap;
        if (normal > 0) most = std::max(most, std::abs(s.tangential_force[c]) / normal);
    }
    return most;
}

} // namespace

TEST_CASE("stiffnesses from 1e4 to 6.6e8 N per m give the same stress in their own units", "[hard][rve]") {
    HardCase hard("RVE", "contact stiffness 1e4 to 6.6e8 N/m", "absolute thresholds hidden in the laws, digits lost");
    const Invariant similar{"stress over stiffness against that of 1e4 N/m, relative", 0,
                            "dynamic similarity: time by the root of the stiffness, powers of four are exact in binary"};
    const auto stress_of = [](const KernelChoice& kernel, double by) { // by: a power of four
        RveParameters p;
        p.contact.normal_stiffness = p.contact.tangential_stiffness = 1e4 * by;
        p.time_step = 1e-4 / std::sqrt(by);
        Farm farm = kernel.farm_of(p, samples::disordered(64));
        Answer answer;
        for (int k = 0; k < 30; ++k) answer = samples::step(farm, {-2e-4, 1e-3, 0, 1e-4}, 20 * p.time_step, 20);
        REQUIRE(answer.status == Status::ok);
        for (double& s : answer.stress) s /= by;
        return answer;
    };
    for (const KernelChoice& kernel : every_kernel()) {
        const Answer soft = stress_of(kernel, 1);
        for (double by : {256.0, 65536.0}) hard.holds(similar, difference(stress_of(kernel, by), soft) / samples::mean_pressure(soft), kernel.name());
    }
}

TEST_CASE("a tangential stiffness of a ten thousandth or a hundred times the normal one keeps the ledger", "[hard][rve]") {
    HardCase hard("RVE", "k_t / k_n from 1e-4 to 100", "rotations faster than the step");
    for (const KernelChoice& kernel : every_kernel())
        for (double ratio : {1e-4, 100.0}) {
            RveParameters p;
            p.contact.tangential_stiffness = ratio * p.contact.normal_stiffness;
            p.time_step = ratio > 1 ? 1e-6 : 1e-5;
            Farm farm = kernel.farm_of(p, samples::disordered(64));
            const Answer start = farm.measure(0);
            Answer answer;
            for (int k = 0; k < 50; ++k) answer = samples::step(farm, {-2e-4, 1e-3, 0, 1e-4}, 50 * p.time_step, 50);
            REQUIRE(answer.status == Status::ok);
            hard.holds(closed_ledger, ledger_residual(start, answer), kernel.name() + (ratio > 1 ? ", 100" : ", 1e-4"));
        }
}

TEST_CASE("radii of one to twenty keep momentum and ledger", "[hard][rve]") {
    HardCase hard("RVE", "radii 1 : 20", "small discs outrun the list, are lost between large ones or overrun the list's room");
    const Invariant drift{"momentum gathered, of the discs' |momentum|", rounding_walk(unit_double, 7500), "action and reaction: a walk of 7,500 roundings (1e-16)"};
    const Invariant drift_single{"momentum gathered in single, of the discs' |momentum|", rounding_walk(unit_single, 7500), "action and reaction: a walk of 7,500 roundings of single (6e-8)"};
    for (const KernelChoice& kernel : every_kernel()) {
        RveParameters p;
        p.time_step = 2e-6;
        p.damping = 0; // which brakes single discs and so takes momentum
        Farm farm = kernel.farm_of(p, one_to_twenty());
        const Answer start = farm.measure(0);
        Answer answer;
        for (int k = 0; k < 150; ++k) {
            answer = samples::step(farm, {-4e-4, 2e-3, 0, 2e-4}, 1e-4, 50);
            REQUIRE(answer.status == Status::ok);
        }
        const AssemblyView& s = farm.assembly(0).view();
        double size = 0;
        for (int i = 0; i < s.disc_count(); ++i) size += s.mass[i] * std::hypot(s.velocity_x[i], s.velocity_y[i]);
        hard.holds(kernel.single() ? drift_single : drift, momentum(farm).norm() / size, kernel.name());
        hard.holds(closed_ledger, ledger_residual(start, answer), kernel.name());
    }
}

TEST_CASE("without friction nothing slips at a price and with a friction of 2 no contact holds more", "[hard][rve]") {
    HardCase hard("RVE", "friction 0 and 2", "0 / 0 at the limit, or a limit that is not kept");
    const Invariant free{"energy lost by friction where there is none, J", 0, "mu = 0"};
    const Invariant limit{"largest |f_t| / f_n of a contact over mu = 2, less 1", 4 * unit_single, "Coulomb: overlap, stiffness, friction and force are rounded to single (6e-8)"};
    for (const KernelChoice& kernel : every_kernel())
        for (double friction : {0.0, 2.0}) {
            RveParameters p;
            p.contact.friction = friction;
            Farm farm = kernel.farm_of(p, samples::disordered(64));
            const Answer start = farm.measure(0);
            Answer answer;
            for (int k = 0; k < 100; ++k) answer = samples::step(farm, {-1e-4, 2e-3, 0, 1e-4}, 1e-3, 100);
            REQUIRE(answer.status == Status::ok);
            if (friction == 0.0) hard.holds(free, answer.friction_dissipation, kernel.name());
            if (friction > 0.0) hard.holds(limit, mobilised_friction(farm) / friction - 1, kernel.name());
            hard.holds(closed_ledger, ledger_residual(start, answer), kernel.name());
        }
}

TEST_CASE("one two three and two thousand discs are sheared alike", "[hard][rve]") {
    HardCase hard("RVE", "1, 2, 3 and 2,000 discs", "a disc that meets its own images, empty lanes, lists that overflow");
    for (const KernelChoice& kernel : every_kernel())
        for (int discs : {1, 2, 3, 2000}) {
            Farm farm = kernel.farm_of(RveParameters(), samples::disordered(discs));
            const Answer start = farm.measure(0);
            Answer answer;
            for (int k = 0; k < (discs > 3 ? 10 : 100); ++k) {
                answer = samples::step(farm, {-2e-4, 5e-3, 0, 1e-4}, 1e-3, 50);
                REQUIRE(answer.status == Status::ok);
            }
            hard.holds(closed_ledger, ledger_residual(start, answer), kernel.name() + ", " + std::to_string(discs));
        }
}

TEST_CASE("strong damping at 0.99 of the largest step brings a shaken heap to rest", "[hard][rve]") {
    HardCase hard("RVE", "damping 0.9 at 0.99 of the largest step", "damping taken from the old velocity pumps energy in");
    const Invariant gain{"energy above that of the start, relative", 1e-3, "damping only takes; to the ledger's 1e-3"};
    for (const KernelChoice& kernel : every_kernel()) {
        RveParameters p;
        p.damping = 0.9;
        const Packing packing = samples::disordered(64);
        p.time_step = 0.99 * kernel.farm_of(p, packing).largest_stable_step(0) / shortening_by_damping(p.damping);
        Farm farm = kernel.farm_of(p, packing);
        const auto energy = [](const Answer& a) { return a.kinetic_energy + a.stored_energy; };
        const Answer start = farm.measure(0);
        Answer answer;
        double most = energy(start);
        for (int k = 0; k < 200; ++k) {
            answer = samples::step(farm, {0, 0, 0, 0}, 100 * p.time_step, 100);
            REQUIRE(answer.status == Status::ok);
            most = std::max(most, energy(answer));
        }
        hard.holds(at_rest, moving_energy(farm) / answer.stored_energy, kernel.name());
        hard.holds(gain, most / energy(start) - 1, kernel.name());
    }
}

namespace {

// The stress of a heap that rests, watched over sub-steps: its largest change, of the pressure.
double drift_at_rest(const KernelChoice& kernel, int macro_steps) {
    RveParameters p;
    p.damping = 0.7;
    Farm farm = kernel.farm_of(p, samples::disordered(16));
    Answer start;
    for (int k = 0; k < 500; ++k) start = samples::step(farm, {0, 0, 0, 0}, 1e-3, 100);
    double drift = 0;
    for (int k = 0; k < macro_steps; ++k) drift = std::max(drift, difference(samples::step(farm, {0, 0, 0, 0}, 1e-3, 100), start));
    return drift / samples::mean_pressure(start);
}

void check_rest(int macro_steps, const char* name) {
    HardCase hard("RVE", name, "rounding that adds up: positions creep, tangential forces leak");
    const Invariant still{"change of stress, of the pressure", 1e-12, "at rest nothing adds up: positions of 0.03 m known to 3e-18 m, overlaps of 4e-5 m to 1e-13, those of a disc's contacts"};
    const Invariant still_single{"change of stress in single, of the pressure", 4 * unit_single, "rounding of single (6e-8) of the forces of a disc's four contacts"};
    for (const KernelChoice& kernel : every_kernel()) hard.holds(kernel.single() ? still_single : still, drift_at_rest(kernel, macro_steps), kernel.name());
}

} // namespace

TEST_CASE("a heap at rest keeps its stress over a hundred thousand sub-steps", "[hard][rve]") { check_rest(1000, "1e5 sub-steps at rest"); }
TEST_CASE("a heap at rest keeps its stress over a million sub-steps", "[hard][rve][long]") { check_rest(10000, "1e6 sub-steps at rest"); }
