// Steps just below and just above each limit, stiffness that rises during the run, and what a removed safeguard lets happen.
#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "common/physics/clock.hpp"
#include "rve-farm/assembly/stable_step.hpp"
#include "tests/hard/every_kernel.hpp"
#include "tests/hard/hard_case.hpp"
#include "tests/hard/rve_figures.hpp"
#include "tests/mpm-driver/fault_text.hpp"
#include "tests/mpm-driver/heat/small_heat.hpp"

using namespace talik;
using namespace talik::hard;
using namespace talik::driver;
using namespace talik::driver::tests;
using farm::Answer;
using farm::Status;

namespace {

const Invariant no_rise{"energy gained, relative", rounding_walk(unit_single, 2000), "leapfrog keeps v^2 + w^2 (1 - (w dt/2)^2) x^2 of each mode, so none rises above its start from rest; rounding of single in 2,000 sub-steps"};
const Invariant no_growth{"energy gained beyond its swing in the last step, relative", 0, "FLIP's transfer takes, the step keeps H + dt/2 dK/dt; an unstable mode grows by orders of magnitude"};
const Invariant refused{"steps at 1.01 of the limit that were taken", 0, "the limit"};

RveParameters sound(RveParameters p, double limit) {
    p.time_step = limit / 4;
    return p;
}

// Straight to the kernel, past every check of macro_step.cpp: one chunk, however far discs go. False where it is no number.
bool unchecked(const KernelChoice& kernel, const RveParameters& p, farm::Assembly& rve, const farm::Stretch& stretch, double sub_step, int substeps, Answer& answer) {
    const farm::Kernel& k = farm::kernel(kernel.level, kernel.precision);
    const farm::Stepper stepper{p, &k, true, {}};
    rve.layout().update(rve.view(), k.shape);
    farm::ChunkRequest request;
    request.stretch = stretch;
    request.substeps = substeps;
    request.sub_step = request.first_kick = sub_step;
    request.displacement_allowed = 1;
    const farm::ChunkOutcome outcome = stepper.run(request, rve.view(), rve.columns(), rve.layout());
    answer = outcome.answer;
    return outcome.accepted && answer.status == Status::ok;
}

// Energy of an undamped lattice of discs that never slide, moved a little, after 2,000 sub-steps over that at the start.
double disc_growth(const KernelChoice& kernel, double part_of_limit, bool checked) {
    RveParameters p;
    p.damping = 0;
    p.contact.friction = 1e9;
    Packing packing = farm::samples::lattice(36, 0.04, 0, 0.002, 3);
    const double limit = kernel.farm_of(p, packing).largest_stable_step(0);
    p.time_step = part_of_limit * limit;
    const Answer start = kernel.farm_of(sound(p, limit), packing).measure(0);
    Answer answer;
    if (checked) {
        farm::Farm rve = kernel.farm_of(p, packing);
        for (int k = 0; k < 20; ++k) answer = farm::samples::step(rve, {0, 0, 0, 0}, 100 * p.time_step, 100);
    } else {
        farm::Assembly rve(p, packing);
        for (int k = 0; k < 100; ++k)
            if (!unchecked(kernel, p, rve, {}, p.time_step, 20, answer)) return HUGE_VAL; // flew apart
    }
    return (answer.kinetic_energy + answer.stored_energy) / (start.kinetic_energy + start.stored_energy) - 1;
}

// A free body cut anywhere, with noise: its energy after so many steps of a part of the safe one over that at the start.
double body_growth(int per_cell, double corner, double part_of_safe) {
    Scene scene = elastic_scene(box({corner, corner}, {corner + 0.6, corner + 0.4}, per_cell), {0, 0}, {1.4, 1.2});
    auto simulation = start(scene);
    const double step = part_of_safe * simulation->stable_step().safe_step;
    scene.step.fixed = step;
    simulation = start(scene);
    Points& points = simulation->points();
    double before = 0.0;
    for (std::size_t p = 0; p < points.count(); ++p) {
        points.velocity[p] = 1e-6 * Vector(std::sin(37.0 * static_cast<double>(p)), std::cos(53.0 * static_cast<double>(p)));
        before += 0.5 * points.mass[p] * points.velocity[p].squaredNorm();
    }
    const Ledger& ledger = simulation->ledger();
    double swing = 0.0; // J: half of what the kinetic energy changes by in a step
    try {
        for (int k = 0; k < 1500; ++k) {
            const double last = ledger.kinetic;
            simulation->step(step);
            swing = 0.5 * std::abs(ledger.kinetic - last);
        }
    } catch (const Error&) {
        return HUGE_VAL;
    }
    return (ledger.kinetic + ledger.law_energy - swing) / before - 1.0;
}

} // namespace

