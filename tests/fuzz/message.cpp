// Random bytes as messages: to the farm's end, to the driver's, and to every decoder of a payload. Whatever comes, the outcome is
// an Error or an answer; sanitizers watch the rest. The first byte of an input says who receives it; the rest is a series of frames
// (type, length, payload), sealed as a partner would, or raw bytes where that byte says so.
#include <algorithm>
#include <cstdint>
#include <cstring>

#include "common/base/error.hpp"
#include "common/io/byte_stream.hpp"
#include "common/packing/farm_setup.hpp"
#include "common/physics/rve_columns.hpp"
#include "exchange/answer_memory.hpp"
#include "exchange/driver_end.hpp"
#include "exchange/farm_end.hpp"

namespace {

using namespace talik;
using namespace talik::exchange;

// Delivers prepared bytes, and swallows what is sent.
class Tape final : public Channel {
public:
    Tape(Role role, std::vector<std::byte> bytes) : Channel(role, {}), bytes_(std::move(bytes)) {}
    void advance_progress(std::uint64_t, std::uint64_t) noexcept override {}
    PartnerProgress partner_progress() const override { return {}; }
    void state_cause(const std::string&) noexcept override {}
    std::string partner_cause() const override { return {}; }
    void wish_to_end() noexcept override {}
    bool partner_wishes_to_end() const noexcept override { return false; }

protected:
    void nap(const Ready&, std::chrono::milliseconds) override { fail(ExitCode::partner_lost, "the tape ends", "none"); } // nothing more will come
    PartnerView look() override { return {}; }
    std::size_t room() const override { return std::size_t(1) << 30; }
    std::size_t available() const override { return bytes_.size() - at_; }
    void write(std::span<const std::byte>) override {}
    void flush() override {}
    void read(std::span<std::byte> out) override {
        if (out.size() > available()) fail(ExitCode::partner_lost, "the tape ends", "none");
        if (!out.empty()) std::memcpy(out.data(), bytes_.data() + at_, out.size());
        at_ += out.size();
    }

private:
    std::vector<std::byte> bytes_;
    std::size_t at_ = 0;
};

std::vector<Column> answer_columns() { return {rve_columns::stress, rve_columns::status}; }

Hello driver_hello() {
    Hello hello;
    hello.program = "driver";
    hello.run_id = 7;
    hello.request_columns = {rve_columns::displacement_gradient_increment};
    hello.answer_columns = answer_columns();
    return hello;
}

// Decodes all that a farm decodes, and remembers its answers.
class Farm : public FarmService {
public:
    std::vector<Column> understands() const override { return rve_columns::requests(); }
    std::vector<Column> offers() const override { return rve_columns::answers(); }
    void agreed(const Hello& driver) override { columns_ = ColumnTable(driver.answer_columns); }
    std::vector<std::byte> configure(std::span<const std::byte> payload, Channel&) override {
        const FarmSetup setup = decode_farm_setup(payload);
        memory_ = AnswerMemory(static_cast<int>(setup.packing_of_rve.size()), columns_);
        return encode(setup);
    }
    void answer(const Batch& request, Batch& answer, Channel&) override {
        memory_.recall(request, answer, rows_);
        for (const int row : rows_)
            for (int c = 0; c < answer.columns().components(); ++c) answer.component(c)[static_cast<std::size_t>(row)] = request.component(0)[static_cast<std::size_t>(row)];
        memory_.remember(request, answer, rows_);
    }
    std::vector<std::byte> command(const std::string&, std::span<const std::byte> payload) override {
        ByteReader in(payload, "ids");
        const auto ids = in.array<std::uint32_t>();
        in.finish();
        return {};
    }
    void checkpoint(const std::string&) override {}
    void restore(const std::string&) override {}

private:
    ColumnTable columns_;
    AnswerMemory memory_;
    std::vector<int> rows_;
};

void put(std::vector<std::byte>& out, const void* data, std::size_t size) {
    const auto* first = static_cast<const std::byte*>(data);
    out.insert(out.end(), first, first + size);
}

// type (1 byte), length (2 bytes), payload, and again; headers as a partner seals them, for the columns of driver_hello().
std::vector<std::byte> sealed_frames(std::span<const std::byte> in, bool checksums) {
    const std::uint64_t layout = layout_hash(ColumnTable(driver_hello().request_columns), ColumnTable(answer_columns()));
    std::vector<std::byte> out;
    while (in.size() >= 3) {
        Frame frame;
        frame.type = static_cast<FrameType>(std::to_integer<int>(in[0]) % 16);
        std::uint16_t length = 0;
        std::memcpy(&length, in.data() + 1, 2);
        in = in.subspan(3);
        const std::size_t size = std::min<std::size_t>(length, in.size());
        frame.payload.assign(in.begin(), in.begin() + static_cast<std::ptrdiff_t>(size));
        in = in.subspan(size);
        frame.layout_hash = layout;
        if (size >= sizeof(BatchHeader)) std::memcpy(&frame.step, frame.payload.data() + offsetof(BatchHeader, step), 8);
        const FrameHeader header = seal(frame, checksums);
        put(out, &header, sizeof header);
        put(out, frame.payload.data(), frame.payload.size());
    }
    return out;
}

void as_farm(std::vector<std::byte> bytes) {
    Tape tape(Role::farm, std::move(bytes));
    Farm farm;
    FarmEnd(tape, farm, "farm").serve();
}

void as_driver(std::vector<std::byte> bytes) {
    Tape tape(Role::driver, std::move(bytes));
    DriverEnd driver(tape, 4);
    driver.connect(driver_hello());
    driver.configure({});
    Batch request = driver.make_request(6), answer = driver.make_answer(6);
    for (std::uint64_t step = 1; step < 4; ++step) {
        BatchHeader header;
        header.count = 6;
        request.start(header);
        for (std::uint32_t i = 0; i < 6; ++i) request.ids()[i] = i;
        for (int c = 0; c < 4; ++c) std::fill(request.component(c).begin(), request.component(c).end(), 0.0);
        driver.step({step, 1e-3, 0}, request, answer);
    }
    driver.command("x");
    driver.bye();
}

void decode(int what, std::span<const std::byte> bytes) {
    if (what == 0) {
        const Hello hello = decode_hello(bytes);
        check_agreement(hello, hello);
        (void)layout_hash(ColumnTable(hello.request_columns), ColumnTable(hello.answer_columns));
    } else if (what == 1) {
        (void)encode(decode_farm_setup(bytes));
    } else if (what == 2) {
        rethrow_error(bytes, Role::farm);
    } else {
        ByteReader in(bytes, "memory");
        AnswerMemory(4, ColumnTable(answer_columns())).load(in);
    }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    const auto bytes = std::as_bytes(std::span(data + 1, size - 1));
    const int choice = data[0] & 15;
    try {
        if (choice < 4) as_farm(sealed_frames(bytes, choice & 1));
        else if (choice < 8) as_driver(sealed_frames(bytes, choice & 1));
        else if (choice == 8) as_farm({bytes.begin(), bytes.end()});
        else if (choice == 9) as_driver({bytes.begin(), bytes.end()});
        else decode(choice & 3, bytes);
    } catch (const Error& error) {
        if (error.problem().empty() || error.remedy().empty()) {
            // What a partner reports may be empty; what this side says may not.
            if (error.problem().find("reports") == std::string::npos) __builtin_trap();
        }
    }
    return 0;
}
