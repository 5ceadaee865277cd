#pragma once
// What lies in a shared segment: a preamble that no version may change (so that two versions can tell each other apart),
// one block per side, written by that side alone, and two rings of bytes, each with one writer and one reader. Nothing in
// here locks: counters that only grow, and one futex word per side that its partner rings.
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "exchange/process_identity.hpp"

namespace talik::exchange::shm {

constexpr std::uint64_t magic = 0x314d48534b4c4154u; // "TALKSHM1" in memory order

using Counter = std::atomic<std::uint64_t>;
using Word = std::atomic<std::uint32_t>;
static_assert(Counter::is_always_lock_free && Word::is_always_lock_free, "atomics of the segment must work between processes");

// The same in every version.
struct Preamble {
    Counter magic;               // written last by the creator: before that the segment is being built
    std::uint32_t version;       // of the protocol
    std::uint32_t header_bytes;  // sizeof(Segment)
    std::uint64_t segment_bytes; // all of it
    ProcessIdentity creator;
    Word refused;                // 1: a partner of another version turned away; `refusal` says why
    char refusal[188];
};
static_assert(sizeof(Preamble) == 240);

enum class Presence : std::uint32_t { absent, attaching, attached, left };

struct alignas(64) Side {
    std::atomic<Presence> presence;
    Word wishes_to_end;
    ProcessIdentity process; // valid once attached
    Word cause_state;        // 0 none, 1 being written, 2 written
    char cause[700];
    alignas(64) Counter beats; // calls of advance_progress
    Counter done, total;
    alignas(64) Word doorbell; // changes when the partner wakes this side
    Word sleeping;             // 1 while this side sleeps, or is about to
};

// Bytes from the start of the run; the difference is what lies in the ring.
struct Ring {
    alignas(64) Counter written; // by the writer
    alignas(64) Counter taken;   // by the reader
};

struct Segment {
    Preamble preamble;
    std::uint64_t ring_bytes; // of each ring
    Side side[2];             // by role
    Ring ring[2];             // [role]: written by that role
};

constexpr std::size_t data_offset = (sizeof(Segment) + 4095) / 4096 * 4096;
constexpr std::size_t segment_bytes(std::size_t ring_bytes) { return data_offset + 2 * ring_bytes; }

// The bytes of the segment's file that each side locks while it lives (role), and whoever removes the file.
constexpr int removal_byte = 2;

} // namespace talik::exchange::shm
