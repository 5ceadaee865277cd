#include "rve-farm/block/block_image.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "common/base/error.hpp"

namespace talik::farm {
namespace {

// Discs are sorted by what they own, so padding is at most what the disc that owns most has, twice, in one group (slot_layout.hpp).
constexpr int most_owned_foreseen = 16;
constexpr std::size_t short_numbers = std::numeric_limits<std::uint16_t>::max();

template <class To, class From, class Change>
void write_column(std::byte* image, std::size_t begin, std::span<const From> column, Change&& change) {
    To* to = reinterpret_cast<To*>(image + begin);
    for (std::size_t k = 0; k < column.size(); ++k) to[k] = static_cast<To>(change(column[k]));
}

} // namespace

LaneShape block_shape() {
    LaneShape shape;
    shape.lanes = block_group;
    shape.lanes_of_a_vector = 1;
    for (int lane = 0; lane < block_group; ++lane) shape.row_of_lane[lane] = static_cast<std::int8_t>(lane);
    return shape;
}

template <class Entry>
std::size_t BlockImage::place(std::size_t entries) {
    const std::size_t begin = bytes_;
    bytes_ += (entries * sizeof(Entry) + 63) / 64 * 64;
    return begin;
}

BlockImage::BlockImage(const Assembly& rve) {
    const AssemblyNumbers& n = rve.numbers();
    const auto discs = static_cast<std::size_t>(n.disc_count), contacts = static_cast<std::size_t>(n.contact_capacity);
    const std::size_t groups = (discs + block_group - 1) / block_group, slots = contacts + 2 * most_owned_foreseen * block_group;
    require(slots < short_numbers, fmt::format("an RVE of {} discs is too large for the CUDA backend", discs), "use --backend cpu, or RVEs of at most 10,000 discs");
    largest_ = {static_cast<std::int32_t>(groups), static_cast<std::int32_t>(slots), static_cast<std::int32_t>(contacts)};
    arena_ = rve.arena().size();
    place<std::byte>(arena_);
    disc_ = place<std::int32_t>(groups * block_group);
    group_begin_ = place<std::int32_t>(groups + 1);
    contact_ = place<std::int32_t>(slots);
    turned_ = place<std::int8_t>(slots);
    partner_ = place<std::uint16_t>(slots);
    incoming_ = place<std::uint16_t>(contacts);
    incoming_begin_ = place<std::uint16_t>(groups * block_group + 1);
}

Status BlockImage::size_of(const SlotLayout& layout, BlockSize& size) const {
    if (layout.contact_slots() > largest_.contact_slots || layout.incoming.size() > static_cast<std::size_t>(largest_.incoming)) return Status::contact_list_full;
    size = {layout.groups, layout.contact_slots(), static_cast<std::int32_t>(layout.incoming.size())};
    return Status::ok;
}

BlockRve BlockImage::write(Assembly& rve, const BlockSize& size, std::byte* image, const std::byte* device) const {
    const SlotLayout& layout = rve.layout();
    ensure(layout.shape == block_shape());
    const std::span<const std::byte> arena = std::as_const(rve).arena();
    std::memcpy(image, arena.data(), arena.size());
    const auto same = [](auto value) { return value; };
    const auto from_row = [](std::int32_t row) { return row / 4; };
    const auto all = [](const auto& column) { return std::span(column); };
    write_column<std::int32_t>(image, disc_, all(layout.disc), same);
    write_column<std::int32_t>(image, group_begin_, all(layout.group_begin), same);
    write_column<std::int32_t>(image, contact_, all(layout.contact), same);
    write_column<std::int8_t>(image, turned_, all(layout.turned), same);
    write_column<std::uint16_t>(image, partner_, all(layout.partner), from_row);
    write_column<std::uint16_t>(image, incoming_, all(layout.incoming), from_row);
    write_column<std::uint16_t>(image, incoming_begin_, all(layout.incoming_begin), same);

    BlockRve there{};
    there.view = rve.view();
    there.view.numbers = nullptr;
    for_each_column(there.view, rve.columns(), [&](const char*, const char*, Extent, auto*& column, bool present) {
        using Entry = std::remove_reference_t<decltype(*column)>;
        const std::byte* begin = reinterpret_cast<const std::byte*>(column);
        column = present ? reinterpret_cast<Entry*>(const_cast<std::byte*>(device) + (begin - arena.data())) : nullptr;
    });
    there.size = size;
    there.disc = reinterpret_cast<const std::int32_t*>(device + disc_);
    there.group_begin = reinterpret_cast<const std::int32_t*>(device + group_begin_);
    there.contact = reinterpret_cast<const std::int32_t*>(device + contact_);
    there.turned = reinterpret_cast<const std::int8_t*>(device + turned_);
    there.partner = reinterpret_cast<const std::uint16_t*>(device + partner_);
    there.incoming = reinterpret_cast<const std::uint16_t*>(device + incoming_);
    there.incoming_begin = reinterpret_cast<const std::uint16_t*>(device + incoming_begin_);
    return there;
}

std::size_t BlockImage::state_bytes(const Assembly& rve) const {
    const AssemblyView& s = rve.view();
    const auto end_of = [&](const auto* column) { return static_cast<std::size_t>(reinterpret_cast<const std::byte*>(column + s.contact_count()) - rve.arena().data()); };
    return std::max(end_of(s.tangential_force), s.bonded ? end_of(s.bonded) : 0);
}

void BlockImage::read_state(Assembly& rve, const std::byte* image) const { std::memcpy(rve.arena().data(), image, state_bytes(rve)); }

} // namespace talik::farm
