// The conformance suite, protocol: the two ends over every transport, told like a protocol.
#include "exchange/driver_end.hpp"
#include "exchange/farm_end.hpp"
#include "tests/exchange/support.hpp"
#include "tests/support/catch.hpp"

#include <future>

using namespace talik;
using namespace talik::exchange;
using namespace talik::exchange::test;

namespace {

// A farm serving in a thread, until bye or its error.
struct Served {
    Pair pair;
    SummingFarm service;
    std::future<std::string> ended;

    explicit Served(const std::string& kind, std::size_t ring_bytes = 1u << 16) : pair(connected_pair(kind, ring_bytes)) {}
    void start() {
        ended = std::async(std::launch::async, [this] {
            return error_text([this] {
                const std::unique_ptr<Channel> own = std::move(pair.farm);
                FarmEnd(*own, service, "test-farm").serve();
            });
        });
    }
};

// Every number of three steps, as the driver sees them.
std::vector<double> run_three_steps(const std::string& kind, std::size_t ring_bytes, int count, int chunk_size, bool resend) {
    Served farm(kind, ring_bytes);
    farm.start();
    DriverEnd driver(*farm.pair.driver, chunk_size);
    driver.connect(driver_hello());
    driver.configure(setup_for(count));
    Batch request = driver.make_request(count), answer = driver.make_answer(count);
    std::vector<double> values;
    for (std::uint64_t step = 1; step <= 3; ++step) {
        fill(request, count, 0.1 / static_cast<double>(step));
        for (int time = 0; time < (resend ? 3 : 1); ++time) driver.step({step, 1e-3, 0}, request, answer);
        for (int c = 0; c < 5; ++c) values.insert(values.end(), answer.component(c).begin(), answer.component(c).end());
    }
    driver.bye();
    farm.ended.get();
    return values;
}

} // namespace

TEST_CASE("Any chunking, ring and channel gives the same bits, and so do steps asked for again", "[exchange][lockstep]") {
    const int count = GENERATE(1, 31, 512, 513, 2000);
    CAPTURE(count);
    const std::vector<double> reference = run_three_steps("loopback", 1u << 20, count, 4096, false);
    REQUIRE(reference.size() == static_cast<std::size_t>(3 * 5 * count));
    for (const std::string& kind : transports())
        for (std::size_t ring_bytes : {4096, 65536}) // the small ring holds less than one chunk of 512
            for (int chunk_size : {100, 512})
                for (bool resend : {false, true})
                    CHECK(run_three_steps(kind, ring_bytes, count, chunk_size, resend) == reference);
}

TEST_CASE("A step addresses any subset of the RVEs, and answers come in its order", "[exchange][lockstep]") {
    const std::string kind = GENERATE(from_range(transports()));
    Served farm(kind);
    farm.start();
    DriverEnd driver(*farm.pair.driver, 2);
    driver.connect(driver_hello());
    driver.configure(setup_for(10));
    Batch answer = driver.make_answer(3);
    const std::vector<std::uint32_t> ids = {8, 0, 3};
    driver.begin_step({1, 1e-3, 0}, 3, answer);
    for (std::size_t sent = 0; sent < ids.size();) {
        Batch& chunk = driver.next_chunk();
        for (std::size_t row = 0; row < chunk.ids().size(); ++row, ++sent) {
            chunk.ids()[row] = ids[sent];
            for (int c = 0; c < 4; ++c) chunk.component(c)[row] = c == 0 ? 0.5 : 0.0;
        }
        driver.send_chunk();
    }
    driver.finish_step();
    for (std::size_t row = 0; row < ids.size(); ++row) CHECK(answer.component(0, 0)[row] == 0.5 * (1.0 + ids[row]));
    driver.begin_step({2, 1e-3, 0}, 0, answer); // nobody
    driver.finish_step();
    CHECK(answer.count() == 0);
    driver.bye();
    CHECK(farm.ended.get() == "no error");
    CHECK(farm.service.computed == 3);
}

