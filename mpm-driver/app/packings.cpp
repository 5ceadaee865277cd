#include "mpm-driver/app/packings.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>

#include "common/base/error.hpp"
#include "common/base/interrupt.hpp"
#include "common/base/log.hpp"
#include "common/io/text_file.hpp"
#include "common/packing/packing_csv.hpp"
#include "common/packing/packing_file.hpp"
#include "common/scene/rve_tables.hpp"
#include "exchange/process.hpp"

namespace talik::driver {
namespace {

namespace fs = std::filesystem;

// Prepares under a name of its own and renames: two runs at once do not meet, a half is never used.
fs::path prepare(const RveSpec& rve, int threads, bool quiet) {
    const fs::path target = cache_folder() / "packings" / (scene::packing_fingerprint(rve) + ".h5");
    if (fs::exists(target)) return target;
    make_folder(target.parent_path());
    const fs::path part = target.string() + "." + std::to_string(::getpid()) + ".part";
    const fs::path specification = part.string() + ".toml";
    write_file_atomically(specification, scene::packing_specification(rve));
    if (!quiet) log::info("preparing {} packing(s) of {} discs, once; kept as {}", rve.packing.count, rve.packing.discs, target.string());

    std::vector<std::string> command = {sibling_program("rve-farm").string(), "pack", specification.string(), "-o", part.string()};
    if (threads > 0) command.insert(command.end(), {"--threads", std::to_string(threads)});
    if (quiet) command.push_back("--quiet");
    exchange::LaunchedProcess pack(command);
    while (!pack.wait(0.1) && !interrupted()) {}
    std::error_code ignored;
    fs::remove(specification, ignored);
    if (interrupted()) fail(ExitCode::failed, fmt::format("stopped by {} while the packings were prepared", interrupt_name()), "run it again");
    const auto code = pack.exit_code();
    if (code != 0) {
        fs::remove(part, ignored);
        fail(code ? static_cast<ExitCode>(*code) : ExitCode::failed, "the packings could not be prepared: rve-farm pack " + pack.fate().value_or("ended"),
             "its own line above says why; mend [rve.packing]");
    }
    fs::rename(part, target);
    return target;
}

} // namespace

fs::path cache_folder() {
    if (const char* own = std::getenv("TALIK_CACHE"); own && *own) return own;
    if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache && *cache) return fs::path(cache) / "talik";
    const char* home = std::getenv("HOME");
    return (home && *home ? fs::path(home) / ".cache" : fs::temp_directory_path()) / "talik";
}

fs::path sibling_program(const std::string& name) { return fs::read_symlink("/proc/self/exe").parent_path() / name; }

std::vector<Packing> obtain_packings(const RveSpec& rve, int threads, bool quiet) {
    const PackingSpec& spec = rve.packing;
    if (!spec.particles.empty()) return {read_packing_csv(spec.particles, spec.contacts)};
    return read_packings(spec.by_specification() ? prepare(rve, threads, quiet).string() : spec.file);
}

} // namespace talik::driver
