#pragma once
// One macro step of one RVE: its sub-steps in chunks that the candidate list outlasts.
#include <cstdint>
#include <optional>

#include "rve-farm/assembly/assembly.hpp"
#include "rve-farm/kernel/kernel.hpp"

namespace talik::farm {

struct MacroStep {
    double xx = 0, xy = 0, yx = 0, yy = 0; // displacement-gradient increment dt grad v, fixed axes, -
    double time_increment = 0;             // s
    int substeps = 1;                      // asked for; more are taken where the increment calls for it
    double beta = 1;                       // beta_b of Eq. (8), -
};

// Where the time of a farm's steps has gone, s.
struct alignas(64) StageSeconds {
    double load = 0, inner = 0, close = 0, rebuild = 0;
};

// How a farm steps its RVEs.
struct Stepper {
    RveParameters parameters;
    const Kernel* kernel = nullptr;
    bool ledger = true;                         // book work and dissipation
    std::optional<std::uint64_t> shuffle_seed;  // tests: the plain kernel, its phases visited in scrambled order
    bool smaller_sub_steps = true;              // where contacts have grown too stiff for those asked for; else unstable_step

    LaneShape shape() const { return shuffle_seed ? LaneShape{} : kernel->shape; }
    ChunkOutcome run(const ChunkRequest& request, AssemblyView& s, const ColumnChoice& columns, const SlotLayout& layout) const;
};

// The largest relative change of a length that a sub-step may bring. A branch is about two radii, an overlap at the
// pressures of interest about a hundredth of a diameter: 1e-4 changes an overlap by about 1 %, which the incremental
// tangential law and the trapezoidal work follow to second order.
constexpr double largest_strain_of_a_sub_step = 1e-4;
// An increment beyond this is no step but a fault of whoever asked.
constexpr double largest_strain_of_a_macro_step = 1.0;

// A step that would take more than so many times the sub-steps asked for is no longer helped but refused.
constexpr int most_extra_sub_steps = 10;

// The number of sub-steps that the strain calls for, or -1 where the request is none.
int substeps_needed(const MacroStep& step);

// The list of candidates made anew, and the layout of it.
Status make_list(Assembly& rve, LaneShape shape);

// Answers the state after the step. A fault is a status, and leaves the RVE at the last good chunk.
// stages: of this thread; null where nobody asks.
Answer advance(const Stepper& stepper, Assembly& rve, const MacroStep& step, StageSeconds* stages = nullptr);

// The answer of the present state.
Answer measure(const Stepper& stepper, const Assembly& rve);

} // namespace talik::farm
