#pragma once
// Every wait is bounded and explained. The partner is
//   dead     its process is gone, or it left: said at once, with the cause it wrote down or its signal;
//   stalled  nothing of it moved for `stall_seconds` (stopped, hung): said then;
//   slow     its counters move: waited for, with a line now and then on where it stands.
// There are no heartbeats, which misfire under load: what counts as movement is the work itself.
#include <chrono>
#include <cstdint>
#include <string>

namespace talik::exchange {

enum class Role { driver = 0, farm = 1 };
const char* name_of(Role role); // "the driver", "the farm"
inline Role partner_of(Role role) { return role == Role::driver ? Role::farm : Role::driver; }

struct WaitLimits {
    double attach_seconds = 60.0;                // for the partner to appear at the start
    double stall_seconds = 120.0;                // without any movement of an attached partner
    double grace_after_interrupt_seconds = 20.0; // Ctrl-C: time to end in order before waits give up; none while the partner is absent
};

struct PartnerProgress {
    std::uint64_t done = 0, total = 0; // of the work the partner is at; total 0 = not said
};

// What can be seen of the partner from here at one moment.
struct PartnerView {
    enum class Presence { absent, attached, left };
    Presence presence = Presence::absent;
    bool process_alive = true;  // as far as can be told
    std::uint64_t movement = 0; // differs whenever anything of the partner has moved
    PartnerProgress progress;
    int pid = 0;                // 0 = unknown
    char process_state = '?';   // of /proc: R running, S sleeping, T stopped, ...
    std::string cause;          // in its own words; empty = it wrote none
    std::string fate;           // as told by whoever launched it: "was killed by signal 9 (SIGKILL)"
};

// The patience of one wait: looks at the partner every few tens of milliseconds, and throws once it is exhausted.
class Patience {
public:
    Patience(Role self, const WaitLimits& limits);
    void judge(const PartnerView& partner);

    // The longest sleep between two looks: bounds the time until a death is noticed.
    static constexpr std::chrono::milliseconds look_interval{50};

private:
    using Clock = std::chrono::steady_clock;
    [[noreturn]] void report_lost(const PartnerView& partner) const;
    [[noreturn]] void report_stalled(const PartnerView& partner) const;
    void check_interrupt() const;
    [[noreturn]] void report_interrupt(const char* remedy) const;
    void tell_progress(const PartnerView& partner);

    Role self_;
    WaitLimits limits_;
    Clock::time_point last_look_;
    double motionless_ = 0.0; // s without movement, counted in looks: our own sleep (Ctrl-Z, suspend) does not count
    double waited_ = 0.0;     // s, counted likewise
    double next_line_ = 15.0; // s of waiting, at which the next line on a slow partner is due
    bool seen_ = false;
    std::uint64_t last_movement_ = 0, first_done_ = 0;
};

} // namespace talik::exchange
