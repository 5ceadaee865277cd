#include "common/base/stage_timer.hpp"

namespace talik {

int StageTimer::stage(const std::string& name) {
    for (std::size_t i = 0; i < rows_.size(); ++i)
        if (rows_[i].first == name) return static_cast<int>(i);
    rows_.emplace_back(name, 0.0);
    return static_cast<int>(rows_.size()) - 1;
}

double StageTimer::seconds(const std::string& name) const {
    for (const auto& [row, seconds] : rows_)
        if (row == name) return seconds;
    return 0.0;
}

} // namespace talik
