#include "exchange/stale_segment.hpp"

#include <cstddef>
#include <ctime>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/base/log.hpp"
#include "exchange/shm_layout.hpp"
#include "exchange/wait.hpp"

namespace talik::exchange {
namespace {

constexpr double making_seconds = 10.0; // nobody takes longer from creating a segment to signing it

struct OpenFile {
    int handle;
    explicit OpenFile(const std::string& path) : handle(open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW)) {}
    ~OpenFile() {
        if (handle >= 0) close(handle);
    }
    OpenFile(const OpenFile&) = delete;
    OpenFile& operator=(const OpenFile&) = delete;
};

bool creator_lives(const ProcessIdentity& creator, int file) {
    if (in_this_pid_namespace(creator)) return process_exists(creator);
    return byte_is_held(file, static_cast<int>(Role::driver));
}

SegmentFinding examine(int file) {
    struct stat info {};
    if (fstat(file, &info) != 0) return {};
    if (info.st_uid != geteuid()) return {SegmentState::foreign, {}};
    // Plain copies of the preamble's first words: a segment being made is recognised by its missing signature.
    struct {
        std::uint64_t magic;
        std::uint32_t version, header_bytes;
        std::uint64_t segment_bytes;
        ProcessIdentity creator;
    } preamble{};
    static_assert(offsetof(shm::Preamble, creator) == 24);
    const bool complete = pread(file, &preamble, sizeof preamble, 0) == static_cast<ssize_t>(sizeof preamble);
    if (!complete || preamble.magic == 0) {
        const bool held = byte_is_held(file, static_cast<int>(Role::driver));
        const bool young = std::difftime(std::time(nullptr), info.st_mtime) < making_seconds;
        return {held || young ? SegmentState::being_made : SegmentState::stale, {}};
    }
    if (preamble.magic != shm::magic) return {SegmentState::foreign, {}};
    return {creator_lives(preamble.creator, file) ? SegmentState::in_use : SegmentState::stale, preamble.creator};
}

} // namespace

std::string segment_path(const std::string& file_name) { return "/dev/shm/" + file_name; }

SegmentFinding examine_segment(const std::string& file_name) {
    const OpenFile file(segment_path(file_name));
    if (file.handle < 0) return {errno == EACCES ? SegmentState::foreign : SegmentState::gone, {}};
    return examine(file.handle);
}

bool unlink_if_same(int file, const std::string& file_name) noexcept {
    // The lock lets one remover at a time compare and unlink; a creator cannot slip in, its name is still taken.
    if (!hold_byte(file, shm::removal_byte)) return false;
    struct stat mine {}, named {};
    const std::string path = segment_path(file_name);
    const bool same = fstat(file, &mine) == 0 && stat(path.c_str(), &named) == 0 && mine.st_ino == named.st_ino &&
                      mine.st_dev == named.st_dev;
    const bool removed = same && unlink(path.c_str()) == 0;
    release_byte(file, shm::removal_byte);
    return removed;
}

bool remove_if_stale(const std::string& file_name) {
    const OpenFile file(segment_path(file_name));
    if (file.handle < 0) return false;
    const SegmentFinding found = examine(file.handle);
    if (found.state != SegmentState::stale || !unlink_if_same(file.handle, file_name)) return false;
    log::info("removed the shared memory '{}', left behind by process {}, which is dead", file_name, found.creator.pid);
    return true;
}

} // namespace talik::exchange
