#include "exchange/record_file.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <sstream>

#include "common/base/error.hpp"
#include "common/io/byte_stream.hpp"

namespace talik::exchange {
namespace {

constexpr const char* format = "talik-record 1";
constexpr std::size_t small_rows_per_chunk = 512;

// A line for each column: name, components, unit, meaning, between tabs.
std::string in_lines(const std::vector<Column>& columns) {
    std::string text;
    for (const Column& c : columns) text += fmt::format("{}\t{}\t{}\t{}\n", c.name, c.components, c.unit, c.meaning);
    return text;
}

std::vector<Column> from_lines(const std::string& text, const std::string& file) {
    std::vector<Column> columns;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) {
        std::istringstream fields(line);
        Column column;
        std::string components;
        std::getline(fields, column.name, '\t');
        std::getline(fields, components, '\t');
        std::getline(fields, column.unit, '\t');
        std::getline(fields, column.meaning);
        column.components = std::atoi(components.c_str());
        if (column.components < 1 || column.components > 1024) throw Error(ExitCode::bad_input, file, "its table of columns is damaged", "take another recording");
        columns.push_back(column);
    }
    return columns;
}

std::size_t components_of(const std::vector<Column>& columns) {
    std::size_t sum = 0;
    for (const Column& column : columns) sum += static_cast<std::size_t>(column.components);
    return sum;
}

RecordFacts read_facts(const Hdf5File& file) {
    file.require_format(format);
    RecordFacts facts;
    facts.driver = file.text_attribute("/", "driver");
    facts.farm = file.text_attribute("/", "farm");
    facts.scene_hash = file.text_attribute("/", "scene_hash");
    facts.setup_checksum = file.text_attribute("/", "setup_checksum");
    facts.request_columns = from_lines(file.read_text("/request/columns"), file.name());
    facts.answer_columns = from_lines(file.read_text("/answer/columns"), file.name());
    facts.rves = static_cast<std::size_t>(std::max<std::int64_t>(0, file.integer_attribute("/", "rves")));
    facts.initial = file.read<double>("/answer/initial").values;
    return facts;
}

[[noreturn]] void fail_damaged(const std::string& file, const char* what) {
    throw Error(ExitCode::bad_input, file, std::string("is no whole recording: ") + what, "take another recording");
}

} // namespace

double bytes_per_step(const RecordFacts& facts) {
    return 8.0 * static_cast<double>((components_of(facts.request_columns) + components_of(facts.answer_columns)) * facts.rves);
}

Record::Record(const std::string& file)
    : file_(Hdf5File::open(file)), facts_(read_facts(file_)), request_(file_, "/request/values"), answer_(file_, "/answer/values"),
      asked_(file_, "/request/asked") {
    const std::size_t requested = components_of(facts_.request_columns) * facts_.rves, answered = components_of(facts_.answer_columns) * facts_.rves;
    if (facts_.rves == 0 || request_.row_size() != requested || answer_.row_size() != answered || facts_.initial.size() != answered || asked_.row_size() != facts_.rves)
        fail_damaged(file, "its arrays do not have the sizes that its columns and RVEs call for");
    const Hdf5Series<std::int64_t> clock(file_, "/steps/clock"), ends(file_, "/commands/ends");
    const Hdf5Series<double> increments(file_, "/steps/time_increment");
    const Hdf5Series<std::uint8_t> bytes(file_, "/commands/bytes");
    if (clock.row_size() != 3 || increments.row_size() != 1 || ends.row_size() != 1 || bytes.row_size() != 1) fail_damaged(file, "its tables have other columns");
    // A writer that was killed between two arrays of a step leaves them of different lengths: the step is not there.
    const std::size_t count = std::min({clock.rows(), increments.rows(), request_.rows(), answer_.rows(), asked_.rows()});
    std::vector<std::int64_t> clocks(3 * count);
    std::vector<double> increment(count);
    clock.read(0, clocks);
    increments.read(0, increment);
    for (std::size_t i = 0; i < count; ++i) {
        const RecordedStep step{clocks[3 * i], clocks[3 * i + 1], clocks[3 * i + 2], increment[i]};
        if (!steps_.empty() && step.step <= steps_.back().step) fail_damaged(file, "its steps are out of order");
        steps_.push_back(step);
    }
    std::vector<std::int64_t> command_ends(ends.rows());
    std::vector<std::uint8_t> command_bytes(bytes.rows());
    ends.read(0, command_ends);
    bytes.read(0, command_bytes);
    std::size_t begin = 0;
    for (const std::int64_t end : command_ends) {
        if (static_cast<std::size_t>(end) < begin || static_cast<std::size_t>(end) > command_bytes.size()) break; // cut short by a kill
        ByteReader in({reinterpret_cast<const std::byte*>(command_bytes.data()) + begin, static_cast<std::size_t>(end) - begin}, "a recorded command");
        RecordedCommand command;
        command.after_step = in.get<std::int64_t>();
        command.name = in.text();
        command.payload = in.array<std::byte>();
        command.reply = in.array<std::byte>();
        commands_.push_back(std::move(command));
        begin = static_cast<std::size_t>(end);
    }
}

