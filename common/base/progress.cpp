#include "common/base/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace talik {

Progress::Progress(std::string what, bool quiet)
    : what_(std::move(what)), quiet_(quiet), terminal_(isatty(STDERR_FILENO) == 1), begin_(Clock::now()),
      last_(begin_ - std::chrono::hours(1)) {}

Progress::~Progress() {
    if (printed_ && terminal_) std::fputc('\n', stderr);
}

void Progress::update(double fraction, const std::string& note) {
    if (quiet_) return;
    const auto now = Clock::now();
    const auto pause = terminal_ ? std::chrono::milliseconds(200) : std::chrono::milliseconds(10000);
    if (now - last_ < pause && !(fraction >= 1.0 && printed_ && terminal_)) return;
    last_ = now;
    const double elapsed = std::chrono::duration<double>(now - begin_).count();
    const std::string eta = fraction > 1e-6 && elapsed > 0.5
        ? "ETA " + readable_duration(elapsed * (1.0 - std::min(fraction, 1.0)) / fraction)
        : "ETA ...";
    const std::string line =
        fmt::format("{}: {:5.1f} %  {}  elapsed {}  {}", what_, 100.0 * fraction, note, readable_duration(elapsed), eta);
    if (terminal_) std::fprintf(stderr, "\r\033[K%s", line.c_str());
    else std::fprintf(stderr, "%s\n", line.c_str());
    std::fflush(stderr);
    printed_ = true;
}

std::string readable_duration(double seconds) {
    constexpr double year = 365.25 * 86400;
    if (!(seconds < 100 * year)) return "centuries"; // nor does infinity fit into a whole number
    const long s = static_cast<long>(seconds + 0.5);
    if (s >= 3600) return fmt::format("{} h {:02} min", s / 3600, s % 3600 / 60);
    if (s >= 60) return fmt::format("{} min {:02} s", s / 60, s % 60);
    return fmt::format("{} s", s);
}

} // namespace talik
