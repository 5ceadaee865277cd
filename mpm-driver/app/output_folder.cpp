#include "mpm-driver/app/output_folder.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "common/io/text_file.hpp"

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

int remove_checkpoints(const fs::path& folder) {
    const std::string begin = "checkpoint-";
    std::vector<fs::path> old; // first listed, then removed: a folder is not changed while it is read
    for (const auto& entry : fs::directory_iterator(folder)) {
        const std::string name = entry.path().filename().string();
        const bool numbered = name.starts_with(begin) && name.size() > begin.size() && name.find_first_not_of("0123456789", begin.size()) == std::string::npos;
        if (numbered && entry.is_directory()) old.push_back(entry.path());
    }
    for (const fs::path& path : old) fs::remove_all(path);
    return static_cast<int>(old.size());
}

} // namespace talik::driver
