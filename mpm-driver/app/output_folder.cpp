#include "mpm-driver/app/output_folder.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "common/io/text_file.hpp"
#include "mpm-driver/output/checkpoint.hpp"

namespace talik::driver {

namespace fs = std::filesystem;

OutputLock::OutputLock(const fs::path& folder) {
    const fs::path path = folder / ".lock";
    file_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644); // the farm must not inherit it
    if (file_ < 0) fail_to_write(path, errno);
    if (::flock(file_, LOCK_EX | LOCK_NB) == 0) return;
    const int why = errno;
    ::close(file_);
    file_ = -1;
    if (why == EWOULDBLOCK) throw Error(ExitCode::bad_input, folder.string(), "is in use by another run", "wait for its end, or choose another folder with --output");
    log::warn("{}: this file system has no locks: keep other runs out of that folder", folder.string());
}

OutputLock::~OutputLock() {
    if (file_ >= 0) ::close(file_);
}

void require_room_for_files(const fs::path& folder) {
    for (const char* name : {"history.csv", "summary.json", "fields.h5", "fields.pvd", "fields"})
        for (const std::string& file : {(folder / name).string(), (folder / name).string() + ".part"}) {
            std::error_code none;
            const fs::file_status status = fs::status(file, none);
            const bool fits = file.ends_with("fields") ? fs::is_directory(status) : fs::is_regular_file(status);
            if (fs::exists(status) && !fits)
                throw Error(ExitCode::bad_input, file, file.ends_with("fields") ? "is no folder, but the run's fields go there" : "is no regular file, but the run writes a file there",
                            "move it away, or choose another folder with --output");
        }
}

bool is_written_by_run(const fs::path& folder, const fs::path& file) {
    static const std::vector<std::string> names = {"history.csv", "summary.json", "fields.h5", "fields.pvd", "fields", "recovery", ".lock"};
    std::error_code none;
    const fs::path inside = fs::weakly_canonical(file, none).lexically_relative(fs::canonical(folder, none));
    if (none || inside.empty()) return false;
    std::string name = inside.begin()->string();
    if (name.ends_with(".part")) name.resize(name.size() - 5);
    return is_checkpoint_name(name) || std::find(names.begin(), names.end(), name) != names.end();
}

int remove_checkpoints(const fs::path& folder) {
    std::vector<fs::path> old; // first listed, then removed: a folder is not changed while it is read
    for (const auto& entry : fs::directory_iterator(folder)) {
        if (entry.is_directory() && is_checkpoint_name(entry.path().filename().string())) old.push_back(entry.path());
    }
    for (const fs::path& path : old) fs::remove_all(path);
    return static_cast<int>(old.size());
}

} // namespace talik::driver
