// In the place of cuda_device.cu where the build has no CUDA backend.
#include "rve-farm/block/device.hpp"

namespace talik::farm {

Gpus open_gpus() { return {{}, "this build has no CUDA backend"}; }
bool built_with_cuda() { return false; }

} // namespace talik::farm
