#pragma once
// The exchange between two processes of one machine, over a segment of shared memory: two rings of bytes without locks.
// A wait spins for a few microseconds and then sleeps on a futex, so that it takes no core from the farm; every 50 ms at
// the latest it looks whether the partner lives and moves. Frames larger than the ring are streamed through it.
#include <memory>
#include <string>
#include <utility>

#include "exchange/channel.hpp"

namespace talik::exchange {

struct ShmOptions {
    std::size_t ring_bytes = std::size_t(1) << 20;    // of each direction: several chunks of 512 RVEs
    std::function<std::uint64_t()> free_bytes;        // of /dev/shm; empty = ask the system
};

// The driver makes the exchange NAME, the farm joins it. NAME stands in /dev/shm only until the farm has joined.
std::unique_ptr<Channel> make_shm_channel(const std::string& name, const WaitLimits& limits, const ShmOptions& options = {});
std::unique_ptr<Channel> join_shm_channel(const std::string& name, const WaitLimits& limits);
// Both ends in one process over one mapping, for two threads: what the thread sanitizer can look at.
std::pair<std::unique_ptr<Channel>, std::unique_ptr<Channel>> shm_channels_of_one_mapping(const std::string& name, const WaitLimits& limits, const ShmOptions& options = {});

} // namespace talik::exchange
