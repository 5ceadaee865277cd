#pragma once
// history.csv: one row per output time, no wall times in it, so that two runs of one scene compare equal with `cmp`.
// A restarted run keeps the rows up to its checkpoint and goes on.
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace talik::driver {

class History {
public:
    // columns: names with their units ("plate_force_y_N"). The first two, "step" and "time_s", are added here.
    // keep_through_step: rows of an earlier run in the same folder up to this step stay (restart); -1 = a new file.
    History(const std::filesystem::path& path, const std::vector<std::string>& columns, std::int64_t keep_through_step);

    void row(std::int64_t step, double time, std::span<const double> values);
    std::int64_t last_step() const { return last_step_; }

private:
    struct Close {
        void operator()(std::FILE* file) const { std::fclose(file); }
    };
    void write(const std::string& line);

    std::filesystem::path path_;
    std::size_t width_;
    std::unique_ptr<std::FILE, Close> file_;
    std::int64_t last_step_ = -1;
};

} // namespace talik::driver
