#pragma once
// The working copy of one RVE during a chunk, in slot order (slot_layout.hpp): columns for what a slot does with its own numbers,
// rows of four for what others fetch, in one load. `Level` keeps code compiled for different machines apart.
#include <cstddef>
#include <cstdint>

#include "rve-farm/kernel/kernel.hpp"

namespace talik::farm {

// Contacts lie in blocks, one number of as many contacts as the kernel has lanes side by side, then the next number: a block
// is walked with one pointer. The order of the numbers (see ContactStart, ContactMemory); the last two only where present.
struct ContactField {
    enum : int { normal_x, normal_y, inverse_length, overlap, tangential_start, turn, elongation, tangential_change, always };
    static constexpr int bonded = always;                                         // with bonds
    static constexpr int tangential(bool bonds) { return always + (bonds ? 1 : 0); } // f_t of the last sub-step; with the ledger
    static constexpr int count(bool bonds, bool ledger) { return tangential(bonds) + (ledger ? 1 : 0); }
};

template <class Real, class Level>
struct Work {
    int disc_slots = 0, contact_slots = 0;
    bool bonds = false, ledger = false;
    // discs
    Real* displacement; // rows {w_x, w_y, theta, r}: since the start of the chunk; w non-affine, m; theta relative to the frame, rad
    // columns of disc slots, one behind the other
    Real* moved;        // w_x, w_y, theta once more, and r: only for lanes
    Real* velocity;     // v_x, v_y, spin: m/s, m/s, 1/s
    Real* inverse_mass; // 1/m, 2/(m r^2): 1/kg, 1/(kg m^2)
    Real* mass;         // kg; only with the fluctuation effect
    Real* force;        // of the contacts that the disc owns, x, y, torque: N, N, N m; only for lanes
    double* stored;     // rows {x, y, radius, mass} as the state has them: m, kg; only for lanes
    // contacts
    Real* blocks;        // of contact fields
    Real* contact_force; // rows, and a last one of zeros: {f_x, f_y, torque on the partner, torque on the owner}; only the plain kernel needs the last number
    Real* motion;        // ContactMotion of the contacts of some groups, in blocks: only for lanes
    double* booked;      // ledger of the plain kernel: columns of contact slots or disc slots

    static constexpr int booked_columns = 5, motions = 7;
    static constexpr int groups_at_once = 8; // by lanes: few enough for their motion to stay near, enough to overlap

    // The fields of a contact slot: field f is at [f * lanes].
    TALIK_HOST_DEVICE Real* contact(int slot) const { return blocks + (slot >> shift_) * block_size_ + (slot & ((1 << shift_) - 1)); }
    TALIK_HOST_DEVICE int lanes() const { return 1 << shift_; }

    // Columns one after the other, each on a cache line of its own.
    Work(WorkMemory& memory, const SlotLayout& layout, const ColumnChoice& columns, bool with_ledger, bool plain)
        : disc_slots(layout.disc_slots()), contact_slots(layout.contact_slots()), bonds(columns.bond), ledger(with_ledger) {
        while ((1 << shift_) < layout.shape.lanes) ++shift_;
        block_size_ = ContactField::count(bonds, ledger) << shift_;
        for (int g = 0; g < layout.groups; g += groups_at_once) {
            const auto first = static_cast<std::size_t>(g), last = static_cast<std::size_t>(g + groups_at_once < layout.groups ? g + groups_at_once : layout.groups);
            const int slots = layout.group_begin[last] - layout.group_begin[first];
            most_slots_at_once_ = slots > most_slots_at_once_ ? slots : most_slots_at_once_;
        }
        lay_out(columns, plain); // how much
        begin_ = memory.take(used_);
        used_ = 0;
        lay_out(columns, plain);
    }

private:
    void lay_out(const ColumnChoice& columns, bool plain) {
        place(displacement, 4 * disc_slots, true);
        place(moved, 4 * disc_slots, !plain);
        place(velocity, 3 * disc_slots, true);
        place(inverse_mass, 2 * disc_slots, true);
        place(mass, disc_slots, columns.fluctuation);
        place(force, 3 * disc_slots, !plain);
        place(stored, 4 * disc_slots, !plain);
        place(blocks, (contact_slots >> shift_) * block_size_, true);
        place(contact_force, 4 * contact_slots + 4, true);
        place(motion, motions * most_slots_at_once_, !plain);
        place(booked, booked_columns * (contact_slots > disc_slots ? contact_slots : disc_slots), ledger && plain);
    }
    template <class Entry>
    void place(Entry*& column, int entries, bool present) {
        column = present && begin_ ? reinterpret_cast<Entry*>(begin_ + used_) : nullptr;
        if (present) used_ += (static_cast<std::size_t>(entries) * sizeof(Entry) + 63) / 64 * 64;
    }

    std::byte* begin_ = nullptr;
    std::size_t used_ = 0;
    int shift_ = 0, block_size_ = 0; // lanes = 2^shift
    int most_slots_at_once_ = 0;
};

} // namespace talik::farm
