#include "exchange/farm_end.hpp"

#include <algorithm>
#include <cstring>
#include <fmt/format.h>

#include "common/base/error.hpp"
#include "common/base/interrupt.hpp"
#include "common/base/stage_timer.hpp"
#include "common/io/byte_stream.hpp"
#include "exchange/run_board.hpp"

namespace talik::exchange {
namespace {

[[noreturn]] void out_of_turn(FrameType type, const char* problem) {
    fail(ExitCode::partner_lost, fmt::format("the driver sends '{}' {}", name_of(type), problem),
         "use driver and farm of the same version of Talik");
}

} // namespace

FarmEnd::FarmEnd(Channel& channel, FarmService& service, std::string program)
    : channel_(channel), service_(service), program_(std::move(program)) {}

void FarmEnd::serve() {
    try {
        greet();
        while (handle()) {
            // The driver is given time to end the run in order; it learns of the wish with its next look.
            if (interrupted()) channel_.wish_to_end();
            if (interrupted() && seconds_since_interrupt() > channel_.limits().grace_after_interrupt_seconds)
                fail(ExitCode::failed, fmt::format("ended by {}", interrupt_name()), "restart from the last checkpoint");
        }
    } catch (const std::exception& error) {
        tell(error);
        throw;
    }
}

void FarmEnd::greet() {
    channel_.receive(incoming_);
    if (incoming_.type != FrameType::hello) out_of_turn(incoming_.type, "where 'hello' is due");
    driver_ = decode_hello(incoming_.payload);
    Hello own;
    own.role = Role::farm;
    own.program = program_;
    own.run_id = driver_.run_id;
    own.epoch = driver_.epoch;
    own.scene_hash = driver_.scene_hash;
    own.request_columns = service_.understands();
    own.answer_columns = service_.offers();
    check_agreement(driver_, own);
    request_columns_ = ColumnTable(driver_.request_columns);
    answer_columns_ = ColumnTable(driver_.answer_columns);
    layout_hash_ = exchange::layout_hash(request_columns_, answer_columns_);
    service_.agreed(driver_);
    run_board().run_id = driver_.run_id;
    reply(FrameType::hello, encode(own));
}

// What a receive takes beyond waiting is copying.
void FarmEnd::receive() {
    const double waited = channel_.waiting_seconds();
    double elapsed = 0.0;
    {
        const StageTimer::Scope timing(elapsed);
        channel_.receive(incoming_);
    }
    if (!configured_) return;
    const double waiting = channel_.waiting_seconds() - waited;
    times_.waiting += waiting;
    times_.copying += std::max(0.0, elapsed - waiting);
}

void FarmEnd::show_standing() const {
    Board& board = run_board();
    board.step = incoming_.step;
    if (board.first_step == 0) board.first_step = incoming_.step;
    board.computing = times_.computing, board.copying = times_.copying, board.waiting = times_.waiting;
    board.updated = monotonic_seconds();
}

bool FarmEnd::handle() {
    receive();
    ByteReader in(incoming_.payload, name_of(incoming_.type));
    switch (incoming_.type) {
    case FrameType::configure:
        reply(FrameType::ready, service_.configure(incoming_.payload, channel_));
        configured_ = true;
        return true;
    case FrameType::step_request: answer_step(); return true;
    case FrameType::command: {
        const std::string name = in.text();
        const auto payload = in.array<std::byte>();
        in.finish();
        if (name == "times") { // of this end, whatever answers behind it
            ByteWriter times;
            times.put(times_);
            reply(FrameType::done, times.take());
        } else {
            reply(FrameType::done, service_.command(name, payload));
        }
        return true;
    }
    case FrameType::checkpoint:
        service_.checkpoint(in.text());
        reply(FrameType::done);
        return true;
    case FrameType::restore:
        service_.restore(in.text());
        reply(FrameType::done);
        return true;
    case FrameType::bye: reply(FrameType::bye); return false;
    case FrameType::error: rethrow_error(incoming_.payload, Role::driver);
    case FrameType::hello:
    case FrameType::ready:
    case FrameType::step_answer:
    case FrameType::done: break;
    }
    out_of_turn(incoming_.type, "which is not for a farm to receive");
}

void FarmEnd::answer_step() {
    if (!configured_) out_of_turn(incoming_.type, "before 'configure'");
    if (incoming_.layout_hash != layout_hash_) out_of_turn(incoming_.type, "with another layout of its columns than agreed");
    // The first chunk, or one larger than all before it, sizes the batches.
    BatchHeader header;
    if (incoming_.payload.size() >= sizeof header) std::memcpy(&header, incoming_.payload.data(), sizeof header);
    const bool plausible = header.count <= incoming_.payload.size() / (sizeof(double) * static_cast<std::size_t>(request_columns_.components()));
    if (plausible && static_cast<int>(header.count) > request_.capacity()) {
        request_ = Batch(request_columns_, static_cast<int>(header.count));
        answer_ = Batch(answer_columns_, static_cast<int>(header.count));
    }
    if (request_.capacity() == 0) request_ = Batch(request_columns_, 0), answer_ = Batch(answer_columns_, 0);
    request_.adopt(incoming_);
    if (header.run_id != driver_.run_id || header.epoch != driver_.epoch)
        fail(ExitCode::partner_lost,
             fmt::format("a request of run {:x}, epoch {} came to the farm of run {:x}, epoch {}", header.run_id, header.epoch,
                         driver_.run_id, driver_.epoch),
             "give each run its own --exchange name");
    answer_.start(request_.header());
    std::copy(request_.ids().begin(), request_.ids().end(), answer_.ids().begin());
    ++run_board().requests;
    {
        const StageTimer::Scope timing(times_.computing);
        service_.answer(request_, answer_, channel_);
    }
    const double waited = channel_.waiting_seconds();
    {
        const StageTimer::Scope timing(times_.copying);
        channel_.send(answer_.frame(FrameType::step_answer, layout_hash_));
    }
    times_.waiting += channel_.waiting_seconds() - waited;
    times_.copying -= channel_.waiting_seconds() - waited;
    ++run_board().answers;
    show_standing();
}

void FarmEnd::reply(FrameType type, std::vector<std::byte> payload) {
    outgoing_.type = type;
    outgoing_.layout_hash = layout_hash_;
    outgoing_.step = incoming_.step;
    outgoing_.payload = std::move(payload);
    channel_.send(outgoing_);
}

// The partner may be what failed: then nobody waits for it to make room, and no second error hides the first.
void FarmEnd::tell(const std::exception& error) noexcept {
    try {
        const auto* ours = dynamic_cast<const Error*>(&error);
        outgoing_.type = FrameType::error;
        outgoing_.payload = encode_error(error);
        if (ours && ours->code() == ExitCode::partner_lost)
            channel_.try_send(outgoing_);
        else
            channel_.send(outgoing_);
    } catch (const std::exception&) {
    }
    channel_.state_cause(error.what());
}

} // namespace talik::exchange
