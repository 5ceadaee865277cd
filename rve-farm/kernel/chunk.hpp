#pragma once
// What the kernels of the CPU do before and after the sub-steps of a chunk: the state in slot order and displacement form, and
// back. Plain loops over slots, index i writing only slot i, for any team. The laws of both ends: chunk_ends.hpp.
#include <time.h>

#include "rve-farm/kernel/chunk_ends.hpp"
#include "rve-farm/kernel/conclude.hpp"
#include "rve-farm/kernel/work.hpp"
#include "rve-farm/physics/physics.hpp"

namespace talik::farm {

// The clock of a chunk's stages, read only where they are asked for.
template <class Level>
class StageClock {
public:
    explicit StageClock(bool on) : on_(on) { lap(); }
    double lap() { // seconds since the last lap
        if (!on_) return 0;
        timespec now;
        clock_gettime(CLOCK_MONOTONIC, &now);
        const double seconds = static_cast<double>(now.tv_sec - last_.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec - last_.tv_nsec);
        last_ = now;
        return seconds;
    }

private:
    bool on_;
    timespec last_{};
};

template <class Real, class Level>
void load_discs(const auto& team, const AssemblyView& s, const SlotLayout& layout, Work<Real, Level>& w) {
    team.each(w.disc_slots, [&](int k) {
        const int i = layout.disc[static_cast<std::size_t>(k)], n = w.disc_slots;
        const DiscAtStart at = i < 0 ? DiscAtStart{} : disc_at_start(s, i);
        Real* row = w.displacement + layout.own_rows[static_cast<std::size_t>(k)];
        const Real radius = static_cast<Real>(i < 0 ? 0 : s.radius[i]);
        for (int a = 0; a < 4; ++a) row[a] = a < 3 ? Real(0) : radius;
        for (int a = 0; a < 4 && w.moved; ++a) w.moved[a * n + k] = a < 3 ? Real(0) : radius;
        w.velocity[k] = static_cast<Real>(at.velocity_x);
        w.velocity[n + k] = static_cast<Real>(at.velocity_y);
        w.velocity[2 * n + k] = static_cast<Real>(at.spin);
        w.inverse_mass[k] = static_cast<Real>(at.inverse_mass);
        w.inverse_mass[n + k] = static_cast<Real>(at.inverse_inertia);
        if (w.mass) w.mass[k] = static_cast<Real>(i < 0 ? 0 : s.mass[i]);
    });
}

template <class Real, class Level>
void load_contacts(const auto& team, const AssemblyView& s, const SlotLayout& layout, const ContactLaw<double>& law, Work<Real, Level>& w) {
    team.each(w.contact_slots, [&](int k) {
        const auto slot = static_cast<std::size_t>(k);
        const int c = layout.contact[slot];
        const ContactAtStart at = c < 0 ? ContactAtStart::inert() : contact_at_start(s, c, layout.turned[slot] != 0, law);
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
        if (w.bonds) field[F::bonded * lanes] = at.bonded ? 1 : 0;
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

template <class Level, class Real>
void close_contacts(const ChunkMotion& cell, const SlotLayout& layout, const ContactLaw<double>& law, const Work<Real, Level>& w, AssemblyView& s, bool give_back,
                    ContactSums& sums) {
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
        const ContactAtEnd<Real> at{field[F::normal_x * lanes], field[F::normal_y * lanes], field[F::inverse_length * lanes], field[F::overlap * lanes],
                                    {wi[3], wj[3]},             field[F::tangential_change * lanes], w.bonds && field[F::bonded * lanes] > 0,
                                    {wj[0] - wi[0], wj[1] - wi[1], wi[2] + wj[2], wi[2] - wj[2]}};
        close_contact(e, law, at, s, c, give_back, sums);
    }
}

template <class Real, class Level>
void close_discs(const ChunkRequest& request, const ChunkMotion& cell, const SlotLayout& layout, const Work<Real, Level>& w, AssemblyView& s,
                 ChunkSums& sums) {
    const double last_sub_step = request.substeps > 0 ? request.sub_step : s.numbers->last_sub_step;
    for (int k = 0; k < w.disc_slots; ++k) {
        const int i = layout.disc[static_cast<std::size_t>(k)], n = w.disc_slots;
        if (i < 0) continue;
        Real force[3] = {0, 0, 0};
        if (w.force) force[0] = w.force[k], force[1] = w.force[n + k], force[2] = w.force[2 * n + k];
        else add_owned(w, layout, k, force);
        add_incoming(w, layout, k, force);
        const Real* row = w.displacement + layout.own_rows[static_cast<std::size_t>(k)];
        const DiscAtEnd<Real> at{row[0], row[1], w.velocity[k], w.velocity[n + k], w.velocity[2 * n + k], force[0], force[1], force[2]};
        close_disc(cell, at, last_sub_step, w.mass != nullptr, s, i, request.give_back, sums.discs, sums.largest_drift_squared);
    }
}

// The last word on a chunk: is it sound, has the list held, and then state and answer.
template <class Real, class Level>
void finish(const ChunkRequest& request, StageClock<Level>& clock, const ChunkMotion& cell, const ContactLaw<double>& law, const SlotLayout& layout, Work<Real, Level>& w,
            AssemblyView& s, const ChunkLedger& ledger, double largest_displacement, ChunkOutcome& outcome) {
    outcome.inner_seconds = clock.lap();
    outcome.largest_displacement = largest_displacement;
    outcome.finite = displacements_are_finite(w);
    outcome.accepted = outcome.finite && (request.substeps == 0 || largest_displacement <= request.displacement_allowed);
    if (outcome.accepted) {
        ChunkSums sums{ledger, {}, {}, 0};
        close_contacts(cell, layout, law, w, s, request.give_back, sums.contacts);
        close_discs(request, cell, layout, w, s, sums);
        conclude(request, cell, law, sums, *s.numbers, outcome);
    }
    outcome.close_seconds = clock.lap();
}

} // namespace talik::farm
