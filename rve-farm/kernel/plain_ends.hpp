#pragma once
// Both ends of a chunk for the plain kernel: the state in slot order and displacement form, and back. Plain loops over slots, index
// i writing only slot i, for any team. The laws: chunk_ends.hpp.
#include "rve-farm/kernel/chunk_ends.hpp"
#include "rve-farm/kernel/work.hpp"

namespace talik::farm {

template <class Real, class Level>
void load_discs(const auto& team, const AssemblyView& s, const SlotLayout& layout, Work<Real, Level>& w) {
    team.each(w.disc_slots, [&](int k) {
        const int i = layout.disc[static_cast<std::size_t>(k)], n = w.disc_slots;
        const bool there = i >= 0;
        const double inverse_mass = there ? 1 / s.mass[i] : 0;
        Real* row = w.displacement + layout.own_rows[static_cast<std::size_t>(k)];
        const Real radius = there ? static_cast<Real>(s.radius[i]) : Real(0);
        for (int a = 0; a < 4; ++a) row[a] = a < 3 ? Real(0) : radius;
        w.velocity[k] = there ? static_cast<Real>(s.velocity_x[i]) : Real(0);
        w.velocity[n + k] = there ? static_cast<Real>(s.velocity_y[i]) : Real(0);
        w.velocity[2 * n + k] = there ? static_cast<Real>(s.spin[i]) : Real(0);
        w.inverse_mass[k] = static_cast<Real>(inverse_mass);
        w.inverse_mass[n + k] = there ? static_cast<Real>(inverse_inertia(inverse_mass, s.radius[i])) : Real(0);
        if (w.mass) w.mass[k] = there ? static_cast<Real>(s.mass[i]) : Real(0);
    });
}

template <class Real, class Level>
void load_contacts(const auto& team, const AssemblyView& s, const SlotLayout& layout, const ContactLaw<double>& law, Work<Real, Level>& w) {
    team.each(w.contact_slots, [&](int k) {
        const auto slot = static_cast<std::size_t>(k);
        const int c = layout.contact[slot];
        const StoredContact<double, bool> stored = c < 0 ? inert_contact() : stored_contact(s, c, layout.turned[slot] != 0);
        const ContactAtStart<double> at = contact_at_start(stored, law);
        const int row = layout.row[slot], lanes = w.lanes();
        Real* field = w.contact(k);
        using F = ContactField;
        field[F::normal_x * lanes] = static_cast<Real>(at.start.normal_x);
        field[F::normal_y * lanes] = static_cast<Real>(at.start.normal_y);
        field[F::inverse_length * lanes] = static_cast<Real>(at.start.inverse_length);
        field[F::overlap * lanes] = static_cast<Real>(at.start.overlap);
        field[F::tangential_start * lanes] = static_cast<Real>(at.tangential);
        field[F::turn * lanes] = field[F::elongation * lanes] = field[F::tangential_change * lanes] = 0;
        if (w.ledger) field[F::tangential(w.bonds) * lanes] = static_cast<Real>(at.tangential);
        if (w.bonds) field[F::bonded * lanes] = stored.bonded ? 1 : 0;
        w.contact_force[row] = static_cast<Real>(at.force_x);
        w.contact_force[row + 1] = static_cast<Real>(at.force_y);
        w.contact_force[row + 2] = static_cast<Real>(at.partner_torque);
        w.contact_force[row + 3] = static_cast<Real>(at.owner_torque);
    });
}

// Sum of f x b of the forces at the start, J.
template <class Real, class Level>
Virial<double> virial_at_start(const Work<Real, Level>& w, const SlotLayout& layout) {
    Virial<double> sum;
    for (int k = 0; k < w.contact_slots; ++k) {
        const Real* f = w.contact_force + layout.row[static_cast<std::size_t>(k)];
        const Real* field = w.contact(k);
        const double length = 1 / static_cast<double>(field[ContactField::inverse_length * w.lanes()]);
        sum.add_contact(f[0], f[1], length * field[ContactField::normal_x], length * field[ContactField::normal_y * w.lanes()]);
    }
    return sum;
}

// The forces on a disc from the contacts it owns, in their order.
template <class Real, class Level>
TALIK_HOST_DEVICE void add_owned(const Work<Real, Level>& w, const SlotLayout& layout, int k, Real (&sum)[3]) {
    const int lanes = layout.shape.lanes;
    const auto group = static_cast<std::size_t>(k / lanes);
    for (int c = layout.group_begin[group] + k % lanes; c < layout.group_begin[group + 1]; c += lanes) {
        const Real* f = w.contact_force + layout.row[static_cast<std::size_t>(c)];
        sum[0] -= f[0];
        sum[1] -= f[1];
        sum[2] += f[3];
    }
}
// And from those that come in.
template <class Real, class Level>
TALIK_HOST_DEVICE void add_incoming(const Work<Real, Level>& w, const SlotLayout& layout, int k, Real (&sum)[3]) {
    for (int c = layout.incoming_begin[static_cast<std::size_t>(k)]; c < layout.incoming_begin[static_cast<std::size_t>(k) + 1]; ++c) {
        const Real* f = w.contact_force + layout.incoming[static_cast<std::size_t>(c)];
        sum[0] += f[0];
        sum[1] += f[1];
        sum[2] += f[2];
    }
}

template <class Real, class Level>
bool displacements_are_finite(const Work<Real, Level>& w) {
    Real sum = 0;
    for (int k = 0; k < 4 * w.disc_slots; ++k) sum += w.displacement[k] * Real(0); // 0, or not a number
    return sum == 0;
}

template <class Real, class Level>
void close_contacts(const ChunkMotion& cell, const SlotLayout& layout, const ContactLaw<double>& law, const Work<Real, Level>& w, AssemblyView& s, bool give_back,
                    ContactSums<double>& sums) {
    const CellMotion<Real> e = cell.template as<Real>();
    for (int k = 0; k < w.contact_slots; ++k) {
        const auto slot = static_cast<std::size_t>(k);
        const int c = layout.contact[slot];
        if (c < 0) continue;
        using F = ContactField;
        const int lanes = w.lanes();
        const Real* field = w.contact(k);
        const Real* wi = w.displacement + layout.owner[slot];
        const Real* wj = w.displacement + layout.partner[slot];
        const ContactAtEnd<Real> at{{field[F::normal_x * lanes], field[F::normal_y * lanes], field[F::inverse_length * lanes], field[F::overlap * lanes]},
                                    {wi[3], wj[3]},
                                    field[F::tangential_change * lanes],
                                    {wj[0] - wi[0], wj[1] - wi[1], wi[2] + wj[2], wi[2] - wj[2]}};
        close_contact(e, law, at, w.bonds && field[F::bonded * lanes] > 0, s, c, give_back, sums);
    }
}

template <class Real, class Level>
void close_discs(const ChunkRequest& request, const ChunkMotion& cell, const SlotLayout& layout, const Work<Real, Level>& w, AssemblyView& s,
                 DiscSums<double>& sums) {
    const double last_sub_step = request.substeps > 0 ? request.sub_step : s.numbers->last_sub_step;
    for (int k = 0; k < w.disc_slots; ++k) {
        const int i = layout.disc[static_cast<std::size_t>(k)], n = w.disc_slots;
        if (i < 0) continue;
        Real force[3] = {0, 0, 0};
        add_owned(w, layout, k, force);
        add_incoming(w, layout, k, force);
        const Real* row = w.displacement + layout.own_rows[static_cast<std::size_t>(k)];
        const DiscAtEnd<Real> at{row[0], row[1], w.velocity[k], w.velocity[n + k], w.velocity[2 * n + k], force[0], force[1], force[2]};
        close_disc(cell, at, last_sub_step, w.mass != nullptr, s, i, request.give_back, sums);
    }
}

} // namespace talik::farm
