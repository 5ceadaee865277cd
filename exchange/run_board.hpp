#pragma once
// Where a running program shows how far it is: a page of counters in memory that only this process writes and any process
// of the same user may read (`rve-farm status`), whatever the transport. It is a memfd: nothing in a file system, nothing
// left behind, and whoever reads it takes no lock and is not seen.
#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "exchange/wait.hpp"

namespace talik::exchange {

struct Board {
    static constexpr std::uint64_t right_mark = 0x3144524f424b4c54u; // "TLKBORD1" in memory order
    using Count = std::atomic<std::uint64_t>;
    using Number = std::atomic<double>;
    static_assert(Count::is_always_lock_free && Number::is_always_lock_free);

    Count mark{0}; // written last
    std::uint64_t role = 0;
    Count run_id{0};
    char exchange[128] = {}, title[128] = {}, folder[256] = {}; // how a user names the run
    Number began{0.0}, updated{0.0};     // s of the machine's monotonic clock
    Count step{0};                       // that it is at
    Count first_step{0};                 // that it began with
    Number fraction{0.0}, first_fraction{0.0}, time{0.0}; // driver: of the run, done; of it, at the start; simulated, s
    Number computing{0.0}, copying{0.0}, waiting{0.0};    // s, in steps
    Count requests{0}, answers{0};       // chunks: of the driver sent and taken, of the farm taken and sent
    Count rves{0};
};

// The board of this process. Before publish() it is private memory, so that counters may always be written.
Board& run_board();
// Shows it, once: a second time it stays what it was. A machine that does not allow it runs on without.
void publish_run_board(Role role, const std::string& exchange, const std::string& title = "", const std::string& folder = "");
double monotonic_seconds();

// What can be read of the running programs of this user. Plain numbers, taken at one look.
struct Standing {
    int pid = 0;
    Role role = Role::driver;
    std::uint64_t run_id = 0;
    std::string exchange, title, folder;
    double elapsed = 0.0, silent = 0.0; // s, since it began, and since it last moved
    std::uint64_t step = 0, first_step = 0, requests = 0, answers = 0, rves = 0;
    double fraction = 0.0, first_fraction = 0.0, time = 0.0, computing = 0.0, copying = 0.0, waiting = 0.0;
};
std::vector<Standing> running_programs(); // by run, the driver first

} // namespace talik::exchange
