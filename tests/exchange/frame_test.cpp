#include "exchange/frame.hpp"
#include "exchange/batch.hpp"
#include "exchange/checksum.hpp"
#include "tests/exchange/support.hpp"
#include "tests/support/catch.hpp"

using namespace talik;
using namespace talik::exchange;
using namespace talik::exchange::test;

namespace {

Frame some_frame(std::size_t size) {
    Frame frame;
    frame.type = FrameType::step_request;
    frame.step = 12;
    for (std::size_t i = 0; i < size; ++i) frame.payload.push_back(static_cast<std::byte>(i * 37 % 251));
    return frame;
}
} // namespace

TEST_CASE("The checksum notices every single flipped bit, and the length", "[exchange][frame]") {
    for (std::size_t size : {1, 7, 8, 31, 32, 33, 127, 400}) {
        std::vector<std::byte> bytes = some_frame(size).payload;
        const std::uint64_t right = checksum(bytes);
        for (std::size_t bit = 0; bit < 8 * size; ++bit) {
            bytes[bit / 8] ^= std::byte(1 << (bit % 8));
            REQUIRE(checksum(bytes) != right);
            bytes[bit / 8] ^= std::byte(1 << (bit % 8));
        }
        bytes.push_back(std::byte{0});
        CHECK(checksum(bytes) != right);
    }
}

TEST_CASE("A corrupted payload is noticed by its checksum", "[exchange][frame]") {
    Frame frame = some_frame(1000);
    const FrameHeader header = seal(frame, true);
    CHECK_NOTHROW(check_payload(header, frame));
    frame.payload[500] ^= std::byte{4};
    ExitCode code = ExitCode::done;
    const std::string text = error_text([&] { check_payload(header, frame); }, &code);
    CHECK(code == ExitCode::partner_lost);
    CHECK(contains(text, "step request of step 12 is corrupted"));
}

TEST_CASE("Every corrupted byte of a header is noticed, with or without checksums of payloads", "[exchange][frame]") {
    const FrameHeader right = seal(some_frame(10), false);
    CHECK_NOTHROW(check_header(right));
    for (std::size_t i = 0; i < sizeof right; ++i) {
        FrameHeader wrong = right;
        reinterpret_cast<unsigned char*>(&wrong)[i] ^= 0x10;
        CHECK_THROWS_AS(check_header(wrong), Error);
    }
}

TEST_CASE("A frame of another protocol version is refused by both version numbers", "[exchange][frame]") {
    FrameHeader header = seal(some_frame(10), false);
    header.version = protocol_version + 1;
    const std::string text = error_text([&] { check_header(header); });
    CHECK(contains(text, fmt::format("version {} of the exchange, this program version {}", protocol_version + 1, protocol_version)));
}

TEST_CASE("A batch holds each component as one array, behind its ids", "[exchange][batch]") {
    const ColumnTable columns({rve_columns::stress, rve_columns::status});
    Batch batch(columns, 5);
    for (std::uint32_t count : {0u, 1u, 4u, 5u}) { // odd counts have padding behind the ids
        BatchHeader header;
        header.step = 9;
        header.count = count;
        batch.start(header);
        CHECK(batch.ids().size() == count);
        for (std::uint32_t i = 0; i < count; ++i) {
            batch.ids()[i] = 100 + i;
            for (int c = 0; c < 4; ++c) batch.component(c)[i] = 10.0 * c + i;
        }
        Frame frame = batch.frame(FrameType::step_answer, 0);
        Batch other(columns, 5);
        other.adopt(frame);
        CHECK(other.header().step == 9);
        for (std::uint32_t i = 0; i < count; ++i) {
            CHECK(other.ids()[i] == 100 + i);
            CHECK(other.component(0, 2)[i] == 20.0 + i);
            CHECK(other.component(1, 0)[i] == 30.0 + i);
        }
    }
}

TEST_CASE("Filling and sending a batch moves none of its memory", "[exchange][batch]") {
    Batch batch(ColumnTable({rve_columns::stress}), 100);
    const void* memory = batch.frame(FrameType::step_request, 0).payload.data();
    for (std::uint32_t count : {100u, 3u, 0u, 57u, 100u}) {
        BatchHeader header;
        header.count = count;
        batch.start(header);
        CHECK(batch.frame(FrameType::step_request, 0).payload.data() == memory);
    }
}

TEST_CASE("A batch that is not laid out as agreed is an error, never a crash", "[exchange][batch]") {
    Batch batch(ColumnTable({rve_columns::stress}), 5);
    BatchHeader header;
    header.count = 4;
    batch.start(header);
    const Frame right = batch.frame(FrameType::step_request, 0);
    const auto adopt = [&](Frame frame, int capacity, const Column& column) {
        Batch other(ColumnTable({column}), capacity);
        other.adopt(frame);
    };
    CHECK_NOTHROW(adopt(right, 5, rve_columns::stress));
    CHECK_THROWS_AS(adopt(right, 3, rve_columns::stress), Error); // more RVEs than expected
    CHECK_THROWS_AS(adopt(right, 5, rve_columns::status), Error); // other columns
    Frame wrong_step = right;
    wrong_step.step = 77;
    CHECK_THROWS_AS(adopt(wrong_step, 5, rve_columns::stress), Error);
    for (std::size_t size = 0; size < right.payload.size(); size += 7) {
        Frame cut = right;
        cut.payload.resize(size);
        CHECK_THROWS_AS(adopt(cut, 5, rve_columns::stress), Error);
    }
}
