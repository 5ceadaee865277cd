#include "exchange/driver_end.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "common/base/error.hpp"
#include "common/io/byte_stream.hpp"
#include "exchange/run_board.hpp"

namespace talik::exchange {

namespace {

FrameType reply_to(FrameType question) {
    if (question == FrameType::configure) return FrameType::ready;
    return question == FrameType::bye ? FrameType::bye : FrameType::done;
}

} // namespace

DriverEnd::DriverEnd(Channel& channel, int chunk_size)
    : channel_(channel), chunk_size_(chunk_size > 0 ? chunk_size : channel.rows_per_chunk()) {}

const Hello& DriverEnd::connect(const Hello& hello) {
    hello_ = hello;
    hello_.role = Role::driver;
    outgoing_.type = FrameType::hello;
    outgoing_.payload = encode(hello_);
    send(outgoing_);
    receive(FrameType::hello);
    farm_hello_ = decode_hello(incoming_.payload);
    check_agreement(hello_, farm_hello_);
    request_columns_ = ColumnTable(hello_.request_columns);
    answer_columns_ = ColumnTable(hello_.answer_columns);
    layout_hash_ = exchange::layout_hash(request_columns_, answer_columns_);
    chunk_ = Batch(request_columns_, chunk_size_);
    chunk_answer_ = Batch(answer_columns_, chunk_size_);
    return farm_hello_;
}

std::vector<std::byte> DriverEnd::configure(std::span<const std::byte> payload) {
    return ask(FrameType::configure, {payload.begin(), payload.end()});
}

void DriverEnd::begin_step(const StepClock& clock, int count, Batch& answer) {
    ensure(answer_ == nullptr && layout_hash_ != 0 && count >= 0 && answer.capacity() >= count);
    const auto chunks = static_cast<std::uint32_t>((count + chunk_size_ - 1) / chunk_size_);
    step_ = {hello_.run_id, hello_.epoch, clock.step, clock.time_increment, 0, chunks, clock.substeps,
             static_cast<std::uint32_t>(count)};
    step_count_ = count;
    sent_rows_ = answered_chunks_ = 0;
    BatchHeader whole = step_;
    whole.chunk_count = 1;
    answer.start(whole);
    answer_ = &answer;
}

Batch& DriverEnd::next_chunk() {
    ensure(answer_ != nullptr && sent_rows_ < step_count_);
    step_.count = static_cast<std::uint32_t>(std::min(chunk_size_, step_count_ - sent_rows_));
    chunk_.start(step_);
    return chunk_;
}

void DriverEnd::send_chunk() {
    while (!try_send_chunk()) {
        channel_.receive(incoming_);
        take_answer();
    }
}

bool DriverEnd::try_send_chunk() {
    ensure(answer_ != nullptr && chunk_.header().step == step_.step && chunk_.header().chunk == step_.chunk);
    // The ids stand in the answer already while it is on its way, to be compared with those that come back.
    std::copy(chunk_.ids().begin(), chunk_.ids().end(), answer_->ids().begin() + sent_rows_);
    const Frame& frame = chunk_.frame(FrameType::step_request, layout_hash_);
    while (answered_chunks_ < static_cast<int>(step_.chunk) && channel_.try_receive(incoming_)) take_answer();
    // No room means that requests are waiting, or an answer for us to take: an answer will come. Only with nothing under
    // way may we block, in a frame larger than the ring: then the farm does nothing but read.
    if (!channel_.try_send(frame)) {
        if (answered_chunks_ < static_cast<int>(step_.chunk)) return false;
        send(frame);
    }
    sent_rows_ += chunk_.count();
    ++step_.chunk;
    ++run_board().requests;
    return true;
}

void DriverEnd::finish_step() {
    while (!try_finish_step()) {
        channel_.receive(incoming_);
        take_answer();
    }
}

bool DriverEnd::try_finish_step() {
    ensure(answer_ != nullptr && sent_rows_ == step_count_);
    const int chunks = static_cast<int>(step_.chunk_count);
    while (answered_chunks_ < chunks && channel_.try_receive(incoming_)) take_answer();
    if (answered_chunks_ < chunks) return false;
    answer_ = nullptr;
    return true;
}

// Copies the rows of one answered chunk to their place.
void DriverEnd::take_answer() {
    check_received(FrameType::step_answer);
    chunk_answer_.adopt(incoming_);
    const BatchHeader& header = chunk_answer_.header();
    const int first_row = answered_chunks_ * chunk_size_;
    const auto sent_ids = answer_->ids().subspan(static_cast<std::size_t>(first_row));
    const bool ours = incoming_.layout_hash == layout_hash_ && header.run_id == step_.run_id && header.epoch == step_.epoch &&
                      header.step == step_.step && header.chunk == static_cast<std::uint32_t>(answered_chunks_) &&
                      chunk_answer_.count() == std::min(chunk_size_, step_count_ - first_row) &&
                      std::equal(chunk_answer_.ids().begin(), chunk_answer_.ids().end(), sent_ids.begin());
    if (!ours)
        fail(ExitCode::partner_lost,
             fmt::format("the farm answers chunk {} of step {} (run {:x}, epoch {}) where chunk {} of step {} (run {:x}, epoch {}) "
                         "was asked for, or for other RVEs",
                         header.chunk, header.step, header.run_id, header.epoch, answered_chunks_, step_.step, step_.run_id,
                         step_.epoch),
             "restart from the last checkpoint");
    for (int c = 0; c < answer_columns_.components(); ++c) {
        const std::span<const double> rows = chunk_answer_.component(c);
        std::copy(rows.begin(), rows.end(), answer_->component(c).begin() + first_row);
    }
    ++answered_chunks_;
    ++run_board().answers;
}

void DriverEnd::step(const StepClock& clock, const Batch& request, Batch& answer) {
    ensure(request.columns().columns() == request_columns_.columns() && answer.columns().columns() == answer_columns_.columns());
    begin_step(clock, request.count(), answer);
    while (sent_rows_ < step_count_) {
        Batch& chunk = next_chunk();
        const auto count = static_cast<std::size_t>(chunk.count()), first = static_cast<std::size_t>(sent_rows_);
        const auto ids = request.ids().subspan(first, count);
        std::copy(ids.begin(), ids.end(), chunk.ids().begin());
        for (int c = 0; c < request_columns_.components(); ++c) {
            const auto rows = request.component(c).subspan(first, count);
            std::copy(rows.begin(), rows.end(), chunk.component(c).begin());
        }
        send_chunk();
    }
    finish_step();
}

std::vector<std::byte> encode_command(const std::string& name, std::span<const std::byte> payload) {
    ByteWriter out;
    out.text(name);
    out.array(payload);
    return out.take();
}

std::vector<std::byte> encode_path(const std::string& path) {
    ByteWriter out;
    out.text(path);
    return out.take();
}

std::vector<std::byte> DriverEnd::command(const std::string& name, std::span<const std::byte> payload) {
    return ask(FrameType::command, encode_command(name, payload));
}

void DriverEnd::checkpoint(const std::string& path) { ask(FrameType::checkpoint, encode_path(path)); }
void DriverEnd::restore(const std::string& path) { ask(FrameType::restore, encode_path(path)); }
void DriverEnd::bye() { ask(FrameType::bye); }

void DriverEnd::post(FrameType question, std::vector<std::byte> payload) {
    ensure(answer_ == nullptr);
    outgoing_.type = question;
    outgoing_.layout_hash = layout_hash_;
    outgoing_.payload = std::move(payload);
    reply_due_ = reply_to(question);
    send(outgoing_);
}

std::optional<std::vector<std::byte>> DriverEnd::try_reply() {
    if (!channel_.try_receive(incoming_)) return std::nullopt;
    check_received(reply_due_);
    return incoming_.payload;
}

std::vector<std::byte> DriverEnd::ask(FrameType question, std::vector<std::byte> payload) {
    post(question, std::move(payload));
    receive(reply_due_);
    return incoming_.payload;
}

// A farm that failed has said why before it left: its own error, with its exit code, comes before "the farm is lost".
void DriverEnd::send(const Frame& frame) {
    try {
        channel_.send(frame);
    } catch (const Error&) {
        while (channel_.try_receive(incoming_))
            if (incoming_.type == FrameType::error) rethrow_error(incoming_.payload, Role::farm);
        throw;
    }
}

void DriverEnd::receive(FrameType expected) {
    channel_.receive(incoming_);
    check_received(expected);
}

void DriverEnd::check_received(FrameType expected) const {
    if (incoming_.type == FrameType::error) rethrow_error(incoming_.payload, Role::farm);
    if (incoming_.type != expected)
        fail(ExitCode::partner_lost,
             fmt::format("the farm sends '{}' where '{}' is due", name_of(incoming_.type), name_of(expected)),
             "use driver and farm of the same version of Talik");
}

} // namespace talik::exchange
