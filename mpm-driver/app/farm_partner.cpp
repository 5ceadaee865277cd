#include "mpm-driver/app/farm_partner.hpp"

#include <fmt/format.h>
#include <omp.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>

#include "common/base/error.hpp"
#include "common/base/installation.hpp"
#include "exchange/run_board.hpp"
#include "exchange/transport.hpp"

namespace talik::driver {
namespace {

// Differs between any two runs of this machine, and need not be reproducible: it only tells runs apart.
std::uint64_t fresh_run_id() {
    const auto now = static_cast<std::uint64_t>(std::chrono::system_clock::now().time_since_epoch().count());
    return (now << 16) ^ static_cast<std::uint64_t>(::getpid());
}

} // namespace

FarmPartner::FarmPartner(const PartnerOptions& options) : options_(options), run_id_(fresh_run_id()) {
    exchange::run_board().run_id = run_id_;
    if (!options_.exchange.empty()) {
        for (auto& channel : exchange::make_exchange(options_.exchange, options_.farms, limits())) farms_.push_back({nullptr, std::move(channel)});
        return;
    }
    // Each is a process with threads of its own: what is far more than the cores only brings the machine down.
    const int cores = omp_get_num_procs(), most = std::max(8, 4 * cores);
    require(options_.farms <= most, fmt::format("--farms {}: at most {} farms are launched on this machine of {} cores", options_.farms, most, cores),
            "give fewer; or start farms on other machines (docs/farms.md)");
    farms_.resize(static_cast<std::size_t>(std::max(1, options_.farms)));
    for (Farm& farm : farms_) launch(farm, fmt::format("{:x}-{}", run_id_, launched_++));
}

exchange::WaitLimits FarmPartner::limits() const {
    exchange::WaitLimits limits;
    limits.stall_seconds = options_.stall_seconds;
    limits.attach_seconds = options_.attach_seconds;
    return limits;
}

void FarmPartner::launch(Farm& farm, const std::string& name) const {
    farm.channel = exchange::make_exchange("shm:" + name, limits());
    std::vector<std::string> command = {sibling_program("rve-farm").string()};
    const bool replays = !options_.replay.empty();
    if (replays)
        command.insert(command.end(), "replay"), command.insert(command.end(), options_.replay.begin(), options_.replay.end());
    else
        command.insert(command.end(), {"serve", "--backend", options_.backend});
    command.insert(command.end(), {"--exchange", "shm:" + name, "--launched", "--stall-seconds", fmt::format("{}", options_.stall_seconds)});
    const int farms = static_cast<int>(farms_.size());
    const int threads = options_.threads > 0 || farms == 1 ? options_.threads : omp_get_num_procs();
    if (threads > 0 && !replays) command.insert(command.end(), {"--threads", std::to_string(std::max(1, threads / farms))});
    if (options_.quiet) command.push_back("--quiet");
    farm.process = std::make_unique<exchange::LaunchedProcess>(command, exchange::Interrupts::held);
    farm.channel->ask_fate([process = farm.process.get()] { return process->fate(); });
}

exchange::Channel& FarmPartner::another(int index) {
    Farm& farm = farms_[static_cast<std::size_t>(index)];
    const bool launched = farm.process != nullptr;
    farm.channel.reset();
    if (farm.process) farm.process->end_now(); // one that is stopped would wait for its turn to end in order
    farm.process.reset();
    if (launched)
        launch(farm, fmt::format("{:x}-{}", run_id_, launched_++));
    else
        farm.channel = exchange::make_exchange(exchange::address_of_farm(options_.exchange, index), limits());
    return *farm.channel;
}

bool FarmPartner::may_be_replaced() const { return !exchange::is_mpi(options_.exchange); }

std::vector<exchange::Channel*> FarmPartner::channels() const {
    std::vector<exchange::Channel*> channels;
    for (const Farm& farm : farms_) channels.push_back(farm.channel.get());
    return channels;
}

void FarmPartner::state_cause(const std::string& cause) {
    for (Farm& farm : farms_)
        if (farm.channel) farm.channel->state_cause(cause);
}

void FarmPartner::wait_for_their_end() {
    constexpr double enough = 5.0; // s, for a program that has nothing left to do
    for (Farm& farm : farms_)
        if (farm.process) farm.process->wait(enough);
}

bool FarmPartner::wishes_to_end() const {
    return std::any_of(farms_.begin(), farms_.end(), [](const Farm& farm) { return farm.channel && farm.channel->partner_wishes_to_end(); });
}

} // namespace talik::driver
