#include "rve-farm/kernel/macro_run.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/error.hpp"
#include "rve-farm/assembly/neighbours.hpp"
#include "common/physics/clock.hpp"
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

} // namespace

MacroRun::MacroRun(const Stepper& stepper, Assembly& rve, const MacroStep& step)
    : stepper_(&stepper), rve_(&rve), step_(step), shortening_(shortening_by_damping(stepper.parameters.damping)) {
    left_ = substeps_needed(step);
    if (left_ < 0) fault(Status::bad_request);
    else if (is_stable_by_list(rve.view(), contact_law_of(stepper.parameters), shortening_ * step.time_increment / left_)) begin();
    else need_ = Need::positions;
}

void MacroRun::judge() {
    ensure(need_ == Need::positions);
    const ContactLaw<double> law = contact_law_of(stepper_->parameters);
    AssemblyView& s = rve_->view();
    if (is_stable(s, law, shortening_ * step_.time_increment / left_)) {
        begin();
        return;
    }
    constexpr double safety = 0.9; // contacts have closed since the step was chosen, and more may close within it
    const double largest = stable_step(omega_squared_of_contacts(s, law)) / shortening_;
    const double needed = std::ceil(step_.time_increment / (safety * largest));
    if (stepper_->smaller_sub_steps && needed <= most_extra_sub_steps * left_) {
        left_ = std::max(left_, static_cast<int>(needed));
        begin();
        return;
    }
    fault(Status::unstable_step);
    answer_.largest_stable_step = largest;
}

void MacroRun::begin() {
    AssemblyNumbers& n = *rve_->view().numbers;
    sub_step_ = step_.time_increment / left_;
    if (left_ > step_.substeps) ++n.split_steps;
    stretch_ = stretch_of(step_.xx / left_, step_.xy / left_, step_.yx / left_, step_.yy / left_, n.frame_angle);
    strain_ = stretch_.largest_strain();
    longest_ = strain_ > 0 ? static_cast<int>(std::clamp(bounds_of(stepper_->kernel->precision).strain / strain_, 1.0, 1e6)) : left_;
    begin_chunk();
}

MacroRun::Fit MacroRun::fit() const {
    const AssemblyNumbers& n = rve_->numbers();
    const double largest = substeps_ == 1 ? largest_displacement_of_a_sub_step : bounds_of(stepper_->kernel->precision).displacement;
    return {displacement_left(n, strain_ * substeps_), largest * n.smallest_radius};
}

// The chunk that discs as fast as in the last one are expected to stay within: of the series, and of a quarter of what a
// fresh list lasts. A chunk that must be taken again is dear.
int MacroRun::expected_to_hold(int substeps) const {
    constexpr double nothing_is_known_yet = 100; // sub-steps, the first of all
    const AssemblyNumbers& n = rve_->numbers();
    const double by_series = bounds_of(stepper_->kernel->precision).displacement * n.smallest_radius / (1.5 * n.last_displacement);
    const double by_list = n.skin / (2 * n.last_displacement + strain_ * (2 * n.largest_radius + n.skin)) / 4;
    const double most = std::min({by_series, by_list, n.last_sub_step > 0 ? static_cast<double>(substeps) : nothing_is_known_yet});
    return most < substeps ? std::max(1, static_cast<int>(most)) : substeps;
}

// Up to the longest chunk, on one list: made anew where it is spent or is about to be.
void MacroRun::begin_chunk() {
    const AssemblyNumbers& n = rve_->numbers();
    substeps_ = expected_to_hold(std::min(left_, longest_));
    fresh_ = n.list_substeps == 0;
    foreseen_ = 0;
    widened_ = false;
    if (!fresh_ && n.last_displacement * substeps_ >= fit().by_list) want_list();
    else propose();
}

void MacroRun::list_made(Status status) {
    ensure(need_ == Need::list);
    fresh_ = true;
    if (status != Status::ok) fault(status);
    else propose();
}

void MacroRun::propose() {
    const AssemblyNumbers& n = rve_->numbers();
    for (;;) {
        const Fit fits = fit();
        if (foreseen_ < fits.allowed()) {
            request_ = ChunkRequest();
            request_.stretch = stretch_;
            request_.substeps = substeps_;
            request_.sub_step = sub_step_;
            request_.first_kick = n.last_sub_step > 0 ? (n.last_sub_step + sub_step_) / 2 : sub_step_; // forces act half of each
            request_.beta = step_.beta;
            request_.displacement_allowed = fits.allowed();
            request_.ledger = stepper_->ledger;
            need_ = Need::chunk;
            return;
        }
        need_ = Need::chunk;
        tried_in_vain(fits);
        if (need_ != Need::chunk) return;
    }
}

void MacroRun::chunk_run(const ChunkOutcome& outcome) {
    ensure(need_ == Need::chunk);
    AssemblyNumbers& n = *rve_->view().numbers;
    if (outcome.accepted) {
        n.strain_bound += outcome.strain;
        n.list_substeps += substeps_;
        n.last_displacement = outcome.largest_displacement / substeps_;
        left_ -= substeps_;
        stretch_ = outcome.stretch;
        answer_ = outcome.answer;
        if (left_ > 0) begin_chunk();
        else need_ = Need::nothing;
        return;
    }
    if (!outcome.finite && substeps_ == 1) return fault(Status::not_finite);
    // Far beyond the bounds the series themselves explode: what is no number then may be one in a shorter chunk.
    foreseen_ = outcome.finite ? outcome.largest_displacement : std::numeric_limits<double>::infinity();
    ++n.retaken_chunks;
    tried_in_vain(fit());
    if (need_ == Need::chunk) propose();
}

// Shortens the chunk where even a fresh list would not outlast it.
void MacroRun::tried_in_vain(const Fit& fits) {
    AssemblyNumbers& n = *rve_->view().numbers;
    const bool list_was_too_narrow = foreseen_ > fits.by_list || fits.by_list <= 0;
    if (list_was_too_narrow && std::isfinite(foreseen_) && !fresh_) {
        want_list();
    } else if (substeps_ > 1) {
        const double bearable = fits.allowed() > 0 && std::isfinite(foreseen_) ? 0.7 * fits.allowed() / foreseen_ : 0.5; // part of the chunk
        substeps_ = std::max(1, static_cast<int>(std::min(bearable, 0.5) * substeps_));
        foreseen_ = 0;
    } else if (list_was_too_narrow && !widened_ && n.skin < n.widest_skin) {
        widened_ = true;
        n.skin = n.widest_skin; // or as wide as there is room for
        n.list_substeps = 0; // the skin is not to be chosen from what has just been too little
        want_list();
    } else {
        fault(Status::not_finite);
    }
}

void MacroRun::fault(Status status) {
    answer_ = Answer();
    answer_.status = status;
    need_ = Need::nothing;
}

} // namespace talik::farm
