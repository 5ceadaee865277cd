#pragma once
// From the sums of a chunk to the answer of its RVE and the numbers of its state.
#include "rve-farm/kernel/chunk_ends.hpp"
#include "rve-farm/kernel/kernel.hpp"

namespace talik::farm {

// The sums are those of the end; the numbers move there where the chunk is given back.
void conclude(const ChunkRequest& request, const ChunkMotion& cell, const ContactLaw<double>& law, const ChunkSums& sums, AssemblyNumbers& numbers, ChunkOutcome& outcome);

} // namespace talik::farm
