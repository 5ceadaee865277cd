// The kernel for lanes at the level of sse4: compiled with the flags of that level (rve-farm/CMakeLists.txt).
#include "rve-farm/kernel/lane_kernel.hpp"
#include "rve-farm/kernel/levels.hpp"

namespace talik::farm {

LevelKernels sse4_kernels() { return {shape<float>(), shape<double>(), &run<float>, &run<double>}; }

} // namespace talik::farm
