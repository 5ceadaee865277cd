#include "rve-farm/cuda/kernel_instances.cuh"

namespace talik::farm {
cudaError_t launch_double(const BlockLaunch& launch, cudaStream_t stream) { return launch_in<double>(launch, stream); }
} // namespace talik::farm
