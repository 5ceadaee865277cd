#include "rve-farm/packing/prepare.hpp"

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <optional>

#include <fmt/format.h>

#include "common/base/error.hpp"
#include "common/packing/packing_csv.hpp"
#include "rve-farm/packing/k0_path.hpp"
#include "rve-farm/packing/press.hpp"
#include "rve-farm/packing/random_discs.hpp"

namespace talik::farm {
namespace {

constexpr double loosest_start = 1.0;     // void ratio of the random discs
constexpr int most_draws = 40;            // of discs, per packing
constexpr double start_above = 4e-3;      // void ratio: compaction aims above the target by this
constexpr double steps_of_lowering = 2000; // macro steps in which the friction would be lowered to 0
constexpr long least_steps_allowed = 400000; // macro steps of ten sub-steps, per packing: ten times what a hard one needs under 100 kPa
constexpr long most_steps_allowed = 4 * least_steps_allowed;
constexpr long steps_of_a_note = 500;     // macro steps between two notes on the search
constexpr Equilibrium nearly{.stress_error = 1e-2, .unbalanced_force = 1e-2};

// The mean void ratio over the preparation friction, of radii within a factor of two at an overlap of 1 %: where the search
// begins. Measured here on 400 discs; the scatter between draws is 0.004 (no friction) to 0.010 (0.5) for 200 discs.
double friction_guess(double void_ratio) {
    constexpr double table[][2] = {{0.157, 0.0}, {0.163, 0.02}, {0.174, 0.05}, {0.185, 0.1}, {0.200, 0.2}, {0.213, 0.3}, {0.232, 0.5}, {0.250, 1.0}};
    if (void_ratio <= table[0][0]) return 0.0;
    for (std::size_t i = 1; i < std::size(table); ++i)
        if (void_ratio <= table[i][0])
            return table[i - 1][1] + (table[i][1] - table[i - 1][1]) * (void_ratio - table[i - 1][0]) / (table[i][0] - table[i - 1][0]);
    return 1.0;
}

// Under a small pressure compaction is slow: then as many as all draws take, and half as many again for coming to rest, within limits.
long steps_allowed(const RveSpec& spec) {
    const double of_all_draws = 1.5 * most_draws * Press::steps_of_compaction(spec, loosest_start, spec.packing.void_ratio);
    return static_cast<long>(std::clamp(of_all_draws, 1.0 * least_steps_allowed, 1.0 * most_steps_allowed));
}

// The search for one packing. Each draw of discs is compacted under a friction that should leave it a little above the
// target; then the friction is lowered slowly, the pressure held, until the void ratio meets the target: along one path it
// falls continuously, where restarts at another friction scatter by more than the tolerance.
class Search {
public:
    using Note = std::function<void(const std::string&)>;
    Search(const RveSpec& spec, std::uint64_t seed, const Note& note) : spec_(spec), seed_(seed), note_(note), target_(spec.packing.void_ratio), shift_(start_above) {}

    Packing run() {
        try {
            return draws();
        } catch (const StepsSpent& reached) {
            give_up(reached);
        }
    }

private:
    Packing draws() {
        for (int draw = 0; draw < most_draws; ++draw) {
            const double friction = std::min(friction_guess(target_ + shift_), final_friction());
            draw_ = draw;
            say("compacting");
            Press press(spec_, random_discs(spec_, seed_, draw, loosest_start), friction, &steps_left_);
            if (!press.settle(nearly)) continue;
            if (meets_target(press, friction)) return press.at_rest(spec_.packing.pressure, seed_);
            if (hopeless(draw)) break;
        }
        out_of_reach();
    }

    void say(const std::string& what) const {
        if (note_) note_(fmt::format("seed {}, draw {}: {}", seed_, draw_ + 1, what));
    }

    double final_friction() const { return spec_.parameters.contact.friction; }
    double tolerance() const { return spec_.packing.void_ratio_tolerance; }

    // Lowers the friction until the packing, at rest with its final friction, meets the target. Where it cannot, the next
    // draw begins with another friction.
    bool meets_target(Press& press, double friction) {
        const double lowering = std::max(friction, 0.05) / steps_of_lowering;
        const bool loosest = friction >= final_friction(), densest = friction <= 0.0;
        note_reach(press.state().void_ratio, densest, loosest);
        if (press.state().void_ratio < target_ - tolerance()) {
            shift_ += target_ + start_above - press.state().void_ratio;
            return false;
        }
        while (true) {
            while (friction > 0.0 && press.state().void_ratio > target_ + 0.3 * tolerance()) {
                friction = std::max(0.0, friction - lowering);
                press.set_friction(friction);
                press.step();
                if (steps_left_ % steps_of_a_note == 0) say(fmt::format("void ratio {:.4f} on its way to {:g}", press.state().void_ratio, target_));
            }
            const bool rests = press.settle(nearly); // slides on for a while under the low friction
            if (friction > 0.0 && rests && press.state().void_ratio > target_ + 0.3 * tolerance()) continue;
            press.set_friction(final_friction());
            if (!press.settle({})) return false;
            const double error = press.state().void_ratio - target_;
            if (!nearest_ || std::abs(error) < std::abs(*nearest_ - target_)) nearest_ = press.state().void_ratio;
            if (std::abs(error) <= tolerance()) return true;
            if (error < 0.0 || friction <= 0.0) { // fell through, or is as dense as it gets
                if (friction <= 0.0) note_reach(press.state().void_ratio, true, false), shift_ -= error;
                return false;
            }
        }
    }

