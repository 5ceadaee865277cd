#pragma once
// What the kernels of the CPU have in common around the sub-steps of a chunk: the clock of its stages, and the last word on it.
#include <time.h>

#include "rve-farm/kernel/chunk_ends.hpp"
#include "rve-farm/kernel/conclude.hpp"
#include "rve-farm/kernel/work.hpp"
#include "rve-farm/physics/physics.hpp"

namespace talik::farm {

// The clock of a chunk's stages, read only where they are asked for.
template <class Level>
class StageClock {
public:
    explicit StageClock(bool on) : on_(on) { lap(); }
    double lap() { // seconds since the last lap
        if (!on_) return 0;
        timespec now;
        clock_gettime(CLOCK_MONOTONIC, &now);
        const double seconds = static_cast<double>(now.tv_sec - last_.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec - last_.tv_nsec);
        last_ = now;
        return seconds;
    }

private:
    bool on_;
    timespec last_{};
};

// Is it sound, has the list held, and then state and answer: `close` gives the state back and adds to the sums.
template <class Level, class Close>
void finish(const ChunkRequest& request, StageClock<Level>& clock, const ChunkMotion& cell, const ContactLaw<double>& law, AssemblyView& s, const ChunkLedger& ledger,
            double largest_displacement, bool finite, ChunkOutcome& outcome, Close&& close) {
    outcome.inner_seconds = clock.lap();
    outcome.largest_displacement = largest_displacement;
    outcome.finite = finite;
    outcome.accepted = outcome.finite && (request.substeps == 0 || largest_displacement <= request.displacement_allowed);
    if (outcome.accepted) {
        ChunkSums sums;
        sums.ledger = ledger;
        close(sums);
        conclude(request, cell, law, sums, *s.numbers, outcome);
    }
    outcome.close_seconds = clock.lap();
}

} // namespace talik::farm
