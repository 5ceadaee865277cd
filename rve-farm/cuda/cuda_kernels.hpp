#pragma once
// The kernels, one file for each precision and number of bonds: an instance takes a compiler a second or two.
#include <cuda_runtime.h>

#include "rve-farm/block/device.hpp"

namespace talik::farm {

// Launches on the stream; the error of the launch itself.
cudaError_t launch_single(const BlockLaunch& launch, cudaStream_t stream);
cudaError_t launch_double(const BlockLaunch& launch, cudaStream_t stream);

} // namespace talik::farm
