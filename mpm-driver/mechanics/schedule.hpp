#pragma once
// What one step does, in order: built once from the scene, logged at the start, timed under the same names.
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/stage_timer.hpp"

namespace talik::driver {

class Schedule {
public:
    void add(const std::string& name, std::function<void()> work) {
        rows_.push_back({timer_.stage(name), name, std::move(work)});
    }

    void run() {
        for (const Row& row : rows_) {
            const auto timed = timer_.measure(row.timer);
            row.work();
        }
    }

    std::vector<std::string> table_of_contents() const {
        std::vector<std::string> names;
        for (const Row& row : rows_) names.push_back(row.name);
        return names;
    }
    const StageTimer& timer() const { return timer_; }

private:
    struct Row {
        int timer;
        std::string name;
        std::function<void()> work;
    };
    std::vector<Row> rows_;
    StageTimer timer_;
};

} // namespace talik::driver
