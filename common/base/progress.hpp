#pragma once
// A progress line with an ETA on stderr: rewritten in place on a terminal, a line every ten seconds elsewhere.
#include <chrono>
#include <string>

namespace talik {

class Progress {
public:
    Progress(std::string what, bool quiet);
    ~Progress(); // ends the line
    // fraction in [0, 1]; note: a few words on the present state ("t = 0.31 s, step 420").
    void update(double fraction, const std::string& note);

private:
    using Clock = std::chrono::steady_clock;
    std::string what_;
    bool quiet_, terminal_, printed_ = false;
    Clock::time_point begin_, last_;
};

// "1 h 02 min", "3 min 20 s", "12 s"
std::string readable_duration(double seconds);

} // namespace talik
