#include "rve-farm/cuda/kernel_instances.cuh"

namespace talik::farm {
cudaError_t launch_single(const BlockLaunch& launch, cudaStream_t stream) { return launch_in<float>(launch, stream); }
} // namespace talik::farm
