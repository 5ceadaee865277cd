#pragma once
// Wall time by stage. One word for one thing: the stage's name is log line, timer row and plot label.
#include <chrono>
#include <string>
#include <utility>
#include <vector>

namespace talik {

class StageTimer {
public:
    using Clock = std::chrono::steady_clock;

    // Adds the time of a scope to the stage of that name.
    class Scope {
    public:
        explicit Scope(double& seconds) : seconds_(seconds), begin_(Clock::now()) {}
        ~Scope() { seconds_ += std::chrono::duration<double>(Clock::now() - begin_).count(); }
        Scope(const Scope&) = delete;
        Scope& operator=(const Scope&) = delete;

    private:
        double& seconds_;
        Clock::time_point begin_;
    };

    // The index of a stage, made once outside the loop: nothing is looked up by name in a step.
    int stage(const std::string& name);
    Scope measure(int stage) { return Scope(rows_[static_cast<std::size_t>(stage)].second); }

    const std::vector<std::pair<std::string, double>>& rows() const { return rows_; }
    double seconds(const std::string& name) const;

private:
    std::vector<std::pair<std::string, double>> rows_;
};

} // namespace talik
