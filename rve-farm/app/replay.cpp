// rve-farm replay: the recorded-stress surrogate of a farm.
#include <CLI/CLI.hpp>

#include <memory>
#include <string>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "common/base/option_ranges.hpp"
#include "common/base/version.hpp"
#include "rve-farm/app/commands.hpp"
#include "rve-farm/app/partner.hpp"
#include "rve-farm/replay/replay_service.hpp"

namespace talik::farm {

void add_replay(CLI::App& app, int& exit) {
    struct Options {
        std::string record;
        PartnerOptions partner;
        ReplayOptions replay;
    };
    auto options = std::make_shared<Options>();
    CLI::App* command = app.add_subcommand("replay", "Answers a driver from a recording of an earlier run, without any DEM");
    command->footer("Examples:\n"
                    "  mpm-driver run scene.toml --record record.h5\n"
                    "  mpm-driver run scene.toml --replay record.h5          (starts rve-farm replay by itself)\n"
                    "  rve-farm replay record.h5 --exchange shm:slope       (and: mpm-driver run scene.toml --exchange shm:slope)\n"
                    "  rve-farm replay record.h5 --exchange shm:slope --loose   other steps than recorded: nearest answers");
    command->add_option("record", options->record, "RECORD.h5")->required();
    options->partner.add_to(*command);
    command->add_option("--tolerance", options->replay.tolerance, "of a request, relative to the largest of its component in the step; 0 = to the bit")->check(CLI::NonNegativeNumber)->capture_default_str();
    command->add_flag("--loose", options->replay.loose, "answer with what was recorded at the nearest deformation and ice, whatever the step");
    command->callback([options, &exit] {
        exit = serve_driver(options->partner, [&](exchange::Channel& channel) {
            ReplayService service(options->record, options->replay);
            exchange::FarmEnd(channel, service, "rve-farm " + version() + ", replay of " + options->record).serve();
            log::info("{}", service.report());
            if (options->replay.loose) log::warn("{}", "a loose replay is no solution: its stresses are those of another history");
        });
    });
}

} // namespace talik::farm
