#include "exchange/batch.hpp"

#include <algorithm>
#include <cstring>
#include <fmt/format.h>

#include "common/base/error.hpp"

namespace talik::exchange {
namespace {

std::size_t ids_bytes(std::uint32_t count) { return (std::size_t(count) * sizeof(std::uint32_t) + 7) / 8 * 8; }

std::size_t batch_bytes(const ColumnTable& columns, std::uint32_t count) {
    return sizeof(BatchHeader) + ids_bytes(count) + static_cast<std::size_t>(columns.components()) * count * sizeof(double);
}

} // namespace

Batch::Batch(const ColumnTable& columns, int capacity) : columns_(columns), capacity_(capacity) {
    ensure(capacity >= 0);
    frame_.payload.reserve(batch_bytes(columns_, static_cast<std::uint32_t>(capacity)));
    start({});
}

void Batch::start(const BatchHeader& header) {
    ensure(header.count <= static_cast<std::uint32_t>(capacity_));
    header_ = header;
    frame_.payload.resize(batch_bytes(columns_, header.count));
    std::memcpy(frame_.payload.data(), &header_, sizeof header_);
    if (header.count % 2 == 1) // the padding behind an odd number of ids: equal batches are equal bytes
        std::memset(frame_.payload.data() + sizeof header_ + header.count * sizeof(std::uint32_t), 0, sizeof(std::uint32_t));
}

std::size_t Batch::offset_of(int flat) const {
    return sizeof(BatchHeader) + ids_bytes(header_.count) + static_cast<std::size_t>(flat) * header_.count * sizeof(double);
}

// The payload's memory comes from operator new (aligned to 16), and every offset is a multiple of 8.
std::span<std::uint32_t> Batch::ids() {
    return {reinterpret_cast<std::uint32_t*>(frame_.payload.data() + sizeof(BatchHeader)), header_.count};
}
std::span<const std::uint32_t> Batch::ids() const {
    return {reinterpret_cast<const std::uint32_t*>(frame_.payload.data() + sizeof(BatchHeader)), header_.count};
}
std::span<double> Batch::component(int flat) {
    return {reinterpret_cast<double*>(frame_.payload.data() + offset_of(flat)), header_.count};
}
std::span<const double> Batch::component(int flat) const {
    return {reinterpret_cast<const double*>(frame_.payload.data() + offset_of(flat)), header_.count};
}
std::span<double> Batch::component(int column, int component_of_column) {
    return component(columns_.first_component(column) + component_of_column);
}
std::span<const double> Batch::component(int column, int component_of_column) const {
    return component(columns_.first_component(column) + component_of_column);
}

std::span<const std::byte> Batch::rows() const { return std::span(frame_.payload).subspan(sizeof(BatchHeader)); }

void Batch::set_rows(std::span<const std::byte> rows) {
    ensure(rows.size() == frame_.payload.size() - sizeof(BatchHeader));
    std::copy(rows.begin(), rows.end(), frame_.payload.begin() + sizeof(BatchHeader));
}

const Frame& Batch::frame(FrameType type, std::uint64_t layout_hash) {
    frame_.type = type;
    frame_.layout_hash = layout_hash;
    frame_.step = header_.step;
    return frame_;
}

void Batch::adopt(Frame& received) {
    const std::size_t size = received.payload.size();
    BatchHeader header;
    if (size >= sizeof header) std::memcpy(&header, received.payload.data(), sizeof header);
    const bool fits = size >= sizeof header && header.count <= static_cast<std::uint32_t>(capacity_) &&
                      size == batch_bytes(columns_, header.count) && header.step == received.step;
    if (!fits)
        fail(ExitCode::partner_lost,
             fmt::format("malformed message: the {} of step {} ({} bytes) does not have the agreed layout",
                         name_of(received.type), received.step, size),
             "both programs must come from the same version of Talik");
    std::swap(frame_.payload, received.payload);
    header_ = header;
}

} // namespace talik::exchange
