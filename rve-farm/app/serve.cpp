// rve-farm serve: answers a driver until it says bye.
#include <CLI/CLI.hpp>
#include <unistd.h>

#include <memory>
#include <string>

#include "common/base/error.hpp"
#include "common/base/interrupt.hpp"
#include "common/base/log.hpp"
#include "common/base/version.hpp"
#include "exchange/shm_channel.hpp"
#include "rve-farm/app/commands.hpp"
#include "rve-farm/app/kernel_options.hpp"
#include "rve-farm/backend/service.hpp"

namespace talik::farm {
namespace {

struct ServeOptions {
    std::string exchange;
    KernelOptions kernel;
    int threads = 0;
    double stall_seconds = 120.0, attach_seconds = 60.0;
    bool quiet = false;
    bool launched = false; // by a driver, which quotes what goes wrong here: on one terminal one fault is one line
};

std::unique_ptr<exchange::Channel> join(const ServeOptions& options) {
    exchange::WaitLimits limits;
    limits.stall_seconds = options.stall_seconds;
    limits.attach_seconds = options.attach_seconds;
    const std::string shm = "shm:";
    require(options.exchange.starts_with(shm) && options.exchange.size() > shm.size(), "--exchange " + options.exchange + ": no such transport",
            "give shm:NAME, with the name that the driver uses");
    return exchange::join_shm_channel(options.exchange.substr(shm.size()), limits);
}

int serve(const ServeOptions& options) {
    FarmOptions farm;
    farm.threads = options.threads;
    options.kernel.choose(farm);
    if (!options.launched) require_gpu(farm.backend); // else the driver is told when it sets the farm up
    log::start("rve-farm", options.quiet);
    watch_interrupts();
    std::unique_ptr<exchange::Channel> channel;
    try {
        channel = join(options);
        exchange::with_cause(*channel, [&] {
            Service service(farm);
            exchange::FarmEnd(*channel, service, "rve-farm " + version()).serve();
        });
    } catch (const Error& error) {
        // Before it has met the driver, only the driver's own end, or the Ctrl-C that both got, ends it without a word.
        const bool known_to_the_driver = channel ? error.code() != ExitCode::partner_lost || !channel->partner_cause().empty() : interrupted();
        if (!options.launched || !known_to_the_driver) throw;
        return static_cast<int>(error.code());
    }
    return 0;
}

} // namespace

void add_serve(CLI::App& app, int& exit) {
    auto options = std::make_shared<ServeOptions>();
    CLI::App* command = app.add_subcommand("serve", "Answers a driver: strain increments in, stresses out");
    command->footer("Examples:\n"
                    "  rve-farm serve --exchange shm:slope --threads 2      (and: mpm-driver run scene.toml --exchange shm:slope)");
    command->add_option("--exchange", options->exchange, "shm:NAME")->required();
    options->kernel.add_to(*command);
    command->add_option("--threads", options->threads, "0 = all")->check(CLI::NonNegativeNumber);
    command->add_option("--stall-seconds", options->stall_seconds, "how long a silent driver is waited for")->check(CLI::PositiveNumber);
    command->add_option("--attach-seconds", options->attach_seconds, "how long the exchange is waited for")->check(CLI::PositiveNumber);
    command->add_flag("--quiet", options->quiet, "warnings and errors only");
    command->add_flag("--launched", options->launched, "by a driver that quotes the farm's faults: they are not printed here as well")->group("");
    command->callback([options, &exit] { exit = serve(*options); });
}

} // namespace talik::farm
