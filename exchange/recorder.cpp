#include "exchange/recorder.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fmt/format.h>
#include <limits>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "common/base/stage_timer.hpp"
#include "common/io/text_file.hpp"

namespace talik::exchange {
namespace {

namespace fs = std::filesystem;

double cpu_seconds_of_this_thread() {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

std::string part_of(const std::string& file) { return file + ".part"; }

} // namespace

Recorder::Recorder(std::string file, RecordFacts facts) : file_(std::move(file)), facts_(std::move(facts)) {
    const fs::path folder = fs::path(file_).parent_path();
    if (!folder.empty()) make_folder(folder);
    check_place_of_record(file_);
    out_ = std::make_unique<RecordFile>(part_of(file_), facts_); // a place that cannot be written to shows here
    const auto columns = [](const std::vector<Column>& list) { return static_cast<std::size_t>(ColumnTable(list).components()); };
    for (Block& block : ring_) {
        block.request.resize(columns(facts_.request_columns) * facts_.rves);
        block.answer.resize(columns(facts_.answer_columns) * facts_.rves);
        block.asked.resize(facts_.rves);
    }
    packer_ = std::thread([this] { pack_blocks(); });
}

Recorder::~Recorder() {
    try {
        if (!broken_) close();
    } catch (const std::exception&) { // the run has ended already, and said why
    }
    {
        const std::lock_guard lock(mutex_);
        ends_ = true;
    }
    changed_.notify_all();
    packer_.join();
    std::error_code ignored;
    if (next_write_ == 0) fs::remove(part_of(file_), ignored); // of a run that never came to its first step
}

void Recorder::open(std::uint64_t first_step) {
    if (goes_on_) keep_steps_before(first_step);
    std::error_code why;
    fs::rename(part_of(file_), file_, why);
    if (why) throw Error(ExitCode::bad_input, file_, "cannot be made: " + why.message(), "name another file with --record");
}

void Recorder::keep_steps_before(std::uint64_t first_step) {
    if (!fs::exists(file_)) {
        log::warn("{}: no recording to go on with: it begins with step {}", file_, first_step);
        return;
    }
    const Record old(file_);
    const RecordFacts& facts = old.facts();
    if (facts.scene_hash != facts_.scene_hash || facts.rves != facts_.rves || facts.request_columns != facts_.request_columns || facts.answer_columns != facts_.answer_columns)
        throw Error(ExitCode::bad_input, file_, "is the recording of another run", "name another file with --record");
    waiting_commands_.clear(); // given again at the start of a run that goes on; the old file has them
    Block& block = ring_[0];
    std::size_t command = 0, kept = 0;
    const auto commands_until = [&](std::int64_t step) {
        for (; command < old.commands().size() && old.commands()[command].after_step <= step; ++command) out_->add(old.commands()[command]);
    };
    for (std::size_t i = 0; i < old.steps().size() && old.steps()[i].step < static_cast<std::int64_t>(first_step); ++i, ++kept) {
        const RecordedStep& step = old.steps()[i];
        commands_until(step.step - 1);
        old.read_request(i, block.request);
        old.read_answer(i, block.answer);
        old.read_asked(i, block.asked);
        pack_row(block.request, block.scratch, block.packed_request);
        pack_row(block.answer, block.scratch, block.packed_answer);
        const bool all = step.asked == static_cast<std::int64_t>(facts_.rves);
        out_->add(step, block.packed_request, block.packed_answer, all ? std::span<const std::uint8_t>() : block.asked);
    }
    commands_until(static_cast<std::int64_t>(first_step) - 1);
    out_->flush();
    log::info("{}: goes on after {} recorded steps", file_, kept);
}

void Recorder::begin_step(const StepClock& clock) {
    const StageTimer::Scope timing(seconds_);
    if (next_fill_ == 0) open(clock.step);
    std::unique_lock lock(mutex_);
    if (next_fill_ - next_write_ == blocks) write_oldest(lock);
    Block& block = ring_[next_fill_ % blocks];
    block.step = {static_cast<std::int64_t>(clock.step), clock.substeps, 0, clock.time_increment};
    block.commands = std::move(waiting_commands_);
    waiting_commands_.clear();
    std::fill(block.asked.begin(), block.asked.end(), std::uint8_t{0});
}

void Recorder::request(const Batch& chunk, std::span<const std::uint32_t> rves) {
    const StageTimer::Scope timing(seconds_);
    Block& block = ring_[next_fill_ % blocks];
    for (const std::uint32_t rve : rves) {
        ensure(rve < facts_.rves);
        block.step.asked += block.asked[rve] == 0; // a farm that takes over is asked again
        block.asked[rve] = 1;
    }
    for (int c = 0; c < chunk.columns().components(); ++c) {
        const auto rows = chunk.component(c);
        double* out = &block.request[static_cast<std::size_t>(c) * facts_.rves];
        for (std::size_t i = 0; i < rves.size(); ++i) out[rves[i]] = rows[i];
    }
}

void Recorder::answer(const Batch& answer, std::span<const std::uint32_t> rve_of_id) {
    const StageTimer::Scope timing(seconds_);
    Block& block = ring_[next_fill_ % blocks];
    const auto ids = answer.ids();
    for (int c = 0; c < answer.columns().components(); ++c) {
        const auto rows = answer.component(c);
        double* out = &block.answer[static_cast<std::size_t>(c) * facts_.rves];
        for (std::size_t i = 0; i < ids.size(); ++i) out[rve_of_id[ids[i]]] = rows[i];
    }
}

void Recorder::end_step() {
    const StageTimer::Scope timing(seconds_);
    Block& block = ring_[next_fill_ % blocks];
    if (block.step.asked < static_cast<std::int64_t>(facts_.rves)) {
        constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
        for (auto* values : {&block.request, &block.answer})
            for (std::size_t i = 0; i < values->size(); ++i)
                if (!block.asked[i % facts_.rves]) (*values)[i] = nothing;
    }
    last_step_ = block.step.step;
    std::unique_lock lock(mutex_);
    block.state = Block::State::filled;
    ++next_fill_;
    changed_.notify_all();
    while (next_write_ < next_fill_ && ring_[next_write_ % blocks].state == Block::State::packed) write_oldest(lock);
}

void Recorder::command(const std::string& name, std::span<const std::byte> payload, std::span<const std::byte> reply) {
    waiting_commands_.push_back({last_step_, name, {payload.begin(), payload.end()}, {reply.begin(), reply.end()}});
}

void Recorder::write_oldest(std::unique_lock<std::mutex>& lock) {
    Block& block = ring_[next_write_ % blocks];
    changed_.wait(lock, [&] { return block.state == Block::State::packed; });
    lock.unlock();
    broken_ = true; // unless what follows succeeds
    for (const RecordedCommand& command : block.commands) out_->add(command);
    const bool all = block.step.asked == static_cast<std::int64_t>(facts_.rves);
    out_->add(block.step, block.packed_request, block.packed_answer, all ? std::span<const std::uint8_t>() : block.asked);
    out_->flush();
    broken_ = false;
    lock.lock();
    block.state = Block::State::free;
    ++next_write_;
}

void Recorder::pack_blocks() {
    std::unique_lock lock(mutex_);
    for (;;) {
        Block& block = ring_[next_pack_ % blocks];
        changed_.wait(lock, [&] { return ends_ || block.state == Block::State::filled; });
        if (block.state != Block::State::filled) return;
        lock.unlock();
        pack_row(block.request, block.scratch, block.packed_request);
        pack_row(block.answer, block.scratch, block.packed_answer);
        packing_seconds_ = cpu_seconds_of_this_thread();
        lock.lock();
        block.state = Block::State::packed;
        ++next_pack_;
        changed_.notify_all();
    }
}

void Recorder::close() {
    const StageTimer::Scope timing(seconds_);
    if (next_fill_ == 0 || closed_) return;
    std::unique_lock lock(mutex_);
    while (next_write_ < next_fill_) write_oldest(lock);
    lock.unlock();
    for (const RecordedCommand& command : waiting_commands_) out_->add(command);
    waiting_commands_.clear();
    out_->close();
    closed_ = true;
}

} // namespace talik::exchange
