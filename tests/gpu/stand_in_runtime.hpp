#pragma once
// The CUDA runtime, as far as Talik calls it, on a machine without a GPU: what the file that talks to GPUs (cuda_device.cpp) is
// tested against. Stricter than a GPU: memory of the device can be touched by nothing but copies and kernels (whoever else does
// crashes), what a stream is given waits until somebody waits for the stream, and any call can be made to fail.
#include <cuda_runtime_api.h>

#include <cstddef>
#include <string>

namespace talik::stand_in {

enum class Pace { late, at_once, at_random }; // when streams do what they are given: when waited for; when given; by a draw

struct Machine {
    int driver = 13000, gpus = 1, compute_capability = 9;
    std::size_t memory = std::size_t{1} << 30; // of a GPU
    Pace pace = Pace::late;
    int failing_call = -1;                     // its number
    cudaError_t error = cudaErrorLaunchFailure;
    bool lost = false;                         // all calls after the failing one fail too, as on a GPU whose kernel has crashed
};

// From here on. What is left of the machine before is forgotten: no device of it may live.
void set(const Machine& machine);

int calls();                  // so far
const std::string& failed();  // the name of the call that failed; empty: none
int copies_of_other_memory(); // copies from or to host memory that is not page-locked: they would not overlap with anything
std::size_t bytes_taken();    // of the memory of devices and of page-locked memory, less what was given back

} // namespace talik::stand_in