TEST_CASE("a DEM step at 0.99 of its limit is stable, one at 1.01 is refused and would have exploded", "[hard][steps][rve]") {
    HardCase hard("steps", "DEM at 0.99 and 1.01 of 2/omega", "the highest mode of the contact network grows");
    for (const KernelChoice& kernel : every_kernel()) {
        hard.holds(no_rise, disc_growth(kernel, 0.99, true), kernel.name());
        const std::string fault = fault_of([&] { disc_growth(kernel, 1.01, true); });
        hard.holds(refused, says(fault, "is unstable for packing 0") ? 0 : 1, kernel.name());
        hard.fails_without("the check of the DEM step", no_rise, disc_growth(kernel, 1.05, false), kernel.name());
    }
}

TEST_CASE("an RVE whose contacts close during the run takes smaller sub-steps, without which it vibrates", "[hard][steps][rve]") {
    HardCase hard("steps", "DEM stiffness rising during the run", "the step chosen for a loose heap is too long for a pressed one");
    const Invariant counted{"steps helped that were not counted", 0, "every event is counted"};
    const auto press = [](const KernelChoice& kernel, bool checked, Answer& answer, bool& stiffened) {
        RveParameters p;
        const Packing loose = farm::samples::lattice(64, -0.01, 0.05, 0.03, 5); // hardly a contact
        p.time_step = 1.05 * kernel.farm_of(p, farm::samples::disordered(64)).largest_stable_step(0) / shortening_by_damping(p.damping); // of the pressed heap
        farm::FarmOptions options = kernel.options();
        options.smaller_sub_steps = checked;
        farm::Farm rve(p, {loose}, {0}, options);
        const double at_start = rve.largest_stable_step(0);
        for (int k = 0; k < 500 && answer.status == Status::ok; ++k) answer = farm::samples::step(rve, {-1e-4, 0, 0, -1e-4}, 100 * p.time_step, 100);
        for (int k = 0; k < 50 && answer.status == Status::ok; ++k) answer = farm::samples::step(rve, {0, 0, 0, 0}, 100 * p.time_step, 100);
        const double shortening = shortening_by_damping(p.damping);
        stiffened = answer.status != Status::ok || (rve.largest_stable_step(0) / shortening < p.time_step && at_start / shortening > p.time_step);
        return answer.status == Status::ok ? std::abs(answer.kinetic_energy) / answer.stored_energy : HUGE_VAL;
    };
    for (const KernelChoice& kernel : every_kernel()) {
        Answer with, without;
        bool stiffened = false;
        hard.holds(at_rest, press(kernel, true, with, stiffened), kernel.name());
        CHECK(stiffened);
        hard.holds(counted, with.split_steps > 0 ? 0 : 1, kernel.name());
        hard.fails_without("smaller sub-steps where contacts stiffen", at_rest, press(kernel, false, without, stiffened), kernel.name());
    }
}

