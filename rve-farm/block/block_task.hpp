#pragma once
// What a block is given and what it leaves: plain data that is copied to and from a device.
#include <cstddef>
#include <cstdint>

#include "rve-farm/assembly/columns.hpp"
#include "rve-farm/kernel/chunk_ends.hpp"
#include "rve-farm/kernel/chunk_request.hpp"

namespace talik::farm {

// Discs form groups of as many as a warp has threads: the contacts of a group then lie side by side for its threads.
constexpr int block_group = 32;

// How much there is of everything; disc slots are whole groups.
struct BlockSize {
    std::int32_t groups = 0, contact_slots = 0, incoming = 0;
    TALIK_HOST_DEVICE int disc_slots() const { return groups * block_group; }
};

// An RVE in the memory of a device: the columns of its assembly, and its slots (slot_layout.hpp) as short numbers.
struct BlockRve {
    AssemblyView view;                          // without numbers: they come with the task
    BlockSize size;
    const std::int32_t *disc, *group_begin, *contact; // as in SlotLayout
    const std::int8_t* turned;
    const std::uint16_t* partner;               // disc slots, by contact slot
    const std::uint16_t *incoming, *incoming_begin; // contact slots; by disc slot
};

struct BlockTask {
    std::int64_t rve = 0; // among those of the device
    ChunkRequest request;
    AssemblyNumbers numbers;     // of the RVE at the start
    std::byte* spread = nullptr; // working memory of the variant that does not fit into shared memory
};

struct BlockResult {
    std::int32_t accepted = 0, finite = 0;
    double largest_displacement = 0; // m
    ChunkMotion cell;
    Stretch stretch, last_stretch;
    ChunkSums sums; // only where accepted
};

} // namespace talik::farm
