#pragma once
// The CPU in the place of a GPU: the same program, block by block in scrambled order, the threads of each phase in scrambled order,
// on shared memory of exactly the size that the block has asked for, which holds nothing when the block begins. Or with a thread of the
// operating system for each thread of a block, running the whole program at once with the others and meeting them at barriers, as
// on a GPU: for the thread sanitizer. For tests.
#include <cstdint>
#include <memory>
#include <vector>

#include "rve-farm/block/device.hpp"

namespace talik::farm {

class EmulatedDevice : public Device {
public:
    struct Options {
        std::uint64_t seed = 1;
        bool real_threads = false;
        int barrier_left_out = -1; // its number, a fault for tests of the tests; with real threads
        std::size_t shared_bytes_of_a_block = 227 * 1024; // compute capability 9.0
        std::size_t shared_bytes_of_a_multiprocessor = 228 * 1024;
        std::size_t memory = std::size_t{1} << 33;
    };
    EmulatedDevice() : EmulatedDevice(Options()) {}
    explicit EmulatedDevice(Options options) : options_(options) {}

    std::string name() const override { return "an emulated GPU"; }
    std::size_t shared_bytes_of_a_block() const override { return options_.shared_bytes_of_a_block; }
    std::size_t shared_bytes_of_a_multiprocessor() const override { return options_.shared_bytes_of_a_multiprocessor; }
    std::size_t free_bytes() const override { return options_.memory; }
    std::byte* allocate(std::size_t bytes, const std::string& purpose) override;
    std::byte* allocate_on_host(std::size_t bytes, const std::string& purpose) override { return allocate(bytes, purpose); }
    void copy_in(int stream, std::byte* device, const std::byte* host, std::size_t bytes) override;
    void copy_out(int stream, std::byte* host, const std::byte* device, std::size_t bytes) override;
    void launch(int stream, const BlockLaunch& launch) override;
    bool is_done(int) const override { return true; }
    void wait(int) override {}

    std::int64_t launches() const { return launches_; }

private:
    Options options_;
    std::vector<std::unique_ptr<std::byte[]>> memory_;
    std::int64_t launches_ = 0;
};

} // namespace talik::farm
