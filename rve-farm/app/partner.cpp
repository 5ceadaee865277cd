#include "rve-farm/app/partner.hpp"

#include <CLI/CLI.hpp>

#include <memory>

#include "common/base/error.hpp"
#include "common/base/interrupt.hpp"
#include "common/base/log.hpp"
#include "exchange/mpi_channel.hpp"
#include "exchange/run_board.hpp"
#include "exchange/transport.hpp"

namespace talik::farm {
namespace {

std::unique_ptr<exchange::Channel> join(const PartnerOptions& options) {
    exchange::WaitLimits limits;
    limits.stall_seconds = options.stall_seconds;
    limits.attach_seconds = options.attach_seconds;
    if (exchange::is_mpi(options.exchange)) exchange::begin_mpi(exchange::Role::farm);
    return exchange::join_exchange(options.exchange, limits);
}

} // namespace

void PartnerOptions::add_to(CLI::App& command) {
    command.add_option("--exchange", exchange, "shm:NAME, file:FOLDER or mpi")->required();
    command.add_option("--stall-seconds", stall_seconds, "how long a silent driver is waited for")->check(CLI::PositiveNumber)->capture_default_str();
    command.add_option("--attach-seconds", attach_seconds, "how long the exchange is waited for")->check(CLI::PositiveNumber)->capture_default_str();
    command.add_flag("--quiet", quiet, "warnings and errors only");
    command.add_flag("--launched", launched, "by a driver that quotes the farm's faults: they are not printed here as well")->group("");
}

int serve_driver(const PartnerOptions& options, const std::function<void(exchange::Channel&)>& body) {
    log::start("rve-farm", options.quiet);
    watch_interrupts();
    std::unique_ptr<exchange::Channel> channel;
    try {
        exchange::publish_run_board(exchange::Role::farm, options.exchange);
        channel = join(options);
        exchange::with_cause(*channel, [&] { body(*channel); });
    } catch (const Error& error) {
        // Before it has met the driver, only the driver's own end, or the Ctrl-C that both got, ends it without a word.
        const bool known_to_the_driver = channel ? error.code() != ExitCode::partner_lost || !channel->partner_cause().empty() : interrupted();
        if (!options.launched || !known_to_the_driver) throw;
        return static_cast<int>(error.code());
    }
    return 0;
}

} // namespace talik::farm
