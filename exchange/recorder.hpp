#pragma once
// Writes a lockstep down while it runs. The rows of a step are copied where they come by; another thread compresses them,
// a few steps behind at most; the file itself is written by the thread that calls, at later steps (HDF5 is used by one thread).
//
//     Recorder recorder("record.h5", facts);
//     recorder.begin_step(clock); recorder.request(chunk, rves); ...; recorder.answer(answer, rves); recorder.end_step();
//     recorder.close();
#include <array>
#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>

#include "exchange/driver_end.hpp"
#include "exchange/record_file.hpp"

namespace talik::exchange {

class Recorder {
public:
    // Nothing of an older file of that name is lost before the first step.
    Recorder(std::string file, RecordFacts facts);
    ~Recorder(); // of a run that failed as well: what it recorded so far is on disk
    Recorder(const Recorder&) = delete;
    Recorder& operator=(const Recorder&) = delete;

    // The run goes on from a checkpoint: steps before the next one are kept, where the file is there and of this run.
    void go_on() { goes_on_ = true; }

    void begin_step(const StepClock& clock);
    // Any number of each: rows of a request, whose RVEs are `rves`; rows of answers, whose ids stand for RVEs of the run.
    void request(const Batch& chunk, std::span<const std::uint32_t> rves);
    void answer(const Batch& answer, std::span<const std::uint32_t> rve_of_id);
    void end_step();
    void command(const std::string& name, std::span<const std::byte> payload, std::span<const std::byte> reply);
    void close(); // everything is on disk

    double seconds() const { return seconds_; }                 // of the caller, in all of the above
    double packing_seconds() const { return packing_seconds_; } // CPU time of the other thread

private:
    struct Block { // a step
        enum class State { free, filled, packed } state = State::free;
        RecordedStep step;
        std::vector<RecordedCommand> commands; // given before it
        std::vector<double> request, answer;   // [component][rve]
        std::vector<std::uint8_t> asked;
        std::vector<std::byte> scratch, packed_request, packed_answer;
    };
    static constexpr std::size_t blocks = 4;

    void open(std::uint64_t first_step);
    void keep_steps_before(std::uint64_t first_step);
    void write_oldest(std::unique_lock<std::mutex>& lock); // waits until it is packed
    void pack_blocks();                                    // the other thread

    std::string file_;
    RecordFacts facts_;
    bool goes_on_ = false;
    std::unique_ptr<RecordFile> out_;
    std::vector<RecordedCommand> waiting_commands_; // for the next step
    std::int64_t last_step_ = 0;
    double seconds_ = 0.0;
    bool broken_ = false, closed_ = false; // broken: it could not be written

    std::mutex mutex_;
    std::condition_variable changed_;
    std::array<Block, blocks> ring_;
    std::size_t next_fill_ = 0, next_pack_ = 0, next_write_ = 0; // count up; [i % blocks]
    bool ends_ = false;
    std::atomic<double> packing_seconds_{0.0};
    std::thread packer_;
};

} // namespace talik::exchange
