#include "rve-farm/assembly/slot_layout.hpp"

#include <algorithm>

namespace talik::farm {

void SlotLayout::update(const AssemblyView& s, LaneShape wanted) {
    if (list_ == s.numbers->rebuilds && shape == wanted) return;
    shape = wanted;
    groups = (s.disc_count() + shape.lanes - 1) / shape.lanes;
    choose_owners(s);
    sort_discs(s);
    place_contacts(s);
    list_incoming(s);
    list_ = s.numbers->rebuilds;
}

// Each contact goes to the end that owns fewer so far, the first at a draw.
void SlotLayout::choose_owners(const AssemblyView& s) {
    const auto discs = static_cast<std::size_t>(s.disc_count()), contacts = static_cast<std::size_t>(s.contact_count());
    owned_.assign(discs, 0);
    coming_.assign(discs, 0);
    turned_by_contact_.resize(contacts);
    for (std::size_t c = 0; c < contacts; ++c) {
        const auto i = static_cast<std::size_t>(s.first[c]), j = static_cast<std::size_t>(s.second[c]);
        const bool from_second = owned_[j] < owned_[i];
        turned_by_contact_[c] = from_second;
        ++owned_[from_second ? j : i];
        ++coming_[from_second ? i : j];
    }
}

// By what they own, then by what comes in, then by number: a counting sort.
void SlotLayout::sort_discs(const AssemblyView& s) {
    const auto discs = static_cast<std::size_t>(s.disc_count());
    int most_owned = 0, most_coming = 0;
    for (std::size_t i = 0; i < discs; ++i) {
        most_owned = std::max(most_owned, owned_[i]);
        most_coming = std::max(most_coming, coming_[i]);
    }
    const auto key = [&](std::size_t i) { return static_cast<std::size_t>(owned_[i] * (most_coming + 1) + coming_[i]); };
    count_.assign(static_cast<std::size_t>((most_owned + 1) * (most_coming + 1)) + 1, 0);
    for (std::size_t i = 0; i < discs; ++i) ++count_[key(i) + 1];
    for (std::size_t k = 1; k < count_.size(); ++k) count_[k] += count_[k - 1];
    disc.assign(static_cast<std::size_t>(disc_slots()), -1);
    own_rows.resize(disc.size());
    for (int k = 0; k < disc_slots(); ++k) own_rows[static_cast<std::size_t>(k)] = 4 * (k - k % shape.lanes + shape.row_of_lane[k % shape.lanes]);
    slot_of_disc.resize(discs);
    for (std::size_t i = 0; i < discs; ++i) {
        const std::int32_t slot = count_[key(i)]++;
        disc[static_cast<std::size_t>(slot)] = static_cast<std::int32_t>(i);
        slot_of_disc[i] = slot;
    }
}

void SlotLayout::place_contacts(const AssemblyView& s) {
    const int lanes = shape.lanes;
    group_begin.resize(static_cast<std::size_t>(groups) + 1);
    group_begin[0] = 0;
    for (int g = 0; g < groups; ++g) { // sorted: the last disc of a group owns the most
        const int last = std::min((g + 1) * lanes, s.disc_count()) - 1;
        const int most = owned_[static_cast<std::size_t>(disc[static_cast<std::size_t>(last)])];
        group_begin[static_cast<std::size_t>(g) + 1] = group_begin[static_cast<std::size_t>(g)] + most * lanes;
    }
    const auto slots = static_cast<std::size_t>(contact_slots());
    contact.assign(slots, -1);
    turned.assign(slots, 0);
    image_x.assign(slots, 0);
    image_y.assign(slots, 0);
    owner.resize(slots);
    partner.resize(slots);
    row.resize(slots);
    for (int g = 0; g < groups; ++g)
        for (int c = group_begin[static_cast<std::size_t>(g)]; c < group_begin[static_cast<std::size_t>(g) + 1]; ++c) {
            const int lane = (c - group_begin[static_cast<std::size_t>(g)]) % lanes;
            owner[static_cast<std::size_t>(c)] = partner[static_cast<std::size_t>(c)] = own_rows[static_cast<std::size_t>(g * lanes + lane)];
            row[static_cast<std::size_t>(c)] = 4 * (c - lane + shape.row_of_lane[lane]);
        }
    next_.assign(static_cast<std::size_t>(s.disc_count()), 0);
    for (int k = 0; k < s.contact_count(); ++k) {
        const bool is_turned = turned_by_contact_[static_cast<std::size_t>(k)];
        const auto from = static_cast<std::size_t>(is_turned ? s.second[k] : s.first[k]);
        const auto to = static_cast<std::size_t>(is_turned ? s.first[k] : s.second[k]);
        const std::int32_t slot = slot_of_disc[from];
        const auto at = static_cast<std::size_t>(group_begin[static_cast<std::size_t>(slot / lanes)] + next_[from]++ * lanes + slot % lanes);
        contact[at] = k;
        turned[at] = is_turned;
        image_x[at] = is_turned ? -s.image_x[k] : s.image_x[k];
        image_y[at] = is_turned ? -s.image_y[k] : s.image_y[k];
        partner[at] = own_rows[static_cast<std::size_t>(slot_of_disc[to])];
    }
}

// In the order of the contact slots.
void SlotLayout::list_incoming(const AssemblyView& s) {
    const auto slots = static_cast<std::size_t>(disc_slots());
    incoming_begin.assign(slots + 1, 0);
    for (std::size_t k = 0; k < slots; ++k)
        incoming_begin[k + 1] = incoming_begin[k] + (disc[k] < 0 ? 0 : coming_[static_cast<std::size_t>(disc[k])]);
    incoming.resize(static_cast<std::size_t>(incoming_begin[slots]));
    next_.assign(incoming_begin.begin(), incoming_begin.end() - 1);
    for (std::size_t c = 0; c < contact.size(); ++c) {
        if (contact[c] < 0) continue;
        const std::int32_t to = turned[c] ? s.first[contact[c]] : s.second[contact[c]];
        incoming[static_cast<std::size_t>(next_[static_cast<std::size_t>(slot_of_disc[static_cast<std::size_t>(to)])]++)] = row[c];
    }
    list_runs();
}

void SlotLayout::list_runs() {
    const int set = shape.lanes_of_a_vector;
    runs.clear();
    incoming_of_sets.clear();
    const auto degree_of = [&](int k) { return incoming_begin[static_cast<std::size_t>(k) + 1] - incoming_begin[static_cast<std::size_t>(k)]; };
    for (int first = 0; first < disc_slots(); first += set) {
        std::int32_t degree = 0;
        for (int k = first; k < first + set; ++k) degree = std::max(degree, degree_of(k));
        if (runs.empty() || runs.back().degree != degree) runs.push_back({first, 0, degree});
        ++runs.back().sets;
        for (int m = 0; m < degree; ++m)
            for (int k = first; k < first + set; ++k)
                incoming_of_sets.push_back(m < degree_of(k) ? incoming[static_cast<std::size_t>(incoming_begin[static_cast<std::size_t>(k)] + m)]
                                                            : 4 * contact_slots());
    }
}

} // namespace talik::farm
