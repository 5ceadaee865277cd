#include "exchange/journal.hpp"

#include <fmt/format.h>

#include "common/base/error.hpp"
#include "exchange/checksum.hpp"

namespace talik::exchange {

void Journal::begin_step(const StepClock& clock, int count) {
    Entry entry;
    entry.clock = clock;
    entry.count = count;
    entry.begin = bytes_.size();
    entries_.push_back(entry);
}

void Journal::chunk(const Batch& request) {
    const auto rows = request.rows();
    bytes_.insert(bytes_.end(), rows.begin(), rows.end());
    entries_.back().size += rows.size();
}

void Journal::end_step(const Batch& answer) {
    entries_.back().answer_sum = checksum(answer.rows());
    entries_.back().ended = true;
    ++steps_;
}

void Journal::drop_step() {
    if (entries_.empty() || !entries_.back().is_step || entries_.back().ended) return;
    bytes_.resize(entries_.back().begin);
    entries_.pop_back();
}

void Journal::command(const std::string& name, std::span<const std::byte> payload) {
    Entry entry;
    entry.is_step = false;
    entry.name = name;
    entry.begin = bytes_.size();
    entry.size = payload.size();
    bytes_.insert(bytes_.end(), payload.begin(), payload.end());
    entries_.push_back(entry);
}

void Journal::clear() {
    entries_.clear(); // both keep their memory
    bytes_.clear();
    steps_ = 0;
}

void Journal::replay(DriverEnd& farm, Batch& scratch, const std::function<void()>& tick) const {
    for (const Entry& entry : entries_) {
        tick();
        if (entry.is_step)
            replay_step(entry, farm, scratch);
        else
            farm.command(entry.name, std::span(bytes_).subspan(entry.begin, entry.size));
    }
}

void Journal::replay_step(const Entry& entry, DriverEnd& farm, Batch& scratch) const {
    farm.begin_step(entry.clock, entry.count, scratch);
    std::size_t at = entry.begin;
    while (at < entry.begin + entry.size) {
        Batch& chunk = farm.next_chunk();
        const std::size_t size = chunk.rows().size();
        chunk.set_rows(std::span(bytes_).subspan(at, size));
        at += size;
        farm.send_chunk();
    }
    farm.finish_step();
    if (checksum(scratch.rows()) != entry.answer_sum)
        fail(ExitCode::failed,
             fmt::format("the farm that took over answers step {} with other bits than the one before it", entry.clock.step),
             "let farms of one run be of one build, backend, precision and instruction level, and restart from the last checkpoint");
}

} // namespace talik::exchange
