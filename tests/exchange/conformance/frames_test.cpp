// The conformance suite, frames: what every transport does with them, and what it says of a partner.
#include "exchange/channel.hpp"
#include "common/base/interrupt.hpp"
#include "tests/exchange/support.hpp"
#include "tests/support/catch.hpp"

#include <csignal>
#include <future>
#include <thread>

using namespace talik;
using namespace talik::exchange;
using namespace talik::exchange::test;

namespace {

Frame numbered(std::uint64_t number, std::size_t size) {
    Frame frame;
    frame.type = FrameType::command;
    frame.step = number;
    frame.payload.resize(size);
    for (std::size_t i = 0; i < size; ++i) frame.payload[i] = static_cast<std::byte>((number * 31 + i * 7 + i / 256) % 253);
    return frame;
}

WaitLimits short_stall(double seconds) {
    WaitLimits limits;
    limits.stall_seconds = seconds;
    return limits;
}

} // namespace

TEST_CASE("Frames arrive whole and in order, whatever their size", "[exchange][channel]") {
    const std::string kind = GENERATE(from_range(transports()));
    const bool checksums = GENERATE(false, true);
    CAPTURE(kind, checksums);
    Pair pair = connected_pair(kind, 4096);
    pair.driver->use_checksums(checksums);
    const std::vector<std::size_t> sizes = {0, 1, 7, 63, 64, 65, 4000, 4031, 4032, 4033, 4096, 5000, 40001, 3};
    auto sent = std::async(std::launch::async, [&] {
        for (std::size_t i = 0; i < 20 * sizes.size(); ++i) pair.driver->send(numbered(i, sizes[i % sizes.size()]));
    });
    bool equal = true;
    Frame frame;
    for (std::size_t i = 0; i < 20 * sizes.size(); ++i) {
        pair.farm->receive(frame);
        const Frame expected = numbered(i, sizes[i % sizes.size()]);
        equal = equal && frame.step == i && frame.type == expected.type && frame.payload == expected.payload;
    }
    sent.get();
    CHECK(equal);
}

TEST_CASE("A message far larger than the ring streams through it, both ways at once", "[exchange][channel]") {
    const std::string kind = GENERATE(from_range(transports()));
    const std::size_t size = 8u << 20;
    Pair pair = connected_pair(kind, 65536);
    auto echo = std::async(std::launch::async, [&] {
        Frame frame;
        pair.farm->receive(frame);
        pair.farm->send(frame);
    });
    const Frame sent = numbered(5, size);
    Frame back;
    pair.driver->send(sent);
    pair.driver->receive(back);
    echo.get();
    CHECK(back.payload == sent.payload);
}

TEST_CASE("A full ring refuses a try, and holds back a send until there is room", "[exchange][channel]") {
    const std::string kind = GENERATE(from_range(transports()));
    Pair pair = connected_pair(kind, 4096);
    int fitted = 0;
    while (pair.driver->try_send(numbered(static_cast<std::uint64_t>(fitted), 500))) ++fitted;
    CHECK(fitted == 4096 / 564); // 564 = 500 bytes and a header of 64
    std::atomic<bool> through{false};
    auto sent = std::async(std::launch::async, [&] {
        pair.driver->send(numbered(static_cast<std::uint64_t>(fitted), 500));
        through = true;
    });
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    CHECK_FALSE(through.load());
    Frame frame;
    for (int i = 0; i <= fitted; ++i) {
        pair.farm->receive(frame);
        CHECK(frame.step == static_cast<std::uint64_t>(i));
    }
    sent.get();
    CHECK(pair.driver->waiting_seconds() > 0.05); // it slept through the 100 ms above
}

TEST_CASE("An empty channel has nothing to receive", "[exchange][channel]") {
    const std::string kind = GENERATE(from_range(transports()));
    Pair pair = connected_pair(kind, 4096);
    Frame frame;
    CHECK_FALSE(pair.farm->try_receive(frame));
    pair.driver->send(numbered(1, 10));
    CHECK(pair.farm->try_receive(frame));
    CHECK_FALSE(pair.farm->try_receive(frame));
}

TEST_CASE("A partner that neither works nor speaks has stalled after the set time, not before", "[exchange][channel]") {
    const std::string kind = GENERATE(from_range(transports()));
    Pair pair = connected_pair(kind, 4096, short_stall(0.4));
    pair.farm->advance_progress(17, 400);
    Frame frame;
    ExitCode code = ExitCode::done;
    const auto begin = Clock::now();
    const std::string text = error_text([&] { pair.driver->receive(frame); }, &code);
    CHECK(code == ExitCode::partner_lost);
    CHECK(contains(text, "the farm"));
    CHECK(contains(text, "stalled"));
    CHECK(contains(text, "17 of 400"));
    CHECK(seconds_since(begin) >= 0.4);
    CHECK(seconds_since(begin) < 1.4); // a loaded machine may oversleep some looks
}

