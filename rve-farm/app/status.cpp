// rve-farm status: how far the running lockstep programs of this user and machine are. It only reads.
#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/progress.hpp"
#include "exchange/run_board.hpp"
#include "rve-farm/app/commands.hpp"

namespace talik::farm {
namespace {

using exchange::Role;
using exchange::Standing;

std::string share(double part, const Standing& s) {
    const double sum = s.computing + s.copying + s.waiting;
    return sum > 0.0 ? fmt::format("{:.0f} %", 100.0 * part / sum) : "-";
}

std::string rate(const Standing& s) {
    const auto steps = static_cast<double>(s.step - s.first_step);
    if (steps <= 0.0 || s.elapsed <= 0.0) return "-";
    return steps >= s.elapsed ? fmt::format("{:.3g} steps/s", steps / s.elapsed) : fmt::format("{:.3g} s/step", s.elapsed / steps);
}

std::string time_to_go(const Standing& s) {
    const double done = s.fraction - s.first_fraction;
    return done > 0.0 ? readable_duration(s.elapsed * (1.0 - s.fraction) / done) : "-";
}

bool is_of(const Standing& s, const std::string& name) {
    return name.empty() || s.exchange == name || s.exchange == "shm:" + name || fmt::format("{:x}", s.run_id) == name || s.folder == name || std::to_string(s.pid) == name;
}

// Requests that lie waiting, and answers: what one side has sent less what the other has taken.
std::string queue(const Standing& driver, const std::vector<Standing>& all) {
    std::uint64_t taken = 0, answered = 0;
    for (const Standing& s : all)
        if (s.role == Role::farm && s.run_id == driver.run_id) taken += s.requests, answered += s.answers;
    const auto lying = [](std::uint64_t sent, std::uint64_t got) { return sent > got ? sent - got : 0; }; // counters are read one after the other
    return fmt::format("{} chunks on the way to the farm, {} on the way back", lying(driver.requests, taken), lying(answered, driver.answers));
}

void print(const Standing& s, const std::vector<Standing>& all) {
    if (s.role == Role::driver) {
        fmt::print("{}  (exchange {}, run {:x}{})\n", s.title.empty() ? "run" : s.title, s.exchange.empty() ? "of its own" : s.exchange, s.run_id, s.folder.empty() ? "" : ", output in " + s.folder);
        fmt::print("  step       {}, t = {:.4g} s, {:.1f} % done\n", s.step, s.time, 100.0 * s.fraction);
        fmt::print("  rate       {}, {} elapsed, {} to go\n", rate(s), readable_duration(s.elapsed), time_to_go(s));
        fmt::print("  queue      {}\n", queue(s, all));
    }
    fmt::print("  {:<10} process {}: step {}, computing {}, copying {}, waiting {}", s.role == Role::driver ? "driver" : "farm", s.pid, s.step, share(s.computing, s), share(s.copying, s), share(s.waiting, s));
    if (s.silent > 5.0) fmt::print("; last moved {} ago", readable_duration(s.silent));
    fmt::print("\n");
}

int status(const std::string& name) {
    const std::vector<Standing> all = exchange::running_programs();
    std::vector<std::uint64_t> runs;
    for (const Standing& s : all)
        if (is_of(s, name)) runs.push_back(s.run_id);
    require(name.empty() || !runs.empty(), "no run '" + name + "' of this user goes on on this machine", "rve-farm status lists those that do");
    if (runs.empty()) fmt::print("no run of this user goes on on this machine\n");
    for (const Standing& s : all)
        if (std::find(runs.begin(), runs.end(), s.run_id) != runs.end()) print(s, all);
    return 0;
}

} // namespace

void add_status(CLI::App& app, int& exit) {
    auto name = std::make_shared<std::string>();
    CLI::App* command = app.add_subcommand("status", "How far running locksteps are, and which side waits: reads only, disturbs nothing");
    command->footer("Examples:\n"
                    "  rve-farm status                     every run of this user on this machine\n"
                    "  rve-farm status slope               the run at --exchange shm:slope (or: its output folder, run id, process)");
    command->add_option("name", *name, "exchange name, output folder, run id or process; left out: all");
    command->callback([name, &exit] { exit = status(*name); });
}

} // namespace talik::farm
