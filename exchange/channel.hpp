#pragma once
// A pipe of frames to the one partner. send() blocks while the partner has not made room (that is the back-pressure),
// receive() while nothing has come; both are bounded and explained as wait.hpp says, and throw Error(partner_lost).
// One thread uses a channel at a time; advance_progress() and state_cause() may be called from any.
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "exchange/frame.hpp"
#include "exchange/wait.hpp"

namespace talik::exchange {

class Channel {
public:
    virtual ~Channel() = default;
    Channel(const Channel&) = delete;
    Channel& operator=(const Channel&) = delete;

    void send(const Frame& frame);
    bool try_send(const Frame& frame); // false, and nothing sent, where the whole frame does not fit right now
    void receive(Frame& frame);
    bool try_receive(Frame& frame); // false where no frame has come

    // For who listens to several partners. await: sleeps at most one look's interval for something to receive, true once it
    // has come; patient like receive() over as many calls as it takes. look_after: throws if the partner is gone, else returns.
    bool await(std::chrono::milliseconds longest = Patience::look_interval);
    void look_after();
    // How many RVEs make a message worth sending: fewer would cost, more would spoil the pipeline.
    virtual int rows_per_chunk() const { return 512; }

    // The work tells where it stands: this, not a heartbeat, is what keeps the partner patient.
    virtual void advance_progress(std::uint64_t done, std::uint64_t total) noexcept = 0;
    virtual PartnerProgress partner_progress() const = 0;

    // Why this side is about to end, in one line, for the partner to quote. The first cause stays.
    virtual void state_cause(const std::string& cause) noexcept = 0;
    virtual std::string partner_cause() const = 0; // its own, where it stated one; else empty
    // This side was asked to end (Ctrl-C, SIGTERM), and would like the partner to bring the run to an orderly end.
    virtual void wish_to_end() noexcept = 0;
    virtual bool partner_wishes_to_end() const noexcept = 0;

    // Whoever launched the partner knows more of its end than can be seen from here; empty = it still runs.
    void ask_fate(std::function<std::optional<std::string>()> fate) { fate_ = std::move(fate); }
    void use_checksums(bool on) { checksums_ = on; }

    Role role() const { return role_; }
    double waiting_seconds() const { return waiting_seconds_; } // of this side, in all sends and receives so far
    const WaitLimits& limits() const { return limits_; }

protected:
    Channel(Role role, const WaitLimits& limits) : role_(role), limits_(limits) {}

    // True once what is waited for is there.
    using Ready = std::function<bool()>;
    void wait(const Ready& ready); // bounded and explained
    // What a wait is made of. nap: one sleep of at most `longest`, shorter where ready() may have turned true.
    virtual void nap(const Ready& ready, std::chrono::milliseconds longest) = 0;
    virtual bool spin(const Ready&) { return false; } // a few microseconds, before the first nap
    virtual PartnerView look() = 0;

    // The byte pipe below: write() and read() block until all is done; flush() makes what was written visible.
    virtual std::size_t room() const = 0;
    virtual std::size_t available() const = 0;
    virtual void write(std::span<const std::byte> bytes) = 0;
    virtual void flush() = 0;
    virtual void read(std::span<std::byte> bytes) = 0;

    // The fate of the partner where it has ended and somebody can tell; else empty.
    std::string fate() const;
    double waiting_seconds_ = 0.0;

private:
    bool sleep_once(const Ready& ready, std::chrono::milliseconds longest, Patience& patience);
    std::optional<Patience> awaiting_; // of the await() under way
    Role role_;
    WaitLimits limits_;
    bool checksums_ = false;
    std::function<std::optional<std::string>()> fate_;
};

// Runs the body of a program; should it end by an exception, the partner learns why.
template <class Body>
auto with_cause(Channel& channel, Body&& body) {
    try {
        return body();
    } catch (const std::exception& error) {
        channel.state_cause(error.what());
        throw;
    }
}

} // namespace talik::exchange
