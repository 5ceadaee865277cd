// rve-farm pack: prepares periodic packings.
#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>

#include "common/base/error.hpp"
#include "common/base/installation.hpp"
#include "common/base/log.hpp"
#include "common/base/option_ranges.hpp"
#include "common/base/progress.hpp"
#include "common/packing/packing_file.hpp"
#include "rve-farm/app/commands.hpp"
#include "rve-farm/app/specification.hpp"
#include "rve-farm/packing/prepare.hpp"

namespace talik::farm {
namespace {

struct PackOptions {
    std::string specification, output;
    std::vector<std::string> overrides;
    int threads = 0;
    bool quiet = false, keys = false;
};

// Before the work: minutes of it would be lost on a file that cannot be written.
void check_output(const std::string& file) {
    namespace fs = std::filesystem;
    const char* mend = "give -o the name of an HDF5 file in a folder you may write to";
    const auto refuse = [&](const std::string& why) { throw Error(ExitCode::bad_input, file, why, mend); };
    const fs::path folder = fs::path(file).has_parent_path() ? fs::path(file).parent_path() : fs::path(".");
    if (!fs::is_directory(folder)) refuse("its folder does not exist");
    check_place_of_packings(file);
    if (::access(folder.c_str(), W_OK | X_OK) != 0 || (fs::exists(file) && ::access(file.c_str(), W_OK) != 0)) refuse(std::string("cannot be written: ") + std::strerror(errno));
}

// One line for each seed: its packing, or both ends of its K0 path.
void say_what_was_made(const std::vector<Packing>& packings) {
    for (std::size_t first = 0, last = 0; first < packings.size(); first = last + 1) {
        const Packing& p = packings[first];
        for (last = first; last + 1 < packings.size() && packings[last + 1].seed == p.seed; ++last) {}
        const Packing& q = packings[last];
        if (p.vertical_stress <= 0.0) log::info("seed {}: {} discs, void ratio {:.4f}, {:.1f} kPa", p.seed, p.disc_count(), p.void_ratio(), 1e-3 * p.pressure);
        else log::info("seed {}: {} discs, {} snapshot(s) from {:.3g} to {:.3g} kPa vertical stress, void ratio {:.4f} to {:.4f}, K0 {:.3f} to {:.3f}", p.seed, p.disc_count(), last - first + 1,
                       1e-3 * p.vertical_stress, 1e-3 * q.vertical_stress, p.void_ratio(), q.void_ratio(), p.lateral_stress / p.vertical_stress, q.lateral_stress / q.vertical_stress);
    }
}

void pack(const PackOptions& options) {
    if (options.keys) {
        std::fputs(pack_help().c_str(), stdout);
        return;
    }
    require(!options.specification.empty() && !options.output.empty(), "pack: a specification and -o are needed", "see rve-farm pack --help");
    log::start("rve-farm", options.quiet);
    check_output(options.output);
    std::string dump;
    const RveSpec spec = read_pack_specification(find_case(options.specification), options.overrides, dump);
    std::vector<Packing> packings;
    {
        Progress progress("packings", options.quiet);
        const double count = spec.packing.count;
        packings = prepare_packings(spec, options.threads, [&](int done, const std::string& note) { progress.update(done / count, fmt::format("{} of {}  {}", done, spec.packing.count, note)); });
    }
    write_packings(options.output, "rve-farm", packings, dump);
    if (!options.quiet) say_what_was_made(packings);
}

} // namespace

void add_pack(CLI::App& app) {
    auto options = std::make_shared<PackOptions>();
    CLI::App* command = app.add_subcommand("pack", "Prepares periodic packings at a void ratio and a pressure, or from CSV");
    command->footer("Examples:\n"
                    "  rve-farm pack dense.toml -o dense.h5\n"
                    "  rve-farm pack dense.toml -o loose.h5 --set rve.packing.void_ratio=0.235 --set rve.packing.count=8\n"
                    "where dense.toml holds the [rve] tables of a scene:\n"
                    "  [rve.packing]\n  discs = 400\n  void_ratio = 0.161\n  pressure = \"100 kPa\"\n  seed = 1\n"
                    "  [rve.contact]\n  friction = 0.5");
    command->add_option("specification", options->specification, "TOML file; --keys lists what it may hold");
    command->add_option("-o,--output", options->output, "HDF5 file of packings");
    command->add_option("--set", options->overrides, "key=value, overrides the file (repeatable)")->allow_extra_args(false);
    command->add_option("--threads", options->threads, "0 = all; the packings do not depend on it")->check(thread_count());
    command->add_flag("--quiet", options->quiet, "warnings and errors only");
    command->add_flag("--keys", options->keys, "lists every key of a specification");
    command->callback([options] { pack(*options); });
}

} // namespace talik::farm
