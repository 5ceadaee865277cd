#include "exchange/frame.hpp"

#include <bit>
#include <fmt/format.h>

#include "common/base/error.hpp"
#include "exchange/checksum.hpp"

namespace talik::exchange {
namespace {

constexpr std::uint64_t magic = 0x314d52464b4c4154u;         // "TALKFRM1" in memory order
constexpr std::uint64_t magic_of_other_endian = 0x54414c4b46524d31u;
constexpr std::uint32_t has_checksum = 1;
constexpr std::uint64_t most_bytes = std::uint64_t(64) << 30; // no message of ours comes near

[[noreturn]] void nonsense(const std::string& problem) {
    fail(ExitCode::partner_lost, "the partner sends nonsense: " + problem,
         "check that both programs are of the same build, then restart from the last checkpoint");
}

std::uint64_t checksum_of(const FrameHeader& header) {
    return checksum(std::as_bytes(std::span(&header, 1)).first(offsetof(FrameHeader, header_checksum)));
}

} // namespace

const char* name_of(FrameType type) {
    switch (type) {
    case FrameType::hello: return "hello";
    case FrameType::configure: return "configure";
    case FrameType::ready: return "ready";
    case FrameType::step_request: return "step request";
    case FrameType::step_answer: return "step answer";
    case FrameType::command: return "command";
    case FrameType::checkpoint: return "checkpoint";
    case FrameType::restore: return "restore";
    case FrameType::done: return "done";
    case FrameType::error: return "error";
    case FrameType::bye: return "bye";
    }
    return "unknown";
}

FrameHeader seal(const Frame& frame, bool with_checksum) {
    FrameHeader header;
    header.magic = magic;
    header.version = protocol_version;
    header.type = static_cast<std::uint16_t>(frame.type);
    header.layout_hash = frame.layout_hash;
    header.step = frame.step;
    header.payload_bytes = frame.payload.size();
    if (with_checksum) {
        header.flags = has_checksum;
        header.payload_checksum = checksum(frame.payload);
    }
    header.header_checksum = checksum_of(header);
    return header;
}

void check_header(const FrameHeader& header) {
    if (header.magic == magic_of_other_endian) nonsense("its byte order is not that of this machine");
    if (header.magic != magic) nonsense("a frame without Talik's mark");
    if (header.version != protocol_version)
        fail(ExitCode::partner_lost,
             fmt::format("the partner speaks version {} of the exchange, this program version {}", header.version,
                         protocol_version),
             "use driver and farm of the same version of Talik");
    if (header.header_checksum != checksum_of(header)) nonsense("the header of a frame is corrupted");
    if (std::string_view(name_of(static_cast<FrameType>(header.type))) == "unknown")
        nonsense(fmt::format("a frame of the unknown type {}", header.type));
    if (header.payload_bytes > most_bytes) nonsense(fmt::format("a frame of {} bytes", header.payload_bytes));
}

void check_payload(const FrameHeader& header, const Frame& received) {
    if ((header.flags & has_checksum) && checksum(received.payload) != header.payload_checksum)
        nonsense(fmt::format("the {} of step {} is corrupted (its checksum is wrong)", name_of(received.type), received.step));
}

} // namespace talik::exchange
