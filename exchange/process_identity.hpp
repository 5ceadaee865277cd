#pragma once
// Who a process is, safe against reuse of its number: pid, start time and pid namespace. And whether it still lives.
#include <cstdint>

namespace talik::exchange {

struct ProcessIdentity { // lies in the shared segment: keep its layout
    std::int32_t pid = 0;
    std::int32_t reserved = 0;
    std::uint64_t start_time = 0;    // clock ticks since boot
    std::uint64_t pid_namespace = 0; // inode of /proc/self/ns/pid; 0 = unknown
    bool operator==(const ProcessIdentity&) const = default;
};

ProcessIdentity identity_of(int pid); // of a process of this pid namespace
ProcessIdentity this_process();
bool in_this_pid_namespace(const ProcessIdentity& process);
// Whether the process of that very start time exists and is no zombie. Only for processes of this pid namespace.
bool process_exists(const ProcessIdentity& process);
char process_state(int pid); // of /proc: R, S, D, T, Z, ...; '?' = no such process

// Byte locks on the segment's file: held as long as the process lives, and seen across pid namespaces.
bool hold_byte(int file, int byte);         // false where somebody else holds it
bool byte_is_held(int file, int byte);      // by somebody else
void release_byte(int file, int byte);

// Watches one process: by pidfd, else by its start time, else (another pid namespace) by the byte it locks.
class ProcessWatch {
public:
    ProcessWatch() = default;
    ProcessWatch(const ProcessIdentity& process, int file, int byte);
    ~ProcessWatch();
    ProcessWatch(ProcessWatch&& other) noexcept;
    ProcessWatch& operator=(ProcessWatch&& other) noexcept;

    bool watching() const { return process_.pid != 0; }
    bool alive() const;

private:
    ProcessIdentity process_;
    int file_ = -1, byte_ = 0;
    int pidfd_ = -1;
    bool died_before_ = false;
};

} // namespace talik::exchange
