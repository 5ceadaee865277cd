#pragma once
// One device that runs blocks: its memory, its copies, its launches. Every call that fails is an Error that says what was asked for.
// A GPU (cuda_device.cu), or the CPU in its place (emulated_device.hpp), so that all that is built on it can be tested anywhere.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/physics/rve_parameters.hpp"
#include "rve-farm/block/block_task.hpp"
#include "rve-farm/kernel/kernel.hpp"

namespace talik::farm {

// Blocks that are alike: precision, effects and the ledger are of one farm, threads and shared memory of the largest RVE.
struct BlockLaunch {
    const RveParameters* parameters = nullptr;
    Precision precision = Precision::double_;
    bool ledger = false;
    bool spread = false; // part of the working memory is not shared: the slower variant
    int threads = 0;
    std::size_t shared_bytes = 0;
    const BlockRve* rves = nullptr;   // on the device, as are
    const BlockTask* tasks = nullptr; // these
    BlockResult* results = nullptr;
    int blocks = 0; // tasks
};

class Device {
public:
    virtual ~Device() = default;

    virtual std::string name() const = 0;
    virtual std::size_t shared_bytes_of_a_block() const = 0;          // the most that a block can have
    virtual std::size_t shared_bytes_of_a_multiprocessor() const = 0; // of all blocks on it
    virtual std::size_t free_bytes() const = 0;

    // Memory that is given back with the device. `purpose` is what the user is told where there is not enough.
    virtual std::byte* allocate(std::size_t bytes, const std::string& purpose) = 0;
    virtual std::byte* allocate_on_host(std::size_t bytes, const std::string& purpose) = 0; // from which copies can go while others compute

    // Streams are numbered; what is on one of them happens in order. One besides those of the batches.
    static constexpr int batch_streams = 4, streams = batch_streams + 1;
    virtual void copy_in(int stream, std::byte* device, const std::byte* host, std::size_t bytes) = 0;
    virtual void copy_out(int stream, std::byte* host, const std::byte* device, std::size_t bytes) = 0;
    virtual void launch(int stream, const BlockLaunch& launch) = 0;
    virtual bool is_done(int stream) const = 0; // all that is on it
    virtual void wait(int stream) = 0;          // until it is
};

// The GPUs of this machine; why there are none, where there are none.
struct Gpus {
    std::vector<std::shared_ptr<Device>> devices;
    std::string reason;
};
Gpus open_gpus();
// The build has the backend.
bool built_with_cuda();

} // namespace talik::farm
