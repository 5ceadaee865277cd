#pragma once
// The farm's end of the lockstep: a loop that answers the driver until it says bye, whatever it is that computes stresses.
#include <string>

#include "exchange/batch.hpp"
#include "exchange/channel.hpp"
#include "exchange/hello.hpp"

namespace talik::exchange {

// Whoever answers strain increments. Errors are thrown: they travel to the driver with their exit code and text.
class FarmService {
public:
    virtual ~FarmService() = default;

    virtual std::vector<Column> understands() const = 0; // request columns
    virtual std::vector<Column> offers() const = 0;      // answer columns

    // What was agreed on: the driver's hello (its run, epoch and columns, in the order of the batches).
    virtual void agreed(const Hello& driver) = 0;
    // Returns what the driver is to know of what was set up. `progress`: to be advanced by long work, from any thread.
    virtual std::vector<std::byte> configure(std::span<const std::byte> payload, Channel& progress) = 0;
    // Fills the columns of `answer`, whose header and ids already equal the request's.
    virtual void answer(const Batch& request, Batch& answer, Channel& progress) = 0;
    virtual std::vector<std::byte> command(const std::string& name, std::span<const std::byte> payload) = 0;
    virtual void checkpoint(const std::string& path) = 0;
    virtual void restore(const std::string& path) = 0;
};

// Wall time of one side in steps, s: its own work, moving messages, and waiting for the partner.
struct LockstepTimes {
    double computing = 0.0, copying = 0.0, waiting = 0.0;
};

class FarmEnd {
public:
    FarmEnd(Channel& channel, FarmService& service, std::string program);

    // Returns when the driver has said bye; throws what ended it otherwise, after the driver was told.
    void serve();

private:
    void greet();
    bool handle(); // false after bye
    void receive();
    void answer_step();
    void show_standing() const;
    void reply(FrameType type, std::vector<std::byte> payload = {});
    void tell(const std::exception& error) noexcept;

    Channel& channel_;
    FarmService& service_;
    std::string program_;
    Hello driver_;
    std::uint64_t layout_hash_ = 0;
    bool configured_ = false;
    LockstepTimes times_; // since it was configured
    Batch request_, answer_;
    ColumnTable request_columns_, answer_columns_;
    Frame incoming_, outgoing_;
};

} // namespace talik::exchange
