#pragma once
// One side of an exchange through a folder: who it is (NAME.id, with a lock on NAME.lock that lives as long as it), and how it
// stands (NAME.status: progress, wish to end, cause, farewell). Written by that side alone, whole or not at all.
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include "exchange/process_identity.hpp"
#include "exchange/wait.hpp"

namespace talik::exchange {

struct FileStanding {
    PartnerProgress progress;
    std::uint64_t beats = 0;
    bool wishes_to_end = false, left = false;
    std::string cause;
};

// This side's: writes.
class OwnSide {
public:
    OwnSide(const std::filesystem::path& folder, Role role);
    ~OwnSide(); // says farewell
    bool held() const { return lock_ >= 0; } // else another process has this side
    void sign();                             // who this is
    // From any thread. Written a few times a second, unless at once; settle() writes what was not.
    void change(const std::function<void(FileStanding&)>& how, bool at_once) noexcept;
    void settle() noexcept;

private:
    std::filesystem::path folder_;
    std::string name_;
    int lock_ = -1;
    std::mutex mutex_;
    void put();
    FileStanding standing_;
    bool changed_ = false, progressed_ = false;
    std::chrono::steady_clock::time_point written_{};
};

// The partner's: reads.
class PartnerSide {
public:
    PartnerSide(const std::filesystem::path& folder, Role role);
    ~PartnerSide();
    bool came();                 // has signed, as a process that lives or lived
    bool alive();
    int pid() const { return identity_ ? identity_->pid : 0; }
    char state() const;          // of /proc, where it is a process of this machine
    FileStanding standing() const;

private:
    std::filesystem::path folder_;
    std::string name_;
    int lock_ = -1;
    std::optional<ProcessIdentity> identity_;
    ProcessWatch watch_;
};

// "driver", "farm"
const char* file_name_of(Role role);

} // namespace talik::exchange
