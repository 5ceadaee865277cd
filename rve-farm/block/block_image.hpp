#pragma once
// An RVE as it lies in the memory of a device: the arena of its assembly as it is, then its slots. Room for the longest list, so that
// a new list never asks for memory.
#include <cstddef>
#include <span>

#include "rve-farm/assembly/answer.hpp"
#include "rve-farm/assembly/assembly.hpp"
#include "rve-farm/block/block_task.hpp"

namespace talik::farm {

LaneShape block_shape(); // of the slot layouts of blocks

class BlockImage {
public:
    // Refuses (bad_input) an RVE with more discs or contacts than short numbers can count.
    explicit BlockImage(const Assembly& rve);

    std::size_t bytes() const { return bytes_; }
    // The most that a list can take.
    const BlockSize& largest() const { return largest_; }
    // What the layout of the present list takes; contact_list_full where there is no room for it.
    Status size_of(const SlotLayout& layout, BlockSize& size) const;

    // Writes the image as it will lie at `device`, and how to find one's way in it.
    BlockRve write(Assembly& rve, const BlockSize& size, std::byte* image, const std::byte* device) const;
    // What a chunk may have changed, from the beginning of the image on.
    std::size_t state_bytes(const Assembly& rve) const;
    void read_state(Assembly& rve, const std::byte* image) const;

private:
    template <class Entry>
    std::size_t place(std::size_t entries);

    std::size_t bytes_ = 0, arena_ = 0;
    std::size_t disc_, group_begin_, contact_, turned_, partner_, incoming_, incoming_begin_; // where they begin
    BlockSize largest_;
};

} // namespace talik::farm