TEST_CASE("a strain taken in fewer sub-steps than it calls for breaks the ledger", "[hard][steps][rve]") {
    HardCase hard("steps", "5 % strain in sub-steps of 1e-4", "discs jump through each other");
    for (const KernelChoice& kernel : every_kernel()) {
        const auto residual = [&](int substeps) { // straight to the kernel, past the bound on the strain of a sub-step
            RveParameters p;
            farm::Assembly rve(p, farm::samples::disordered(64));
            const farm::Kernel& k = farm::kernel(kernel.level, kernel.precision);
            farm::Stepper stepper{p, &k, true, {}};
            const Answer before = farm::measure(stepper, rve);
            if (substeps == 0) {
                const Answer after = farm::advance(stepper, rve, {0, 0.05, 0, 0, 5e-3, 100, 1});
                return ledger_residual(before, after);
            }
            Answer after;
            if (!unchecked(kernel, p, rve, farm::stretch_of(0, 0.05 / substeps, 0, 0, 0), 1e-5, substeps, after)) return HUGE_VAL;
            return ledger_residual(before, after);
        };
        hard.holds(closed_ledger, residual(0), kernel.name());
        hard.fails_without("the bound on the strain of a sub-step", closed_ledger, residual(2), kernel.name());
    }
}

TEST_CASE("discs that outrun their neighbour list are taken back, without which contacts are missed", "[hard][steps][rve]") {
    HardCase hard("steps", "a disc thrown through a narrow list", "contacts that are not on the list do not push");
    for (const KernelChoice& kernel : every_kernel()) {
        const auto thrown = [&](double skin, bool checked, double distance = 0) {
            RveParameters p;
            p.skin = skin;
            farm::Assembly rve(p, moved(farm::samples::disordered(64), distance));
            for (int i = 0; i < 64; i += 5) rve.view().velocity_x[i] = 1.0; // m/s: 1 mm in the step
            const farm::Kernel& k = farm::kernel(kernel.level, kernel.precision);
            farm::Stepper stepper{p, &k, false, {}};
            if (checked) return farm::advance(stepper, rve, {0, 0, 0, 0, 1e-3, 100, 1});
            Answer after;
            unchecked(kernel, p, rve, {}, 1e-5, 100, after);
            return after;
        };
        const Answer wide = thrown(3e-3, true);
        const double pressure = farm::samples::mean_pressure(wide);
        // In 100 sub-steps: single rounds displacements of 1 mm, double positions in a cell of 0.06 m.
        const double rounding = kernel.single() ? rounding_walk(unit_single, 100) * 1e-3 : rounding_walk(unit_double, 100) * 0.06; // m
        const Invariant same{kernel.single() ? "stress against that of a wide list in single, of the pressure" : "stress against that of a wide list, of the pressure",
                             difference(thrown(3e-3, true, rounding), wide) / pressure, "the list is no physics: the wide list's own change when its discs start as far off as 100 sub-steps round"};
        hard.holds(same, difference(thrown(5e-5, true), wide) / pressure, kernel.name());
        hard.fails_without("taking back a chunk that outran its list", same, difference(thrown(5e-5, false), wide) / pressure, kernel.name());
    }
}

TEST_CASE("a mechanical step at 0.99 of the safe one is stable wherever points lie, one at 1.01 of Eq. 42 is refused", "[hard][steps][mpm]") {
    HardCase hard("steps", "mechanics at 0.99 of the safe step, 1.01 of Eq. (42)", "a free surface vibrates and explodes");
    for (const int per_cell : {1, 4, 16})
        for (const double corner : {0.3, 0.337, 0.36}) hard.holds(no_growth, body_growth(per_cell, corner, 0.99), fmt::format("{} per cell at {}", per_cell, corner));
    Scene scene = elastic_scene(box({0.3, 0.3}, {0.7, 0.7}), {0, 0}, {1, 1});
    auto simulation = start(scene);
    const double limit = simulation->stable_step().step;
    hard.holds(refused, says(fault_of([&] { simulation->step(1.01 * limit); }), "beyond the largest stable one") ? 0 : 1);
    hard.fails_without("a step that heeds free surfaces", no_growth, body_growth(16, 0.36, 0.99 * limit / (start(elastic_scene(box({0.36, 0.36}, {0.96, 0.76}, 16), {0, 0}, {1.4, 1.2}))->stable_step().safe_step)), "0.99 of Eq. (42), 16 per cell");
}

