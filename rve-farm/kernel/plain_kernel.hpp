#pragma once
#include "rve-farm/kernel/kernel.hpp"

namespace talik::farm {

ChunkOutcome run_plain_double(const RveParameters&, const ChunkRequest&, AssemblyView&, const ColumnChoice&, const SlotLayout&, WorkMemory&);
ChunkOutcome run_plain_single(const RveParameters&, const ChunkRequest&, AssemblyView&, const ColumnChoice&, const SlotLayout&, WorkMemory&);

} // namespace talik::farm
