// rve-farm element: element tests on RVEs.
#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <memory>

#include "common/base/error.hpp"
#include "common/base/installation.hpp"
#include "common/base/log.hpp"
#include "common/base/option_ranges.hpp"
#include "common/base/progress.hpp"
#include "common/packing/packing_file.hpp"
#include "exchange/process.hpp"
#include "rve-farm/app/commands.hpp"
#include "rve-farm/app/kernel_options.hpp"
#include "rve-farm/app/specification.hpp"
#include "rve-farm/element/element_doubts.hpp"
#include "rve-farm/element/element_output.hpp"
#include "rve-farm/packing/prepare.hpp"

namespace talik::farm {
namespace {

namespace fs = std::filesystem;

struct ElementOptions {
    std::string specification, output = "out/element";
    std::vector<std::string> overrides;
    int threads = 0;
    KernelOptions kernel;
    bool quiet = false, keys = false, plot = true;
};

std::vector<Packing> packings_of(const RveSpec& rve, int threads, bool quiet) {
    if (!rve.packing.file.empty()) return read_packings(rve.packing.file);
    Progress progress("packings", quiet || !rve.packing.by_specification());
    return prepare_packings(rve, threads, [&](int done, const std::string& note) { progress.update(static_cast<double>(done) / rve.packing.count, fmt::format("{} of {}  {}", done, rve.packing.count, note)); });
}

// tools/plot of the source tree this program was built in, where it is there.
void plot(const std::string& folder) {
    const fs::path tool = fs::read_symlink("/proc/self/exe").parent_path().parent_path().parent_path() / "tools" / "plot";
    if (!fs::exists(tool)) return;
    exchange::LaunchedProcess process({tool.string(), folder});
    while (!process.wait(1.0)) {}
    if (process.exit_code() != 0) log::warn("no picture: {} {}", tool.string(), process.fate().value_or("ended"));
}

void element(const ElementOptions& options) {
    if (options.keys) {
        std::fputs(element_help().c_str(), stdout);
        return;
    }
    require(!options.specification.empty(), "element: a specification is needed", "see rve-farm element --help");
    log::start("rve-farm", options.quiet);
    std::string dump;
    const ElementSpec spec = read_element_specification(find_case(options.specification), options.overrides, dump);
    const auto packings = packings_of(spec.rve, options.threads, options.quiet);
    for (const std::string& doubt : doubts_before(spec.test, packings)) log::warn("{}", doubt);
    FarmOptions farm;
    farm.threads = options.threads;
    options.kernel.choose(farm);
    std::vector<ElementCurve> curves;
    {
        Progress progress(spec.test.path, options.quiet);
        curves = run_element_test(spec.test, spec.rve.parameters, packings, farm,
                                  [&](double fraction) { progress.update(fraction, fmt::format("strain {:.2f} %", 100.0 * fraction * spec.test.strain)); });
    }
    write_element_curves(options.output, spec.title.empty() ? spec.test.path : spec.title, dump, curves);
    if (!options.quiet) log::info("{} curve(s) in {}", curves.size(), options.output);
    for (const std::string& doubt : doubts_after(spec.test, curves)) log::warn("{}", doubt);
    if (options.plot) plot(options.output);
    refuse_nonsense(spec.test, curves);
}

} // namespace

void add_element(CLI::App& app) {
    auto options = std::make_shared<ElementOptions>();
    CLI::App* command = app.add_subcommand("element", "Drives RVEs along a path: isotropic, biaxial, isochoric, simple shear");
    command->footer("Examples:\n"
                    "  rve-farm element biaxial.toml -o out/biaxial\n"
                    "  rve-farm element biaxial.toml -o out/loose --set rve.packing.file=loose.h5 --set test.strain=0.2\n"
                    "where biaxial.toml reads:\n"
                    "  [rve.packing]\n  file = \"dense.h5\"\n  [rve.contact]\n  friction = 0.5\n"
                    "  [test]\n  path = \"biaxial\"\n  rate = \"0.1 1/s\"\n  strain = 0.15\n  pressure = \"100 kPa\"");
    command->add_option("specification", options->specification, "TOML file; --keys lists what it may hold");
    command->add_option("-o,--output", options->output, "folder of the curves (CSV and HDF5)");
    command->add_option("--set", options->overrides, "key=value, overrides the file (repeatable)")->allow_extra_args(false);
    command->add_option("--threads", options->threads, "0 = all; the curves do not depend on it")->check(thread_count());
    options->kernel.add_to(*command);
    command->add_flag("!--no-plot", options->plot, "writes the curves without a picture");
    command->add_flag("--quiet", options->quiet, "warnings and errors only");
    command->add_flag("--keys", options->keys, "lists every key of a test");
    command->callback([options] { element(*options); });
}

} // namespace talik::farm
