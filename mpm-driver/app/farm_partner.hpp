#pragma once
// The farms of a run: launched by the driver over shared memory, or met at an exchange that the user names.
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "exchange/channel.hpp"
#include "exchange/process.hpp"

namespace talik::driver {

struct PartnerOptions {
    std::string exchange;        // "shm:NAME", "file:FOLDER", "mpi"; empty = launch farms of our own
    std::string backend = "auto";
    std::vector<std::string> replay; // arguments of `rve-farm replay`, which then answers; empty = `serve`
    int farms = 0;               // 0 = one, or as many as an MPI job has
    int threads = 0;             // of all farms together; 0 = all
    double stall_seconds = 120.0, attach_seconds = 60.0; // of patience: exchange/wait.hpp
    bool quiet = false;
};

// A channel dies before its process: the farm then sees the driver leave, and ends by itself.
class FarmPartner {
public:
    explicit FarmPartner(const PartnerOptions& options);
    std::vector<exchange::Channel*> channels() const;
    std::uint64_t run_id() const { return run_id_; }
    bool may_be_replaced() const; // a farm that is lost; not in an MPI job, which ends with any of its processes

    // Ends what is left of a lost farm; launches another, or waits for one at the same exchange.
    exchange::Channel& another(int farm);

    void state_cause(const std::string& cause);
    bool wishes_to_end() const; // any of them
    void wait_for_their_end();  // after the farewell; of those launched here, for a bounded time

private:
    struct Farm {
        std::unique_ptr<exchange::LaunchedProcess> process;
        std::unique_ptr<exchange::Channel> channel;
    };
    void launch(Farm& farm, const std::string& name) const;
    exchange::WaitLimits limits() const;

    PartnerOptions options_;
    std::uint64_t run_id_;
    int launched_ = 0; // in all: no two share a name
    std::vector<Farm> farms_;
};

} // namespace talik::driver
