#pragma once
// The farm of a run: launched by the driver over shared memory, or met at an exchange that the user names.
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "exchange/channel.hpp"
#include "exchange/process.hpp"

namespace talik::driver {

struct PartnerOptions {
    std::string exchange;        // "shm:NAME"; empty = launch a farm of our own
    std::string backend = "auto";
    std::vector<std::string> replay; // arguments of `rve-farm replay`, which then answers; empty = `serve`
    int threads = 0;             // of the farm; 0 = all
    double stall_seconds = 120.0, attach_seconds = 60.0; // of patience: exchange/wait.hpp
    bool quiet = false;
};

// The channel dies before the process: the farm then sees the driver leave, and ends by itself.
class FarmPartner {
public:
    explicit FarmPartner(const PartnerOptions& options);
    exchange::Channel& channel() { return *channel_; }
    std::uint64_t run_id() const { return run_id_; }

private:
    std::uint64_t run_id_;
    std::unique_ptr<exchange::LaunchedProcess> process_;
    std::unique_ptr<exchange::Channel> channel_;
};

} // namespace talik::driver
