#pragma once
// A chunk of RVEs with their columns, as structure of arrays: header, ids, then one array of `count` doubles for each
// component of each column. A Batch is the payload of its frame: it is sent from where it was filled and read where it
// arrived. Sized once; nothing allocates in a step.
#include <cstdint>
#include <span>

#include "exchange/columns.hpp"
#include "exchange/frame.hpp"

namespace talik::exchange {

struct BatchHeader {
    std::uint64_t run_id = 0;      // of the run: answers of another run are not answers
    std::uint64_t epoch = 0;       // counts the restarts of the run
    std::uint64_t step = 0;        // macro step, counted from 1
    double time_increment = 0.0;   // of the macro step, s
    std::uint32_t chunk = 0, chunk_count = 1;
    std::uint32_t substeps = 0;    // DEM steps of the macro step; 0 = the farm decides
    std::uint32_t count = 0;       // RVEs in this chunk
};
static_assert(sizeof(BatchHeader) == 48);

class Batch {
public:
    Batch() = default;
    Batch(const ColumnTable& columns, int capacity);

    // Starts anew: header.count rows, whose content is to be filled in.
    void start(const BatchHeader& header);

    const BatchHeader& header() const { return header_; }
    const ColumnTable& columns() const { return columns_; }
    int count() const { return static_cast<int>(header_.count); }
    int capacity() const { return capacity_; }

    std::span<std::uint32_t> ids();
    std::span<const std::uint32_t> ids() const;
    // One component of one column, `count` values; column: its index in columns().
    std::span<double> component(int column, int component);
    std::span<const double> component(int column, int component) const;
    // Component by its number among all components of all columns.
    std::span<double> component(int flat);
    std::span<const double> component(int flat) const;

    // Everything behind the header, ids and columns, as bytes: for keeping a request and asking it again.
    std::span<const std::byte> rows() const;
    void set_rows(std::span<const std::byte> rows); // of a batch of the same columns and count

    // As a frame to send.
    const Frame& frame(FrameType type, std::uint64_t layout_hash);
    // Takes over the payload of a received frame (by swapping memory), after checking it against the columns.
    void adopt(Frame& received);

private:
    std::size_t offset_of(int flat) const;
    ColumnTable columns_;
    int capacity_ = 0;
    BatchHeader header_;
    Frame frame_;
};

} // namespace talik::exchange
