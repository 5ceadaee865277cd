#pragma once
// One RVE: its arena, made from a packing and turned back into one, saved and loaded.
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "common/packing/packing.hpp"
#include "common/physics/rve_parameters.hpp"
#include "rve-farm/assembly/columns.hpp"
#include "rve-farm/assembly/slot_layout.hpp"
#include "rve-farm/physics/contact.hpp"

namespace talik::farm {

// Refuses (bad_input) a packing that is malformed, or was made for discs of another thickness or density.
void check(const Packing& packing, const RveParameters& parameters);

class Assembly {
public:
    // Tangential forces and bonds of the packing's contacts are honoured; forces are those of the positions.
    Assembly(const RveParameters& parameters, const Packing& packing);
    Assembly(const Assembly& other); // another RVE in the same state
    Assembly(Assembly&&) noexcept = default;
    Assembly& operator=(Assembly&&) noexcept = default;

    AssemblyView& view() { return view_; }
    const AssemblyView& view() const { return view_; }
    const AssemblyNumbers& numbers() const { return *numbers_; }
    const ColumnChoice& columns() const { return columns_; }
    SlotLayout& layout() { return layout_; } // of the kernel that last took it

    // All columns, as one piece of memory.
    std::span<std::byte> arena() { return {begin_, bytes_}; }
    std::span<const std::byte> arena() const { return {begin_, bytes_}; }

    Packing packing(double grain_density) const;

    void save(std::vector<std::byte>& bytes) const;
    std::size_t load(std::span<const std::byte> bytes); // returns the bytes used

private:
    void allocate(std::int64_t discs, std::int64_t contact_capacity);
    void import_discs(const RveParameters& parameters, const Packing& packing);
    void import_contacts(const Packing& packing);
    void limit_tangential_forces(const ContactLaw<double>& law);

    ColumnChoice columns_;
    std::unique_ptr<std::byte[]> arena_; // sized once; pages beyond the contacts in use are never touched
    std::byte* begin_ = nullptr;         // in it, on a cache line
    std::size_t bytes_ = 0;
    std::unique_ptr<AssemblyNumbers> numbers_;
    AssemblyView view_{};
    SlotLayout layout_;
};

// Entries of a column in use.
inline int entries(const AssemblyNumbers& n, Extent extent) {
    switch (extent) {
    case Extent::discs: return static_cast<int>(n.disc_count);
    case Extent::disc_offsets: return static_cast<int>(n.disc_count) + 1;
    case Extent::contacts: return static_cast<int>(n.contact_count);
    }
    return 0;
}

} // namespace talik::farm
