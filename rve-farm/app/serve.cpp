// rve-farm serve: answers a driver until it says bye.
#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "common/base/error.hpp"
#include "common/base/version.hpp"
#include "rve-farm/app/commands.hpp"
#include "rve-farm/app/kernel_options.hpp"
#include "rve-farm/app/partner.hpp"
#include "rve-farm/backend/service.hpp"

namespace talik::farm {
namespace {

struct ServeOptions {
    PartnerOptions partner;
    KernelOptions kernel;
    int threads = 0;
};

int serve(const ServeOptions& options) {
    FarmOptions farm;
    farm.threads = options.threads;
    options.kernel.choose(farm);
    if (!options.partner.launched) require_gpu(farm.backend); // else the driver is told when it sets the farm up
    return serve_driver(options.partner, [&](exchange::Channel& channel) {
        Service service(farm);
        exchange::FarmEnd(channel, service, "rve-farm " + version()).serve();
    });
}

} // namespace

void add_serve(CLI::App& app, int& exit) {
    auto options = std::make_shared<ServeOptions>();
    CLI::App* command = app.add_subcommand("serve", "Answers a driver: strain increments in, stresses out");
    command->footer("Examples:\n"
                    "  rve-farm serve --exchange shm:slope --threads 2      (and: mpm-driver run scene.toml --exchange shm:slope)\n"
                    "  mpirun -n 1 mpm-driver run scene.toml --exchange mpi : -n 4 rve-farm serve --exchange mpi");
    options->partner.add_to(*command);
    options->kernel.add_to(*command);
    command->add_option("--threads", options->threads, "0 = all")->check(CLI::NonNegativeNumber);
    command->callback([options, &exit] { exit = serve(*options); });
}

} // namespace talik::farm
