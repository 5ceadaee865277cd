#include "exchange/file_side.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <fstream>
#include <utility>

#include "common/base/error.hpp"
#include "common/io/text_file.hpp"
#include "exchange/frame.hpp"

namespace talik::exchange {
namespace {

constexpr std::chrono::milliseconds between_changes{200};

std::string boot_id() { // of this machine, since it was started; differs between machines
    std::ifstream in("/proc/sys/kernel/random/boot_id");
    std::string id;
    in >> id;
    return id.empty() ? "unknown" : id;
}

// Renamed into place; no fsync: a message is of use while both processes live.
void put_file(const std::filesystem::path& path, const std::string& content) {
    const std::filesystem::path part = path.string() + ".part";
    const int file = open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    if (file < 0) fail_to_write(path, errno);
    const bool whole = write(file, content.data(), content.size()) == static_cast<ssize_t>(content.size());
    const int error = errno;
    close(file);
    if (!whole) fail_to_write(path, error);
    if (rename(part.c_str(), path.c_str()) != 0) fail_to_write(path, errno);
}

} // namespace

const char* file_name_of(Role role) { return role == Role::driver ? "driver" : "farm"; }

OwnSide::OwnSide(const std::filesystem::path& folder, Role role) : folder_(folder), name_(file_name_of(role)) {
    const std::filesystem::path path = folder_ / (name_ + ".lock");
    lock_ = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (lock_ < 0) fail_to_write(path, errno);
    if (hold_byte(lock_, 0)) return;
    close(lock_);
    lock_ = -1;
}

OwnSide::~OwnSide() {
    if (lock_ < 0) return;
    change([](FileStanding& standing) { standing.left = true; }, true);
    close(lock_);
}

void OwnSide::sign() {
    const ProcessIdentity self = this_process();
    change([](FileStanding&) {}, true);
    put_file(folder_ / (name_ + ".id"), fmt::format("{} {} {} {} {}\n", protocol_version, boot_id(), self.pid, self.start_time, self.pid_namespace));
}

void OwnSide::change(const std::function<void(FileStanding&)>& how, bool at_once) noexcept {
    try {
        const std::lock_guard lock(mutex_);
        how(standing_);
        changed_ = true;
        const bool first = !at_once && !std::exchange(progressed_, true);
        if (at_once || first || std::chrono::steady_clock::now() - written_ >= between_changes) put();
    } catch (const std::exception&) { // a full disk shows in the next message
    }
}

void OwnSide::settle() noexcept {
    try {
        const std::lock_guard lock(mutex_);
        if (changed_) put();
    } catch (const std::exception&) {
    }
}

void OwnSide::put() {
    written_ = std::chrono::steady_clock::now();
    changed_ = false;
    put_file(folder_ / (name_ + ".status"), fmt::format("{} {} {} {:d} {:d}\n{}\n", standing_.progress.done, standing_.progress.total, ++standing_.beats,
                                                         standing_.wishes_to_end, standing_.left, standing_.cause));
}

PartnerSide::PartnerSide(const std::filesystem::path& folder, Role role) : folder_(folder), name_(file_name_of(role)) {}

PartnerSide::~PartnerSide() {
    if (lock_ >= 0) close(lock_);
}

bool PartnerSide::came() {
    if (identity_) return true;
    std::ifstream in(folder_ / (name_ + ".id"));
    int version = 0;
    std::string boot;
    ProcessIdentity found;
    if (!(in >> version)) return false;
    if (version != protocol_version)
        fail(ExitCode::partner_lost, fmt::format("the partner speaks version {} of the exchange, this program version {}", version, protocol_version),
             "use driver and farm of the same version of Talik");
    if (!(in >> boot >> found.pid >> found.start_time >> found.pid_namespace)) return false;
    if (boot != boot_id()) found.pid_namespace = 0; // of another machine: only its lock tells whether it lives
    lock_ = open((folder_ / (name_ + ".lock")).c_str(), O_RDWR | O_CLOEXEC);
    identity_ = found;
    watch_ = ProcessWatch(found, lock_, 0);
    return true;
}

bool PartnerSide::alive() { return !came() || watch_.alive(); }

char PartnerSide::state() const {
    return identity_ && in_this_pid_namespace(*identity_) ? process_state(identity_->pid) : '?';
}

FileStanding PartnerSide::standing() const {
    FileStanding standing;
    std::ifstream in(folder_ / (name_ + ".status"));
    in >> standing.progress.done >> standing.progress.total >> standing.beats >> standing.wishes_to_end >> standing.left;
    in.ignore(1);
    std::getline(in, standing.cause);
    return standing;
}

} // namespace talik::exchange
