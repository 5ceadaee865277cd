#include "exchange/process_identity.hpp"

#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <poll.h>
#include <string>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>
#include <utility>

namespace talik::exchange {
namespace {

struct ProcessStat {
    char state = '?';
    std::uint64_t start_time = 0;
};

// Fields 3 and 22 of /proc/PID/stat, counted behind the name, which may itself hold blanks and parentheses.
ProcessStat read_stat(int pid) {
    ProcessStat result;
    const std::string path = "/proc/" + std::to_string(pid) + "/stat";
    std::FILE* file = std::fopen(path.c_str(), "re");
    if (!file) return result;
    char text[1024];
    const std::size_t size = std::fread(text, 1, sizeof text - 1, file);
    std::fclose(file);
    text[size] = '\0';
    const char* rest = std::strrchr(text, ')');
    if (!rest) return result;
    unsigned long long start = 0;
    if (std::sscanf(rest + 1, " %c %*s %*s %*s %*s %*s %*s %*s %*s %*s %*s %*s %*s %*s %*s %*s %*s %*s %*s %llu",
                    &result.state, &start) == 2)
        result.start_time = start;
    return result;
}

std::uint64_t own_pid_namespace() {
    struct stat info {};
    return stat("/proc/self/ns/pid", &info) == 0 ? static_cast<std::uint64_t>(info.st_ino) : 0;
}

struct flock byte_range(int byte, short type) {
    struct flock lock {};
    lock.l_type = type;
    lock.l_whence = SEEK_SET;
    lock.l_start = byte;
    lock.l_len = 1;
    return lock;
}

} // namespace

ProcessIdentity identity_of(int pid) { return {pid, 0, read_stat(pid).start_time, own_pid_namespace()}; }

ProcessIdentity this_process() { return identity_of(static_cast<int>(getpid())); }

bool in_this_pid_namespace(const ProcessIdentity& process) { return process.pid_namespace == own_pid_namespace(); }

bool process_exists(const ProcessIdentity& process) {
    const ProcessStat present = read_stat(process.pid);
    return present.state != '?' && present.state != 'Z' && present.state != 'X' && present.start_time == process.start_time;
}

char process_state(int pid) { return read_stat(pid).state; }

bool hold_byte(int file, int byte) {
    struct flock lock = byte_range(byte, F_WRLCK);
    return fcntl(file, F_OFD_SETLK, &lock) == 0;
}

bool byte_is_held(int file, int byte) {
    struct flock lock = byte_range(byte, F_WRLCK);
    return fcntl(file, F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
}

void release_byte(int file, int byte) {
    struct flock lock = byte_range(byte, F_UNLCK);
    fcntl(file, F_OFD_SETLK, &lock);
}

ProcessWatch::ProcessWatch(const ProcessIdentity& process, int file, int byte) : process_(process), file_(file), byte_(byte) {
    if (!in_this_pid_namespace(process_)) return;
    pidfd_ = static_cast<int>(syscall(SYS_pidfd_open, process_.pid, 0)); // -1 on old kernels and in some sandboxes
    died_before_ = !process_exists(process_); // else the pidfd would be of another process that took over the number
}

ProcessWatch::~ProcessWatch() {
    if (pidfd_ >= 0) close(pidfd_);
}

ProcessWatch::ProcessWatch(ProcessWatch&& other) noexcept
    : process_(std::exchange(other.process_, {})), file_(other.file_), byte_(other.byte_),
      pidfd_(std::exchange(other.pidfd_, -1)), died_before_(other.died_before_) {}

ProcessWatch& ProcessWatch::operator=(ProcessWatch&& other) noexcept {
    std::swap(process_, other.process_);
    std::swap(file_, other.file_);
    std::swap(byte_, other.byte_);
    std::swap(pidfd_, other.pidfd_);
    std::swap(died_before_, other.died_before_);
    return *this;
}

bool ProcessWatch::alive() const {
    if (died_before_) return false;
    if (pidfd_ >= 0) {
        pollfd ended{pidfd_, POLLIN, 0};
        // Readable once the process has ended, reaped or not. A signal to this side (Ctrl-C) that comes during the look
        // makes poll() return -1, which says nothing about the other: only "readable" is an end.
        return poll(&ended, 1, 0) <= 0;
    }
    if (in_this_pid_namespace(process_)) return process_exists(process_);
    return byte_is_held(file_, byte_);
}

} // namespace talik::exchange
