#include "mpm-driver/app/packings.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>

#include "common/base/error.hpp"
#include "common/base/installation.hpp"
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

fs::path cached(const RveSpec& rve) { return cache_folder() / "packings" / (scene::packing_fingerprint(rve) + ".h5"); }

// Into the cache, whose folder is not one of --output.
void write_specification(const fs::path& file, const RveSpec& rve) {
    try {
        make_folder(file.parent_path());
        write_file_atomically(file, scene::packing_specification(rve));
    } catch (const Error& error) {
        throw Error(error.code(), error.where(), error.problem(), "packings are kept there: set TALIK_CACHE to a folder you may write to, with free space");
    }
}

// Prepares under a name of its own and renames: two runs at once do not meet, a half is never used.
void prepare(const RveSpec& rve, const fs::path& target, int threads, bool quiet) {
    const fs::path part = target.string() + "." + std::to_string(::getpid()) + ".part";
    const fs::path specification = part.string() + ".toml";
    write_specification(specification, rve);
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
}

// The cache is ours: what is damaged there is made anew.
std::vector<Packing> prepared(const RveSpec& rve, int threads, bool quiet) {
    const fs::path target = cached(rve);
    if (fs::exists(target)) {
        try {
            return read_packings(target.string());
        } catch (const Error& error) {
            log::warn("{}{}{}; it is removed and prepared again", error.where(), error.where().empty() ? "" : ": ", error.problem());
            std::error_code why;
            fs::remove_all(target, why);
            if (why) throw Error(ExitCode::bad_input, target.string(), "is damaged and cannot be removed: " + why.message(), "set TALIK_CACHE to a folder you may write to");
        }
    }
    prepare(rve, target, threads, quiet);
    return read_packings(target.string());
}

} // namespace

fs::path cache_folder() {
    if (const char* own = std::getenv("TALIK_CACHE"); own && *own) return own;
    if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache && *cache) return fs::path(cache) / "talik";
    const char* home = std::getenv("HOME");
    return (home && *home ? fs::path(home) / ".cache" : fs::temp_directory_path()) / "talik";
}

std::vector<Packing> obtain_packings(const RveSpec& rve, int threads, bool quiet) {
    const PackingSpec& spec = rve.packing;
    if (!spec.particles.empty()) return {read_packing_csv(spec.particles, spec.contacts)};
    return spec.by_specification() ? prepared(rve, threads, quiet) : read_packings(spec.file);
}

} // namespace talik::driver