    void note_reach(double void_ratio, bool densest, bool loosest) {
        if (densest) least_ = std::min(least_.value_or(void_ratio), void_ratio);
        if (loosest) most_ = std::max(most_.value_or(void_ratio), void_ratio);
    }

    // The scatter between draws is about 0.01: a target further out than that is not met by one draw more.
    bool hopeless(int draw) const {
        return draw >= 2 && ((least_ && *least_ > target_ + 0.02) || (most_ && *most_ < target_ - 0.02));
    }

    double void_ratio_under(double friction) {
        Press press(spec_, random_discs(spec_, seed_, 0, loosest_start), friction, &steps_left_);
        press.settle(nearly);
        press.set_friction(final_friction());
        press.settle(nearly);
        return press.state().void_ratio;
    }

    [[noreturn]] void out_of_reach() {
        steps_left_ = steps_allowed(spec_); // for the ends of the range
        const double least = least_ ? *least_ : void_ratio_under(0.0), most = most_ ? *most_ : void_ratio_under(final_friction());
        if (least <= target_ && target_ <= most)
            throw Error(ExitCode::bad_input, "rve.packing.void_ratio_tolerance",
                        fmt::format("with {} discs the tolerance of {:g} is too tight: none of {} draws of seed {} came to rest within it of {:g}{}", spec_.packing.discs, tolerance(), draw_ + 1, seed_, target_,
                                    nearest_ ? fmt::format("; the nearest had {:.4f}", *nearest_) : ""),
                        "take more discs, a wider tolerance, or another seed");
        throw Error(ExitCode::bad_input, "rve.packing.void_ratio", fmt::format("{:g} is out of reach for seed {}", target_, seed_),
                    fmt::format("{} discs of these sizes at {:g} kPa with friction {:g} reach about {:.3f} to {:.3f}: choose a value in between", spec_.packing.discs,
                                1e-3 * spec_.packing.pressure, final_friction(), least, most));
    }

    [[noreturn]] void give_up(const StepsSpent& reached) const {
        throw Error(ExitCode::bad_input, "rve.packing",
                    fmt::format("no packing of void ratio {:g} within {} sub-steps (seed {}, draw {}): it stands at void ratio {:.4f}, {:.2g} % from the pressure, with an unbalanced force of {:.2g}", target_,
                                10 * steps_allowed(spec_), seed_, draw_ + 1, reached.void_ratio, 100.0 * reached.stress_error, reached.unbalanced_force),
                    "take a wider void_ratio_tolerance or another void_ratio, sizes closer together, or a larger ratio of pressure times thickness to normal_stiffness");
    }

    const RveSpec& spec_;
    std::uint64_t seed_;
    const Note& note_;
    long steps_left_ = steps_allowed(spec_);
    int draw_ = 0;
    double target_;
    double shift_;                       // compaction aims at target + shift
    std::optional<double> least_, most_; // void ratios met without and with all friction
    std::optional<double> nearest_;      // to the target, of packings at rest with their final friction
};

Packing from_csv(const RveSpec& spec) {
    Packing p = read_packing_csv(spec.packing.particles, spec.packing.contacts);
    if (!spec.packing.contacts.empty()) return p;
    RveSpec same = spec; // the file's own sizes and material
    same.packing.radius_min = *std::min_element(p.radius.begin(), p.radius.end());
    same.packing.radius_max = *std::max_element(p.radius.begin(), p.radius.end());
    same.parameters.thickness = p.thickness;
    same.parameters.grain_density = p.grain_density;
    Press press(same, p, spec.parameters.contact.friction);
    require(press.settle({}), spec.packing.particles + ": the discs do not come to rest under the pressure", "check sizes, stiffness and pressure");
    return press.at_rest(spec.packing.pressure, spec.packing.seed);
}

} // namespace

Packing prepare_packing(const RveSpec& spec, std::uint64_t seed, const std::function<void(const std::string&)>& note) { return Search(spec, seed, note).run(); }

std::vector<Packing> prepare_packings(const RveSpec& spec, int threads, const std::function<void(int, const std::string&)>& progress) {
    if (!spec.packing.by_specification()) return {from_csv(spec)};
    const int count = spec.packing.count;
    std::vector<std::vector<Packing>> packings(static_cast<std::size_t>(count)); // of each seed: itself, or its K0 snapshots
    std::vector<std::exception_ptr> faults(packings.size());
    int done = 0;
    const auto note = [&](const std::string& text) {
#pragma omp critical(talik_packing_progress)
        if (progress) progress(done, text);
    };
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads > 0 ? threads : omp_get_max_threads())
    for (int i = 0; i < count; ++i) {
        const auto slot = static_cast<std::size_t>(i);
        try {
            const Packing prepared = prepare_packing(spec, spec.packing.seed + slot, note);
            packings[slot] = spec.packing.k0 ? k0_snapshots(spec, prepared) : std::vector<Packing>{prepared};
        } catch (...) {
            faults[slot] = std::current_exception();
        }
#pragma omp critical(talik_packing_progress)
        if (++done; progress) progress(done, "");
    }
    for (const auto& fault : faults)
        if (fault) std::rethrow_exception(fault);
    std::vector<Packing> all;
    for (const auto& of_seed : packings) all.insert(all.end(), of_seed.begin(), of_seed.end());
    return all;
}

} // namespace talik::farm