TEST_CASE("A slow partner whose work advances is waited for beyond the stall time", "[exchange][channel]") {
    const std::string kind = GENERATE(from_range(transports()));
    Pair pair = connected_pair(kind, 4096, short_stall(0.5));
    auto slow = std::async(std::launch::async, [&] {
        for (int i = 0; i < 30; ++i) { // 1.5 s in all: three times the stall time
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
            pair.farm->advance_progress(static_cast<std::uint64_t>(i), 30);
        }
        pair.farm->send(numbered(1, 10));
    });
    Frame frame;
    CHECK_NOTHROW(pair.driver->receive(frame));
    slow.get();
    CHECK(pair.driver->partner_progress().done == 29);
    CHECK(pair.driver->partner_progress().total == 30);
    CHECK(pair.driver->waiting_seconds() > 1.0);
}

TEST_CASE("A partner that leaves is reported at once, in its own words", "[exchange][channel]") {
    const std::string kind = GENERATE(from_range(transports()));
    Pair pair = connected_pair(kind, 4096);
    Frame frame;
    SECTION("with a cause") {
        pair.farm->state_cause("the packing holds no disc");
        pair.farm->state_cause("a second cause, which is a consequence");
        pair.farm.reset();
        const auto begin = Clock::now();
        const std::string text = error_text([&] { pair.driver->receive(frame); });
        CHECK(contains(text, "reports: the packing holds no disc"));
        CHECK(seconds_since(begin) < 0.5);
    }
    SECTION("without a cause") {
        pair.farm.reset();
        CHECK(contains(error_text([&] { pair.driver->receive(frame); }), "left the exchange without a farewell"));
    }
    SECTION("while the ring is full") {
        while (pair.driver->try_send(numbered(1, 500))) {}
        pair.farm.reset();
        CHECK(contains(error_text([&] { pair.driver->send(numbered(1, 500)); }), "left the exchange"));
    }
}

TEST_CASE("What a partner sent before it left is still received", "[exchange][channel]") {
    const std::string kind = GENERATE(from_range(transports()));
    Pair pair = connected_pair(kind, 4096);
    pair.farm->send(numbered(1, 300));
    pair.farm->send(numbered(2, 300));
    pair.farm.reset();
    Frame frame;
    pair.driver->receive(frame);
    CHECK(frame.step == 1);
    pair.driver->receive(frame);
    CHECK(frame.step == 2);
    CHECK_THROWS_AS(pair.driver->receive(frame), Error);
}

TEST_CASE("Waiting for one of several partners gives up its turn in time, and has not lost patience with the others", "[exchange][channel]") {
    const std::string kind = GENERATE(from_range(transports()));
    Pair pair = connected_pair(kind, 4096, short_stall(0.4));
    pair.farm->advance_progress(1, 2);
    const auto begin = Clock::now();
    CHECK_FALSE(pair.driver->await(std::chrono::milliseconds(5)));
    CHECK(seconds_since(begin) < 0.3); // a loaded machine may oversleep
    CHECK_NOTHROW(pair.driver->look_after());
    pair.farm->send(numbered(1, 10));
    while (!pair.driver->await()) {}
    Frame frame;
    CHECK(pair.driver->try_receive(frame));
    // Patience runs over many short turns as over one long wait.
    CHECK(contains(error_text([&] { for (;;) pair.driver->await(std::chrono::milliseconds(5)); }), "stalled"));
    pair.farm.reset();
    CHECK(contains(error_text([&] { pair.driver->look_after(); }), "left the exchange"));
}

TEST_CASE("An interrupt ends the wait for a partner that has not come at once, and takes the name out of /dev/shm", "[exchange][channel]") {
    const std::string name = unique_name("alone");
    WaitLimits limits;
    limits.grace_after_interrupt_seconds = 100.0;
    std::unique_ptr<Channel> driver = make_shm_channel(name, limits);
    REQUIRE(in_dev_shm(name));
    watch_interrupts();
    std::raise(SIGTERM);
    Frame frame;
    ExitCode code = ExitCode::done;
    const auto begin = Clock::now();
    const std::string text = error_text([&] { driver->receive(frame); }, &code);
    forget_interrupts();
    std::signal(SIGTERM, SIG_DFL);
    CHECK(seconds_since(begin) < 1.0);
    CHECK(code == ExitCode::failed);
    CHECK(contains(text, "interrupted by SIGTERM while waiting for the farm (start again)"));
    driver.reset();
    CHECK_FALSE(in_dev_shm(name));
}

TEST_CASE("An interrupt ends a wait after its grace, and a second one at once", "[exchange][channel]") {
    const std::string kind = GENERATE(from_range(transports()));
    const bool twice = GENERATE(false, true);
    CAPTURE(kind, twice);
    WaitLimits limits;
    limits.grace_after_interrupt_seconds = twice ? 100.0 : 0.3;
    Pair pair = connected_pair(kind, 4096, limits);
    watch_interrupts();
    std::raise(SIGTERM);
    if (twice) std::raise(SIGTERM);
    Frame frame;
    ExitCode code = ExitCode::done;
    const auto begin = Clock::now();
    const std::string text = error_text([&] { pair.driver->receive(frame); }, &code);
    const double waited = seconds_since(begin);
    forget_interrupts();
    CHECK(code == ExitCode::failed);
    CHECK(contains(text, "interrupted by SIGTERM"));
    CHECK(waited < 1.3);
    if (!twice) CHECK(waited > 0.2);
    std::signal(SIGTERM, SIG_DFL);
}
