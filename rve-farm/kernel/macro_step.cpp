#include "rve-farm/kernel/macro_step.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "rve-farm/assembly/neighbours.hpp"
#include "rve-farm/assembly/stable_step.hpp"
#include "rve-farm/kernel/branch_motion.hpp"
#include "rve-farm/physics/physics_choice.hpp"

namespace talik::farm {
namespace {

// So that no branch turns or stretches by more than largest_turn_of_a_branch in a chunk: a quarter of it is left to the strain
// of the cell, three to the displacement of any disc over the smallest radius (a branch is at least two of them long, and has
// two ends).
struct ChunkBounds {
    double strain, displacement;
};
ChunkBounds bounds_of(Precision precision) {
    const double turn = precision == Precision::single_ ? largest_turn_of_a_branch<float> : largest_turn_of_a_branch<double>;
    return {turn / 4, turn * 3 / 4};
}

// Over the smallest radius, in a single sub-step, which cannot be shortened: beyond it discs have exploded. (The series are
// then off by up to 1e-4 of an angle, which a collision of that violence does not notice.)
constexpr double largest_displacement_of_a_sub_step = 0.1;

thread_local WorkMemory work_memory;

struct ChunkFit {
    double by_list, by_series; // largest displacement of any disc, m
    double allowed() const { return std::min(by_list, by_series); }
};

ChunkFit fit(const AssemblyNumbers& n, Precision precision, double strain, int substeps) {
    const double largest = substeps == 1 ? largest_displacement_of_a_sub_step : bounds_of(precision).displacement;
    return {displacement_left(n, strain), largest * n.smallest_radius};
}

// The chunk that discs as fast as in the last one are expected to stay within: of the series, and of a quarter of what a
// fresh list lasts. A chunk that must be taken again is dear.
int expected_to_hold(const AssemblyNumbers& n, Precision precision, double strain, int substeps) {
    constexpr double nothing_is_known_yet = 100; // sub-steps, the first of all
    const double by_series = bounds_of(precision).displacement * n.smallest_radius / (1.5 * n.last_displacement);
    const double by_list = n.skin / (2 * n.last_displacement + strain * (2 * n.largest_radius + n.skin)) / 4;
    const double most = std::min({by_series, by_list, n.last_sub_step > 0 ? static_cast<double>(substeps) : nothing_is_known_yet});
    return most < substeps ? std::max(1, static_cast<int>(most)) : substeps;
}

// Takes up to `substeps` sub-steps on one list: rebuilds it where it is spent or is about to be, shortens the chunk where
// even a fresh list would not outlast it. Returns how many were taken; 0 with a status where none could be.
int take_chunk(const Stepper& stepper, Assembly& rve, int substeps, const Stretch& stretch, double sub_step, double beta, ChunkOutcome& outcome,
               Status& status, StageSeconds* stages) {
    AssemblyView& s = rve.view();
    AssemblyNumbers& n = *s.numbers;
    const double strain = stretch.largest_strain(); // of a sub-step; the same in every one of the macro step
    bool fresh = n.list_substeps == 0;
    const auto rebuild = [&] {
        const auto begin = std::chrono::steady_clock::now();
        fresh = true;
        status = rebuild_neighbours(s, rve.columns());
        if (status == Status::ok) rve.layout().update(s, stepper.shape());
        if (stages) stages->rebuild += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        return status == Status::ok;
    };
    substeps = expected_to_hold(n, stepper.kernel->precision, strain, substeps);
    if (!fresh && n.last_displacement * substeps >= fit(n, stepper.kernel->precision, strain * substeps, substeps).by_list && !rebuild()) return 0;
    double foreseen = 0; // displacement of a chunk that has been tried in vain: on a wider list it will be the same, m
    bool widened = false;
    for (;;) {
        const ChunkFit fits = fit(n, stepper.kernel->precision, strain * substeps, substeps);
        ChunkRequest request;
        request.stretch = stretch;
        request.substeps = substeps;
        request.sub_step = sub_step;
        request.first_kick = n.last_sub_step > 0 ? (n.last_sub_step + sub_step) / 2 : sub_step; // forces act half of each
        request.beta = beta;
        request.displacement_allowed = fits.allowed();
        request.ledger = stepper.ledger;
        request.time_stages = stages != nullptr;
        rve.layout().update(s, stepper.shape());
        if (foreseen < fits.allowed()) {
            outcome = stepper.run(request, s, rve.columns(), rve.layout());
            if (stages) {
                stages->load += outcome.load_seconds;
                stages->inner += outcome.inner_seconds;
                stages->close += outcome.close_seconds;
            }
            if (outcome.accepted) {
                n.strain_bound += outcome.strain;
                n.list_substeps += substeps;
                n.last_displacement = outcome.largest_displacement / substeps;
                return substeps;
            }
            if (!outcome.finite && substeps == 1) {
                status = Status::not_finite;
                return 0;
            }
            // Far beyond the bounds the series themselves explode: what is no number then may be one in a shorter chunk.
            foreseen = outcome.finite ? outcome.largest_displacement : std::numeric_limits<double>::infinity();
            ++n.retaken_chunks;
        }
        const bool list_was_too_narrow = foreseen > fits.by_list || fits.by_list <= 0;
        if (list_was_too_narrow && std::isfinite(foreseen) && !fresh) {
            if (!rebuild()) return 0;
        } else if (substeps > 1) {
            const double bearable = fits.allowed() > 0 && std::isfinite(foreseen) ? 0.7 * fits.allowed() / foreseen : 0.5; // part of the chunk
            substeps = std::max(1, static_cast<int>(std::min(bearable, 0.5) * substeps));
            foreseen = 0;
        } else if (list_was_too_narrow && !widened && n.skin < n.widest_skin) {
            widened = true;
            n.skin = n.widest_skin; // or as wide as there is room for
            n.list_substeps = 0; // the skin is not to be chosen from what has just been too little
            if (!rebuild()) return 0;
        } else {
            status = Status::not_finite;
            return 0;
        }
    }
}

} // namespace

ChunkOutcome Stepper::run(const ChunkRequest& request, AssemblyView& s, const ColumnChoice& columns, const SlotLayout& layout) const {
    if (shuffle_seed) return run_shuffled(*shuffle_seed, kernel->precision, parameters, request, s, columns, layout, work_memory);
    return kernel->run(parameters, request, s, columns, layout, work_memory);
}

int substeps_needed(const MacroStep& step) {
    const double strain = stretch_of(step.xx, step.xy, step.yx, step.yy, 0).largest_strain();
    if (!(strain <= largest_strain_of_a_macro_step) || !std::isfinite(step.xy - step.yx + step.beta)) return -1;
    return std::max(step.substeps, static_cast<int>(std::ceil(strain / largest_strain_of_a_sub_step * (1 - 1e-12))));
}

Answer advance(const Stepper& stepper, Assembly& rve, const MacroStep& step, StageSeconds* stages) {
    AssemblyView& s = rve.view();
    AssemblyNumbers& n = *s.numbers;
    const ContactLaw<double> law = contact_law_of(stepper.parameters);
    Answer fault;
    fault.status = Status::bad_request;
    int substeps = substeps_needed(step);
    if (substeps < 0) return fault;
    const double shortening = shortening_by_damping(stepper.parameters.damping);
    if (!is_stable(s, law, shortening * step.time_increment / substeps)) { // contacts have closed since the step was chosen
        constexpr double safety = 0.9; // more may close within the step
        fault.status = Status::unstable_step;
        fault.largest_stable_step = stable_step(omega_squared_of_contacts(s, law)) / shortening;
        const double needed = std::ceil(step.time_increment / (safety * fault.largest_stable_step));
        if (!stepper.smaller_sub_steps || !(needed <= most_extra_sub_steps * substeps)) return fault;
        substeps = std::max(substeps, static_cast<int>(needed));
    }
    const double sub_step = step.time_increment / substeps;
    if (substeps > step.substeps) ++n.split_steps;
    Stretch stretch = stretch_of(step.xx / substeps, step.xy / substeps, step.yx / substeps, step.yy / substeps, n.frame_angle);
    const double strain = stretch.largest_strain();
    const int longest = strain > 0 ? static_cast<int>(std::clamp(bounds_of(stepper.kernel->precision).strain / strain, 1.0, 1e6)) : substeps;
    ChunkOutcome outcome;
    for (int left = substeps; left > 0;) {
        outcome = ChunkOutcome();
        const int taken = take_chunk(stepper, rve, std::min(left, longest), stretch, sub_step, step.beta, outcome, fault.status, stages);
        if (taken == 0) return fault;
        left -= taken;
        stretch = outcome.stretch;
    }
    return outcome.answer;
}

Answer measure(const Stepper& stepper, const Assembly& rve) {
    Assembly copy(rve); // the layout is the kernel's, and the state stays
    ChunkRequest request;
    request.give_back = false;
    request.ledger = false;
    copy.layout().update(copy.view(), stepper.shape());
    return stepper.run(request, copy.view(), copy.columns(), copy.layout()).answer;
}

} // namespace talik::farm
