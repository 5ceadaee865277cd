#include "mpm-driver/output/history.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <charconv>

#include "common/base/error.hpp"
#include "common/io/text_file.hpp"

namespace talik::driver {
namespace {

// The rows of an earlier history up to a step; empty where the header differs (another scene or version).
std::string kept_rows(const std::filesystem::path& path, const std::string& header, std::int64_t through_step, std::int64_t& last) {
    if (through_step < 0 || !std::filesystem::exists(path)) return "";
    const std::string old = read_text_file(path);
    if (old.compare(0, header.size(), header) != 0) return "";
    std::size_t end = header.size();
    while (end < old.size()) {
        std::int64_t step = 0;
        const auto [rest, problem] = std::from_chars(old.data() + end, old.data() + old.size(), step);
        const std::size_t line_end = old.find('\n', end);
        if (problem != std::errc() || step > through_step || line_end == std::string::npos) break;
        last = step;
        end = line_end + 1;
    }
    return old.substr(header.size(), end - header.size());
}

} // namespace

History::History(const std::filesystem::path& path, const std::vector<std::string>& columns, std::int64_t keep_through_step)
    : path_(path), width_(columns.size()) {
    std::string header = "step,time_s";
    for (const auto& column : columns) header += "," + column;
    header += "\n";
    const std::string rows = kept_rows(path, header, keep_through_step, last_step_);
    write_file_atomically(path, header + rows); // a run killed here keeps the rows it restarts with
    file_.reset(std::fopen(path.c_str(), "ab"));
    if (!file_) fail_to_write(path, errno);
}

void History::row(std::int64_t step, double time, std::span<const double> values) {
    ensure(values.size() == width_);
    std::string line = fmt::format("{},{}", step, time); // shortest digits that read back to the same number
    for (double value : values) line += fmt::format(",{}", value);
    write(line + "\n");
    last_step_ = step;
}

void History::write(const std::string& line) {
    if (std::fwrite(line.data(), 1, line.size(), file_.get()) != line.size() || std::fflush(file_.get()) != 0)
        fail_to_write(path_, errno);
}

} // namespace talik::driver
