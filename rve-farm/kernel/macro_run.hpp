#pragma once
// A macro step of one RVE as a sequence of needs: a chunk run, a list made anew. Whoever steps RVEs, one after the other on a core
// or thousands at once on a GPU, asks what each needs next and tells what came of it; the decisions are here, once.
#include "rve-farm/kernel/macro_step.hpp"

namespace talik::farm {

class MacroRun {
public:
    enum class Need {
        positions, // the present state in the assembly, to judge the sub-step by; then judge()
        list,      // the present state in the assembly, and its list made anew; then list_made()
        chunk,     // request() run; then chunk_run()
        nothing    // the macro step is over: answer()
    };

    MacroRun() = default;
    // Numbers and list of the RVE are read, its discs and contacts only by judge().
    MacroRun(const Stepper& stepper, Assembly& rve, const MacroStep& step);

    Need need() const { return need_; }
    void judge();
    void list_made(Status status);
    const ChunkRequest& request() const { return request_; }
    void chunk_run(const ChunkOutcome& outcome);
    // Of the state after the step. A fault is a status, and leaves the RVE at the last good chunk.
    const Answer& answer() const { return answer_; }

private:
    struct Fit {
        double by_list, by_series; // largest displacement of any disc, m
        double allowed() const { return by_list < by_series ? by_list : by_series; }
    };

    void begin();
    void begin_chunk();
    void propose();
    void tried_in_vain(const Fit& fits);
    void fault(Status status);
    void want_list() { need_ = Need::list; }
    Fit fit() const;
    int expected_to_hold(int substeps) const;

    const Stepper* stepper_ = nullptr;
    Assembly* rve_ = nullptr;
    Need need_ = Need::nothing;
    ChunkRequest request_;
    Answer answer_;
    Stretch stretch_;         // of the next sub-step
    MacroStep step_;
    double shortening_ = 1;             // of the stable step, by damping
    double sub_step_ = 0, strain_ = 0;  // s; of a sub-step, the same in every one of the macro step
    int left_ = 0, longest_ = 0; // sub-steps of the macro step; of a chunk, by the strain of the cell

    // Of the chunk that is being taken.
    int substeps_ = 0;
    bool fresh_ = false, widened_ = false; // its list
    double foreseen_ = 0; // displacement of a chunk that has been tried in vain: on a wider list it will be the same, m
};

} // namespace talik::farm