TEST_CASE("Configuration, commands and checkpoints reach the farm, however large", "[exchange][lockstep]") {
    const std::string kind = GENERATE(from_range(transports()));
    Served farm(kind, 4096);
    farm.start();
    DriverEnd driver(*farm.pair.driver);
    CHECK(driver.connect(driver_hello()).program == "test-farm");
    const std::vector<std::byte> ready = driver.configure(setup_for(5, 3'000'000));
    CHECK(ByteReader(ready, "ready").get<std::int32_t>() == 5);
    const std::vector<std::byte> payload(100'000, std::byte{9});
    CHECK(driver.command("echo", payload) == payload);
    driver.checkpoint("folder/of the/checkpoint");
    driver.restore("another");
    driver.bye();
    CHECK(farm.ended.get() == "no error");
    CHECK(farm.service.configured_bytes > 3'000'000);
    CHECK(farm.service.checkpointed == "folder/of the/checkpoint");
    CHECK(farm.service.restored == "another");
}

TEST_CASE("The farm's own error reaches the driver with its exit code, place and remedy", "[exchange][lockstep]") {
    const std::string kind = GENERATE(from_range(transports()));
    const std::string state = GENERATE(as<std::string>{}, "configure", "answer", "command", "checkpoint", "restore");
    CAPTURE(kind, state);
    Served farm(kind, 4096);
    farm.service.on = [&](const std::string& at) {
        if (at == state) throw Error(ExitCode::out_of_resource, "RVE 3", "no memory for its contacts", "use fewer discs");
    };
    farm.start();
    ExitCode code = ExitCode::done;
    const std::string text = error_text(
        [&] {
            DriverEnd driver(*farm.pair.driver, 16);
            driver.connect(driver_hello());
            driver.configure(setup_for(1000));
            Batch request = driver.make_request(1000), answer = driver.make_answer(1000);
            fill(request, 1000, 0.1);
            driver.step({1, 1e-3, 0}, request, answer);
            driver.command("echo");
            driver.checkpoint("here");
            driver.restore("here");
        },
        &code);
    CHECK(code == ExitCode::out_of_resource);
    CHECK(text == "RVE 3: the farm reports: no memory for its contacts (use fewer discs)");
    CHECK(contains(farm.ended.get(), "no memory for its contacts")); // and ends the farm
}

TEST_CASE("Columns that do not fit end the handshake on both sides, named", "[exchange][lockstep]") {
    const std::string kind = GENERATE(from_range(transports()));
    Served farm(kind);
    farm.start();
    Hello hello = driver_hello();
    hello.answer_columns.push_back({"colour", 3, "1", ""});
    DriverEnd driver(*farm.pair.driver);
    ExitCode code = ExitCode::done;
    CHECK(contains(error_text([&] { driver.connect(hello); }, &code), "column 'colour' is asked for, but not offered"));
    CHECK(code == ExitCode::bad_input);
    CHECK(contains(farm.ended.get(), "column 'colour'"));
}

TEST_CASE("A farm answers no step before its configuration, and none of another run or layout", "[exchange][lockstep]") {
    const std::string kind = GENERATE(from_range(transports()));
    const std::string fault = GENERATE(as<std::string>{}, "unconfigured", "run", "epoch", "layout");
    CAPTURE(kind, fault);
    Served farm(kind);
    farm.start();
    DriverEnd driver(*farm.pair.driver);
    driver.connect(driver_hello());
    if (fault != "unconfigured") driver.configure(setup_for(5));
    Batch request = driver.make_request(1);
    BatchHeader header;
    header.run_id = fault == "run" ? 1 : driver_hello().run_id;
    header.epoch = fault == "epoch" ? 99 : driver_hello().epoch;
    header.step = 1;
    header.count = 1;
    request.start(header);
    farm.pair.driver->send(request.frame(FrameType::step_request, driver.layout_hash() + (fault == "layout" ? 1 : 0)));
    const std::string text = farm.ended.get();
    CHECK(contains(text, fault == "unconfigured" ? "before 'configure'" : fault == "layout" ? "layout" : "a request of run"));
}

TEST_CASE("Messages out of turn are named by both ends", "[exchange][lockstep]") {
    const std::string kind = GENERATE(from_range(transports()));
    Pair pair = connected_pair(kind, 4096);
    Frame frame;
    frame.type = FrameType::done;
    SECTION("to the farm") {
        SummingFarm service;
        pair.driver->send(frame);
        CHECK(contains(error_text([&] { FarmEnd(*pair.farm, service, "f").serve(); }), "'done' where 'hello' is due"));
    }
    SECTION("to the driver") {
        pair.farm->send(frame);
        CHECK(contains(error_text([&] { DriverEnd(*pair.driver).connect(driver_hello()); }), "'done' where 'hello' is due"));
    }
}
