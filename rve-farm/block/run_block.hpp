#pragma once
// One block of a launch: which RVE, which working memory, then its program.
#include "rve-farm/block/block_program.hpp"

namespace talik::farm {

struct BlockSource {
    const BlockRve* rves;
    const BlockTask* tasks;
    BlockResult* results;
};

template <bool ledger, bool spread, class Real, class Physics, class Team>
TALIK_BLOCK void run_block(const Team& team, const BlockSource& source, int block, const Physics& physics, const ContactLaw<double>& law, std::byte* shared, std::size_t shared_bytes) {
    const BlockTask& task = source.tasks[block];
    const BlockRve& rve = source.rves[task.rve];
    BlockWork<Real> work;
    work.template lay_out<spread>(rve.size, Physics::with_bonds, team.threads(), shared, shared_bytes, task.spread);
    BlockProgram<ledger, Real, Physics, Team>(team, task, rve, physics, law, work).run(source.results[block]);
}

} // namespace talik::farm
