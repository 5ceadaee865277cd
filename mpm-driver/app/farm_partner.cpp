#include "mpm-driver/app/farm_partner.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>

#include "common/base/error.hpp"
#include "common/base/installation.hpp"
#include "exchange/run_board.hpp"
#include "exchange/shm_channel.hpp"

namespace talik::driver {
namespace {

// Differs between any two runs of this machine, and need not be reproducible: it only tells runs apart.
std::uint64_t fresh_run_id() {
    const auto now = static_cast<std::uint64_t>(std::chrono::system_clock::now().time_since_epoch().count());
    return (now << 16) ^ static_cast<std::uint64_t>(::getpid());
}

std::string exchange_name(const PartnerOptions& options, std::uint64_t run_id) {
    if (options.exchange.empty()) return fmt::format("{:x}", run_id);
    const std::string shm = "shm:";
    require(options.exchange.starts_with(shm) && options.exchange.size() > shm.size(), "--exchange " + options.exchange + ": no such transport",
            "give shm:NAME and start `rve-farm serve --exchange shm:NAME`, or leave the option out");
    return options.exchange.substr(shm.size());
}

} // namespace

FarmPartner::FarmPartner(const PartnerOptions& options) : run_id_(fresh_run_id()) {
    const std::string name = exchange_name(options, run_id_);
    exchange::run_board().run_id = run_id_;
    exchange::WaitLimits limits;
    limits.stall_seconds = options.stall_seconds;
    limits.attach_seconds = options.attach_seconds;
    channel_ = exchange::make_shm_channel(name, limits);
    if (!options.exchange.empty()) return;
    std::vector<std::string> command = {sibling_program("rve-farm").string()};
    if (options.replay.empty())
        command.insert(command.end(), {"serve", "--backend", options.backend});
    else
        command.insert(command.end(), "replay"), command.insert(command.end(), options.replay.begin(), options.replay.end());
    command.insert(command.end(), {"--exchange", "shm:" + name, "--launched", "--stall-seconds", fmt::format("{}", options.stall_seconds)});
    if (options.threads > 0 && options.replay.empty()) command.insert(command.end(), {"--threads", std::to_string(options.threads)});
    if (options.quiet) command.push_back("--quiet");
    process_ = std::make_unique<exchange::LaunchedProcess>(command, exchange::Interrupts::held);
    channel_->ask_fate([process = process_.get()] { return process->fate(); });
}

} // namespace talik::driver
