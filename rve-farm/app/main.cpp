#include <CLI/CLI.hpp>

#include "common/base/idle_threads.hpp"
#include "common/base/error.hpp"
#include "common/base/program.hpp"
#include "exchange/mpi_channel.hpp"
#include "common/base/version.hpp"
#include "rve-farm/app/commands.hpp"

int main(int argc, char** argv) {
    talik::let_idle_threads_sleep(argv);
    CLI::App app("rve-farm: periodic assemblies of discs (RVEs), solved by the discrete element method");
    app.set_version_flag("--version", [] { return talik::build_facts("rve-farm"); });
    app.footer("Examples:\n"
               "  rve-farm element cases/element/dense.toml -o out/dense     a biaxial test of RVEs alone, with its plot\n"
               "  rve-farm pack cases/element/packing.toml -o dense.h5       prepares packings\n"
               "  rve-farm bench --precision single,double                   what an RVE costs on this machine\n"
               "  rve-farm serve --exchange shm:slope                        (and: mpm-driver run scene.toml --exchange shm:slope)\n"
               "  rve-farm status slope                                      how far a run is, and what it waits for");
    app.require_subcommand(1);
    talik::farm::add_pack(app);
    talik::farm::add_element(app);
    talik::farm::add_bench(app);
    int exit = 0;
    talik::farm::add_serve(app, exit);
    talik::farm::add_replay(app, exit);
    talik::farm::add_status(app, exit);
    const int code = talik::run_program([&] {
        try {
            app.parse(argc, argv);
        } catch (const CLI::ParseError& error) {
            if (error.get_exit_code() == 0) return app.exit(error); // --help, --version
            talik::fail(talik::ExitCode::bad_input, error.what(), "see rve-farm --help");
        }
        return exit;
    });
    talik::exchange::end_mpi(code == 0);
    return code;
}