TEST_CASE("a fixed step beyond the safe one is warned of, and named where the run then fails", "[hard][steps][mpm]") {
    HardCase hard("steps", "a fixed step of 0.99 of Eq. (42) at a free surface", "the run ends without a word about its step");
    Scene scene = elastic_scene(box({0.36, 0.36}, {0.96, 0.76}, 16), {0, 0}, {1.4, 1.2});
    scene.step.fixed = 0.99 * start(scene)->stable_step().step;
    auto simulation = start(scene);
    for (std::size_t p = 0; p < simulation->points().count(); ++p) simulation->points().velocity[p] = 1e-3 * Vector(std::sin(37.0 * static_cast<double>(p)), 0.5);
    const std::string fault = fault_of([&] { take_steps(*simulation, 5000); });
    INFO(fault);
    hard.holds({"explosions whose cause does not name the step", 0, "what cannot be saved is stopped by name: place, time and cause"}, says(fault, "in step") && (says(fault, "steps were longer than the") || says(fault, "beyond the largest stable one")) ? 0 : 1);
    REQUIRE_FALSE(simulation->warnings().empty());
    CHECK(says(simulation->warnings()[0], "beyond the one that is stable wherever points lie"));
}

TEST_CASE("the mechanical step follows a stiffness that rises, and is counted with place and time", "[hard][steps][mpm]") {
    HardCase hard("steps", "mechanical stiffness rising during the run", "the step of the start is too long for ground that was pressed");
    Scene scene = elastic_scene(box({0.3, 0.3}, {0.7, 0.7}), {0, 0}, {1, 1});
    scene.step.fixed.reset();
    auto simulation = start(scene);
    take_steps(*simulation, 1);
    const double first = simulation->next_step();
    for (double& modulus : simulation->points().p_wave_modulus) modulus *= 100.0;
    hard.holds({"step over a tenth of the first", 1.0 + 1e-14, "Eq. (42): a hundred times the stiffness is ten times the wave speed, to rounding"}, simulation->next_step() / (0.1 * first));
    simulation->step(simulation->next_step());
    const SelfHelp::Record& helped = simulation->self_help().record(Help::smaller_step);
    hard.holds({"smaller steps that were not counted", 0, "every event is counted"}, helped.count == 1.0 && helped.first_step == 2.0 && helped.first_point >= 0.0 && helped.first_x > 0.3 ? 0 : 1);
}

TEST_CASE("a step of heat at 0.99 of its limit stays in range, one at 1.01 is refused and would leave it", "[hard][steps][heat]") {
    HardCase hard("steps", "heat at 0.99 and 1.01 of b = 2", "temperatures swing between neighbours and grow");
    const Invariant in_range{"temperatures out of the imposed range, of the span", rounding_walk(unit_double, 2000), "the discrete maximum principle below b = 2 (Eq. 43), to rounding of 2,000 steps"};
    const auto overshoot = [](double part, bool checked) { // a checkerboard, the least smooth of all fields
        ThermalMaterialSpec dry = soil_material();
        dry.curve = "none";
        Scene scene = heat_scene(dry, {0.8, 0.8}, 0.05, 10.0);
        auto simulation = start_heat(scene);
        std::vector<double> celsius;
        for (const Vector& x : simulation->points().position) celsius.push_back(std::sin(31.0 * M_PI * x[0] / 0.8) * std::sin(31.0 * M_PI * x[1] / 0.8));
        simulation->set_temperature(celsius);
        if (!checked) simulation->leave_out_safeguards();
        const double step = part * simulation->heat()->limit(simulation->grid(), simulation->points()).step;
        for (int k = 0; k < (checked ? 2000 : 120); ++k) simulation->step(step); // soon after, absolute zero would stop it
        return simulation->heat()->books().overshoot() / simulation->heat()->span();
    };
    hard.holds(in_range, overshoot(0.99, true));
    hard.holds(refused, says(fault_of([&] { overshoot(1.01, true); }), "beyond the largest stable one of heat") ? 0 : 1);
    hard.fails_without("the check of the step of heat", in_range, overshoot(1.05, false), "1.05 of b = 2");
}
