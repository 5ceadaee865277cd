#pragma once
// The unit of the wire: a header of 64 bytes and a payload. Version, size and header checksum are always checked on
// arrival; the checksum of the payload is a choice of the channel (memory does not flip bits, files and networks do).
#include <cstddef>
#include <cstdint>
#include <vector>

namespace talik::exchange {

constexpr std::uint16_t protocol_version = 1;

enum class FrameType : std::uint16_t {
    hello = 1,   // who I am, which columns
    configure,   // driver -> farm: the RVE table, the packings
    ready,       // farm -> driver: configured
    step_request,
    step_answer,
    command,     // driver -> farm: by name
    checkpoint,  // driver -> farm: path
    restore,     // driver -> farm: path
    done,        // farm -> driver: command, checkpoint or restore is done
    error,       // exit code and text
    bye,
};
const char* name_of(FrameType type); // "unknown" for a number that is none

struct FrameHeader {
    std::uint64_t magic = 0;
    std::uint16_t version = 0;
    std::uint16_t type = 0;
    std::uint32_t flags = 0; // 1: payload_checksum is filled in
    std::uint64_t layout_hash = 0;
    std::uint64_t step = 0;
    std::uint64_t payload_bytes = 0;
    std::uint64_t payload_checksum = 0;
    std::uint64_t reserved = 0;
    std::uint64_t header_checksum = 0; // of the 56 bytes before it
};
static_assert(sizeof(FrameHeader) == 64);

// The payload keeps its memory from frame to frame: receiving into the same Frame allocates nothing in the end.
struct Frame {
    FrameType type = FrameType::hello;
    std::uint64_t layout_hash = 0; // of the negotiated columns; 0 before that
    std::uint64_t step = 0;
    std::vector<std::byte> payload;
};

FrameHeader seal(const Frame& frame, bool with_checksum);
void check_header(const FrameHeader& header);                         // throws Error(partner_lost)
void check_payload(const FrameHeader& header, const Frame& received); // throws Error(partner_lost)

} // namespace talik::exchange
