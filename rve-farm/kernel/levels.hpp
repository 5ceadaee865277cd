#pragma once
// The kernels of the instruction levels: each file is compiled with the flags of its level and defines one of these.
#include "rve-farm/kernel/kernel.hpp"

namespace talik::farm {

using RunChunk = ChunkOutcome (*)(const RveParameters&, const ChunkRequest&, AssemblyView&, const ColumnChoice&, const SlotLayout&, WorkMemory&);
struct LevelKernels {
    LaneShape single_shape, double_shape;
    RunChunk single_, double_;
};
LevelKernels sse4_kernels();
LevelKernels avx2_kernels();
LevelKernels avx512_kernels();

} // namespace talik::farm