std::optional<std::size_t> Record::find(std::uint64_t step) const {
    const auto found = std::lower_bound(steps_.begin(), steps_.end(), static_cast<std::int64_t>(step), [](const RecordedStep& s, std::int64_t wanted) { return s.step < wanted; });
    if (found == steps_.end() || found->step != static_cast<std::int64_t>(step)) return std::nullopt;
    return static_cast<std::size_t>(found - steps_.begin());
}

void Record::read_asked(std::size_t place, std::span<std::uint8_t> out) const {
    if (steps_[place].asked == static_cast<std::int64_t>(facts_.rves))
        std::fill(out.begin(), out.end(), std::uint8_t{1});
    else
        asked_.read(place, out);
}

void check_place_of_record(const std::string& file) { require_replaceable(file, format, "name another file with --record"); }

RecordFile::RecordFile(const std::string& file, const RecordFacts& facts) : file_(create_growing_file(file, facts.driver, format)) {
    file_.set_attribute("/", "driver", facts.driver);
    file_.set_attribute("/", "farm", facts.farm);
    file_.set_attribute("/", "scene_hash", facts.scene_hash);
    file_.set_attribute("/", "setup_checksum", facts.setup_checksum);
    file_.set_attribute("/", "rves", static_cast<std::int64_t>(facts.rves));
    const std::size_t requested = components_of(facts.request_columns), answered = components_of(facts.answer_columns);
    for (const char* group : {"/request", "/answer", "/steps", "/commands"}) file_.make_group(group);
    file_.write_text("/request/columns", in_lines(facts.request_columns));
    file_.write_text("/answer/columns", in_lines(facts.answer_columns));
    file_.write("/answer/initial", facts.initial, facts.rves);
    clock_.emplace(file_, "/steps/clock", std::vector<std::size_t>{3}, RowStorage::plain, small_rows_per_chunk);
    file_.set_attribute("/steps/clock", "columns", std::string("step, substeps (0: the farm decides), RVEs asked"));
    time_increment_.emplace(file_, "/steps/time_increment", std::vector<std::size_t>{}, RowStorage::plain, small_rows_per_chunk);
    file_.set_attribute("/steps/time_increment", "unit", std::string("s"));
    request_.emplace(file_, "/request/values", std::vector<std::size_t>{requested, facts.rves}, RowStorage::deflated);
    answer_.emplace(file_, "/answer/values", std::vector<std::size_t>{answered, facts.rves}, RowStorage::deflated);
    for (const char* array : {"/request/values", "/answer/values"}) file_.set_attribute(array, "axes", std::string("step, component, RVE; NaN where an RVE was not asked"));
    asked_.emplace(file_, "/request/asked", std::vector<std::size_t>{facts.rves}, RowStorage::plain);
    command_ends_.emplace(file_, "/commands/ends", std::vector<std::size_t>{}, RowStorage::plain, small_rows_per_chunk);
    command_bytes_.emplace(file_, "/commands/bytes", std::vector<std::size_t>{}, RowStorage::plain, 8 * small_rows_per_chunk);
    start_growth(file_);
    file_.flush();
}

void RecordFile::add(const RecordedStep& step, std::span<const std::byte> packed_request, std::span<const std::byte> packed_answer,
                     std::span<const std::uint8_t> asked) {
    request_->append_packed(packed_request);
    answer_->append_packed(packed_answer);
    if (asked.empty())
        asked_->append_nothing();
    else
        asked_->append(asked);
    const std::int64_t clock[3] = {step.step, step.substeps, step.asked};
    time_increment_->append(std::span(&step.time_increment, 1));
    clock_->append(clock); // last: a step is there once its clock is
}

void RecordFile::add(const RecordedCommand& command) {
    ByteWriter out;
    out.put(command.after_step);
    out.text(command.name);
    out.array(command.payload);
    out.array(command.reply);
    const auto& bytes = out.bytes();
    command_bytes_->append(std::span(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()));
    command_end_ += static_cast<std::int64_t>(bytes.size());
    command_ends_->append(std::span<const std::int64_t>(&command_end_, 1));
}

void RecordFile::close() {
    clock_.reset(), command_ends_.reset(), time_increment_.reset(), request_.reset(), answer_.reset(), asked_.reset(), command_bytes_.reset();
    file_.close();
}

} // namespace talik::exchange
