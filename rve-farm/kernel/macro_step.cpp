#include "rve-farm/kernel/macro_step.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "rve-farm/assembly/neighbours.hpp"
#include "rve-farm/kernel/macro_run.hpp"

namespace talik::farm {
namespace {

thread_local WorkMemory work_memory;

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

Status make_list(Assembly& rve, LaneShape shape) {
    const Status status = rebuild_neighbours(rve.view(), rve.columns());
    if (status == Status::ok) rve.layout().update(rve.view(), shape);
    else rve.layout().forget(); // the list stays, but discs may have been wrapped, and images with them
    return status;
}

Answer advance(const Stepper& stepper, Assembly& rve, const MacroStep& step, StageSeconds* stages) {
    for (MacroRun run(stepper, rve, step);;) {
        switch (run.need()) {
        case MacroRun::Need::positions: run.judge(); break;
        case MacroRun::Need::list: {
            const auto begin = std::chrono::steady_clock::now();
            run.list_made(make_list(rve, stepper.shape()));
            if (stages) stages->rebuild += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
            break;
        }
        case MacroRun::Need::chunk: {
            rve.layout().update(rve.view(), stepper.shape());
            ChunkRequest request = run.request();
            request.time_stages = stages != nullptr;
            const ChunkOutcome outcome = stepper.run(request, rve.view(), rve.columns(), rve.layout());
            if (stages) {
                stages->load += outcome.load_seconds;
                stages->inner += outcome.inner_seconds;
                stages->close += outcome.close_seconds;
            }
            run.chunk_run(outcome);
            break;
        }
        case MacroRun::Need::nothing: return run.answer();
        }
    }
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
