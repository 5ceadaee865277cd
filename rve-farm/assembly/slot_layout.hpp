#pragma once
// The order in which a kernel walks one RVE. Every contact has an owner, chosen so that all discs own two or three; discs
// are sorted by what they own and by what comes in, and form groups of as many as the kernel has lanes. Within a group the
// m-th contacts of its discs lie side by side: the owner's side of a contact needs no gather, and padding is under 2 %.
//
// Slots: a disc slot is group * lanes + lane; a contact slot is group_begin[group] + m * lanes + lane. Slots without a
// disc or contact are inert. Depends on the candidate list and its images alone: made anew after a rebuild, never saved.
#include <cstdint>
#include <vector>

#include "rve-farm/assembly/columns.hpp"

namespace talik::farm {

// Of a kernel: how wide its groups are, how many discs its vectors take, and in which order it writes the rows of a group, be
// they of contacts or of discs.
struct LaneShape {
    int lanes = 1, lanes_of_a_vector = 1;
    std::int8_t row_of_lane[64] = {};

    bool operator==(const LaneShape&) const = default;
};

// Neighbouring sets of discs that receive the same number of contacts at most. A set is as many discs as a vector has lanes.
struct IncomingRun {
    std::int32_t first_slot, sets, degree;
};

class SlotLayout {
public:
    // Makes the layout of the present list, unless it is there already.
    void update(const AssemblyView& s, LaneShape shape);
    void forget() { list_ = -1; }

    LaneShape shape;
    int groups = 0;
    int disc_slots() const { return groups * shape.lanes; }
    int contact_slots() const { return groups ? group_begin.back() : 0; }

    std::vector<std::int32_t> disc;          // of each disc slot; -1: none
    std::vector<std::int32_t> slot_of_disc;
    std::vector<std::int32_t> own_rows;      // of each disc slot: 4 * where its row lies
    std::vector<std::int32_t> group_begin;   // contact slots of each group; groups + 1 entries
    std::vector<std::int32_t> contact;       // of each contact slot; -1: none
    std::vector<std::int32_t> owner, partner; // of each contact slot, own_rows of its discs; of an inert one twice its own disc
    std::vector<std::int8_t> turned;         // 1: the owner is the contact's `second`
    std::vector<std::int32_t> image_x, image_y; // of the partner, seen from the owner
    std::vector<std::int32_t> row;           // where the forces of a contact slot are written: 4 * row
    std::vector<std::int32_t> incoming;      // rows of the contacts that come into a disc, 4 * row, by disc slot
    std::vector<std::int32_t> incoming_begin; // of each disc slot, into `incoming`; disc slots + 1
    // The same, set by set: for each set of a run, degree times one row of each of its discs; row 4 * contact_slots() is zero
    // for discs that receive fewer than the others of their set.
    std::vector<IncomingRun> runs;
    std::vector<std::int32_t> incoming_of_sets;

private:
    void choose_owners(const AssemblyView& s);
    void sort_discs(const AssemblyView& s);
    void place_contacts(const AssemblyView& s);
    void list_incoming(const AssemblyView& s);
    void list_runs();

    std::int64_t list_ = -1; // numbers.rebuilds of the list it was made for
    std::vector<std::int32_t> owned_, coming_, next_, count_; // scratch, by disc
    std::vector<std::int8_t> turned_by_contact_;
};

} // namespace talik::farm
