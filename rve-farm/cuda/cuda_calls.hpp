#pragma once
// Every call of the CUDA runtime goes through here: what fails is an Error that says what was being done, and that ends the run with
// the exit code of a resource that is missing (4).
#include <cuda_runtime.h>

#include <string>

namespace talik::farm {

// `doing`: "launching 512 blocks", "copying to the GPU".
[[noreturn]] void cuda_failed(cudaError_t error, const std::string& gpu, const std::string& doing);

template <class Doing>
void cuda_check(cudaError_t error, const std::string& gpu, Doing&& doing) {
    if (error != cudaSuccess) [[unlikely]] cuda_failed(error, gpu, doing());
}

} // namespace talik::farm
