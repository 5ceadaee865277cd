#pragma once
// The driver's end of the lockstep. A step goes out in chunks while earlier chunks are being answered: the exchange is a
// pipeline, and neither side can block the other, because a full ring of requests makes the driver take answers.
//
//     DriverEnd farm(channel);
//     farm.connect(hello);
//     farm.configure(payload);
//     farm.step(request, answer);            // or begin_step, next_chunk, send_chunk, ..., finish_step
//     farm.bye();
#include <optional>
#include <string>

#include "exchange/batch.hpp"
#include "exchange/channel.hpp"
#include "exchange/hello.hpp"

namespace talik::exchange {

// The macro step that a batch belongs to.
struct StepClock {
    std::uint64_t step = 0;      // counted from 1; a step already answered may be asked for again
    double time_increment = 0.0; // s
    std::uint32_t substeps = 0;  // 0 = the farm decides
};

class DriverEnd {
public:
    explicit DriverEnd(Channel& channel, int chunk_size = 0); // of RVEs; 0 = as suits the channel

    // Returns the farm's hello. Any mismatch is an error that names its fields.
    const Hello& connect(const Hello& hello);
    // Returns what the farm has to say about what it set up.
    std::vector<std::byte> configure(std::span<const std::byte> payload);

    // A table for `capacity` RVEs with the agreed columns.
    Batch make_request(int capacity) const { return Batch(request_columns_, capacity); }
    Batch make_answer(int capacity) const { return Batch(answer_columns_, capacity); }

    // Row i of the answer belongs to row i of the request; clock, ids and columns of the request are filled in.
    void step(const StepClock& clock, const Batch& request, Batch& answer);

    // The same in pieces: `count` rows in all; the rows of each chunk are filled into next_chunk() and then sent.
    // `answer` is filled as answers arrive, and is whole after finish_step().
    void begin_step(const StepClock& clock, int count, Batch& answer);
    Batch& next_chunk();
    void send_chunk();
    void finish_step();
    // The same without blocking, for who has several farms. False: no room yet (an answer will come before there is), or
    // answers still to come.
    bool try_send_chunk();
    bool try_finish_step();

    std::vector<std::byte> command(const std::string& name, std::span<const std::byte> payload = {});
    void checkpoint(const std::string& path);
    void restore(const std::string& path);
    void bye();
    // Any of these questions in two halves: the reply is taken once it has come.
    void post(FrameType question, std::vector<std::byte> payload = {});
    std::optional<std::vector<std::byte>> try_reply();

    int chunk_size() const { return chunk_size_; }
    std::uint64_t layout_hash() const { return layout_hash_; }
    Channel& channel() { return channel_; }

private:
    void send(const Frame& frame);
    void receive(FrameType expected);
    void check_received(FrameType expected) const;
    std::vector<std::byte> ask(FrameType question, std::vector<std::byte> payload = {});
    void take_answer();

    Channel& channel_;
    int chunk_size_;
    Hello hello_, farm_hello_;
    ColumnTable request_columns_, answer_columns_;
    std::uint64_t layout_hash_ = 0;

    BatchHeader step_; // of the step under way; chunk: the next one to be sent
    int step_count_ = 0, sent_rows_ = 0, answered_chunks_ = 0;
    Batch chunk_, chunk_answer_;
    Batch* answer_ = nullptr;
    Frame outgoing_, incoming_;
    FrameType reply_due_ = FrameType::done;
};

// The payload of a command or of a path, as a farm reads it.
std::vector<std::byte> encode_command(const std::string& name, std::span<const std::byte> payload);
std::vector<std::byte> encode_path(const std::string& path);

} // namespace talik::exchange
