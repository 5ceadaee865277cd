#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>

#include "common/base/error.hpp"
#include "common/base/installation.hpp"
#include "common/base/interrupt.hpp"
#include "common/base/log.hpp"
#include "common/base/option_ranges.hpp"
#include "common/base/idle_threads.hpp"
#include "common/base/program.hpp"
#include "common/base/version.hpp"
#include "common/scene/units.hpp"
#include "exchange/mpi_channel.hpp"
#include "mpm-driver/app/explain.hpp"
#include "mpm-driver/app/run.hpp"
#include "mpm-driver/app/scene_schema.hpp"
#include "mpm-driver/app/scene_tables.hpp"

namespace {

using namespace talik;
using namespace talik::driver;

// "90", "20 d": a time above zero, as in a scene.
CLI::Validator a_time() {
    return CLI::Validator([](std::string& text) {
        const scene::ReadQuantity time = scene::read_quantity(text, scene::Dimension::time);
        if (!time.problem.empty()) return fmt::format("{} ({})", time.problem, time.remedy);
        return time.value > 0.0 ? std::string() : "must be a time > 0, not \"" + text + "\"";
    }, "TIME");
}

// Every fault of a scene, a line each.
int check(const std::string& scene, const std::vector<std::string>& set) {
    const auto faults = check_scene(scene, set);
    for (const auto& fault : faults) fmt::print(stderr, "error: {}\n", fault.text());
    if (faults.empty()) {
        for (const auto& warning : seeding_warnings(read_scene(scene, set))) fmt::print(stderr, "warning: {}\n", warning);
        fmt::print("{}: sound\n", scene);
    }
    return faults.empty() ? 0 : 2;
}

} // namespace

int main(int argc, char** argv) {
    talik::let_idle_threads_sleep(argv);
    CLI::App app("mpm-driver: granular ground by the material point method, with a DEM assembly in every point");
    app.set_version_flag("--version", [] { return build_facts("mpm-driver"); });
    app.footer("Examples:\n"
               "  mpm-driver check cases/biaxial/dense.toml\n"
               "  mpm-driver explain cases/biaxial/dense.toml\n"
               "  mpm-driver run cases/biaxial/dense.toml --output out/dense   (installed: mpm-driver run biaxial/dense)\n"
               "  mpm-driver --help-scene                 every key of a scene");
    bool help_scene = false, markdown_scene = false;
    app.add_flag("--help-scene", help_scene, "every key of a scene: unit, default, range, meaning");
    app.add_flag("--help-scene-markdown", markdown_scene, "the same as Markdown: docs/scene.md");
    app.require_subcommand(0, 1);
    int exit = 0;

    RunOptions options;
    std::string until;
    CLI::App* run_command = app.add_subcommand("run", "Runs a scene, with a farm of RVEs where it calls for one");
    run_command->footer("Examples:\n"
                        "  mpm-driver run scene.toml --set stage.0.duration=\"0.2 s\" --set rve.contact.friction=0.3\n"
                        "  mpm-driver run scene.toml --output out/a --restart out/a/checkpoint-000001200\n"
                        "  mpm-driver run scene.toml --record record.h5        (then, without any DEM: --replay record.h5)\n"
                        "  mpm-driver run scene.toml --exchange shm:slope      (and: rve-farm serve --exchange shm:slope)\n"
                        "  mpm-driver run scene.toml --exchange file:/shared/slope      (and there: tail -f /shared/slope/driver.log)\n"
                        "  mpirun -n 1 mpm-driver run scene.toml --exchange mpi : -n 4 rve-farm serve --exchange mpi");
    run_command->add_option("scene", options.scene, "SCENE.toml")->required();
    run_command->add_option("--output", options.output, "folder for everything the run leaves (default: out/<scene>)")->check(not_empty());
    run_command->add_option("--exchange", options.exchange, "shm:NAME or file:FOLDER: meet a farm there instead of launching one; mpi: those of the MPI job");
    run_command->add_option("--farms", options.farms, "that share the RVEs (default: one, or as many as the MPI job has); at NAME, NAME.1, ...")->check(CLI::Range(1, 4096));
    run_command->add_option("--restart", options.restart, "go on from this checkpoint")->check(not_empty());
    run_command->add_option("--record", options.record, "writes every request to the farm and every answer there (HDF5)")->check(not_empty());
    run_command->add_option("--replay", options.replay, "a recording answers instead of a farm, strictly: the run must be the recorded one")->check(not_empty());
    run_command->add_flag("--loose", options.loose, "with --replay: each RVE answers with what was recorded nearest to its deformation");
    run_command->add_option("--tolerance", options.tolerance, "with --replay: how far requests may be from the recorded ones, relative (1e-9)")->check(CLI::NonNegativeNumber);
    auto* until_option = run_command->add_option("--until", until, "stop at this simulated time: 90 (s), \"20 d\"")->check(a_time());
    run_command->add_option("--set", options.set, "KEY=VALUE: overrides a key of the scene (repeatable)");
    run_command->add_option("--threads", options.threads, "of the farm and of the driver; 0 = all")->check(thread_count());
    run_command->add_option("--backend", options.backend, "of the farm: auto, cpu or cuda")->check(CLI::IsMember({"auto", "cpu", "cuda"}));
    run_command->add_option("--stall-seconds", options.stall_seconds, "how long a farm that does not move is waited for")->check(above_zero())->capture_default_str();
    run_command->add_option("--attach-seconds", options.attach_seconds, "how long a farm is waited for to come to the exchange")->check(above_zero())->capture_default_str();
    run_command->add_flag("--quiet", options.quiet, "warnings and errors only");
    run_command->callback([&] {
        if (until_option->count() > 0) options.until = scene::read_quantity(until, scene::Dimension::time).value;
        log::start("mpm-driver", options.quiet);
        watch_interrupts();
        options.scene = find_case(options.scene);
        exit = run(options);
    });

    std::string scene;
    std::vector<std::string> set;
    int threads = 0;
    CLI::App* explain_command = app.add_subcommand("explain", "What a scene calls for and what it will cost, without a run");
    explain_command->add_option("scene", scene, "SCENE.toml")->required();
    explain_command->add_option("--set", set, "KEY=VALUE: overrides a key of the scene (repeatable)");
    explain_command->add_option("--threads", threads, "that a run would have; 0 = all")->check(thread_count());
    explain_command->callback([&] {
        log::start("mpm-driver", false);
        exit = explain(find_case(scene), set, threads);
    });

    CLI::App* check_command = app.add_subcommand("check", "Validates a scene: every fault in it at once");
    check_command->add_option("scene", scene, "SCENE.toml")->required();
    check_command->add_option("--set", set, "KEY=VALUE: overrides a key of the scene (repeatable)");
    check_command->callback([&] { exit = check(find_case(scene), set); });

    const int code = run_program([&] {
        try {
            app.parse(argc, argv);
        } catch (const CLI::ParseError& error) {
            if (error.get_exit_code() == 0) return app.exit(error); // --help, --version
            fail(ExitCode::bad_input, error.what(), "see mpm-driver --help");
        }
        if (help_scene || markdown_scene) {
            fmt::print("{}", markdown_scene ? scene_markdown() : scene_help());
            return 0;
        }
        if (app.get_subcommands().empty()) {
            fmt::print("{}", app.help());
            return 2;
        }
        return exit;
    });
    exchange::end_mpi(code == 0);
    return code;
}
