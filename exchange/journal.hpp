#pragma once
// What a farm was asked since its last confirmed checkpoint, so that a replacement, restored from there, can be brought to
// the present by asking again. Each step keeps the checksum of its answer: the same bits must come back.
#include <cstdint>
#include <string>
#include <vector>

#include "exchange/driver_end.hpp"

namespace talik::exchange {

class Journal {
public:
    void begin_step(const StepClock& clock, int count);
    void chunk(const Batch& request);          // of the step begun, as it is sent
    void end_step(const Batch& answer);
    void drop_step();                          // the one begun and not ended, if any
    void command(const std::string& name, std::span<const std::byte> payload);
    void clear();                              // a checkpoint holds all of it

    std::size_t bytes() const { return bytes_.size(); }
    int steps() const { return steps_; }

    // Asks all of it again, in order. `scratch`: room for the answers of one step. `tick` is called between the questions.
    void replay(DriverEnd& farm, Batch& scratch, const std::function<void()>& tick) const;

private:
    struct Entry {
        bool is_step = true;
        bool ended = false;
        StepClock clock;
        int count = 0;                      // RVEs of the step
        std::size_t begin = 0, size = 0;    // of its bytes: rows chunk by chunk, or the command's payload
        std::uint64_t answer_sum = 0;
        std::string name;                   // of the command
    };
    void replay_step(const Entry& entry, DriverEnd& farm, Batch& scratch) const;
    std::vector<Entry> entries_;
    std::vector<std::byte> bytes_;
    int steps_ = 0;
};

} // namespace talik::exchange
