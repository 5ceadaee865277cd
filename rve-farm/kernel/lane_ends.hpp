#pragma once
// Both ends of a chunk for lanes: the state in slot order and displacement form, and back, in doubles side by side whatever the
// kernel computes in. The laws: chunk_ends.hpp. What lies in the state where the list has it is fetched and put one by one.
// Included by the files of the instruction levels only (lanes_*.cpp).
#include <type_traits>

#include "rve-farm/kernel/chunk_ends.hpp"
#include "rve-farm/kernel/lanes.hpp"
#include "rve-farm/kernel/work.hpp"

namespace talik::farm::inline HWY_NAMESPACE {

struct ThisLevel {}; // keeps the code of this level apart

template <class T>
using LaneWork = Work<T, ThisLevel>;

// A pack of the kernel is one vector of doubles, or two.
using Wide = Pack<double>;
template <class T>
constexpr int parts = Pack<T>::lanes / Wide::lanes;

// visit(integral constant) for each part.
template <class T, class Visitor>
HWY_INLINE void each_part(Visitor&& visit) {
    visit(std::integral_constant<int, 0>());
    if constexpr (parts<T> == 2) visit(std::integral_constant<int, 1>());
}
template <int part>
HWY_INLINE Wide widened(Pack<double> a) { return a; }
template <int part>
HWY_INLINE Wide widened(Pack<float> a) {
    const hn::ScalableTag<double> d;
    if constexpr (part == 0) return hn::PromoteTo(d, hn::LowerHalf(a.v));
    else return hn::PromoteTo(d, hn::UpperHalf(hn::Half<hn::ScalableTag<float>>(), a.v));
}
HWY_INLINE Pack<double> joined(const Wide (&a)[1]) { return a[0]; }
HWY_INLINE Pack<float> joined(const Wide (&a)[2]) {
    const hn::ScalableTag<float> d;
    const hn::Half<decltype(d)> half;
    return hn::Combine(d, hn::DemoteTo(half, a[1].v), hn::DemoteTo(half, a[0].v));
}
HWY_INLINE Wide from_integers(const std::int32_t* numbers) {
    const hn::ScalableTag<double> d;
    return hn::PromoteTo(d, hn::LoadU(hn::Rebind<std::int32_t, decltype(d)>(), numbers));
}
HWY_INLINE ContactLaw<Wide> widened(const ContactLaw<double>& law) { return {law.normal_stiffness, law.tangential_stiffness, law.friction}; }
HWY_INLINE CellMotion<Wide> widened(const ChunkMotion& cell) { return cell.as<Wide>(); }

template <class T>
HWY_NOINLINE void load_discs(const AssemblyView& s, const SlotLayout& layout, LaneWork<T>& w) {
    using P = Pack<T>;
    const int n = w.disc_slots;
    const std::int32_t *disc = layout.disc.data(), *own_rows = layout.own_rows.data();
    for (int k = 0; k < n; ++k) {
        const int i = disc[k];
        double* stored = w.stored + own_rows[k];
        T* velocity = w.velocity + k;
        if (i < 0) {
            for (int a = 0; a < 4; ++a) stored[a] = 0;
            velocity[0] = velocity[n] = velocity[2 * n] = 0;
            continue;
        }
        stored[0] = s.x[i], stored[1] = s.y[i], stored[2] = s.radius[i], stored[3] = s.mass[i];
        velocity[0] = static_cast<T>(s.velocity_x[i]), velocity[n] = static_cast<T>(s.velocity_y[i]), velocity[2 * n] = static_cast<T>(s.spin[i]);
    }
    for (int k = 0; k < n; k += P::lanes) {
        Wide x, y, radius[parts<T>], mass[parts<T>], inverse[parts<T>], inertia[parts<T>];
        for (int p = 0; p < parts<T>; ++p) {
            gather_rows(w.stored, own_rows + k + p * Wide::lanes, x, y, radius[p], mass[p]);
            const auto there = mass[p] > Wide(0);
            inverse[p] = choose(there, Wide(1) / mass[p], Wide(0));
            inertia[p] = choose(there, inverse_inertia(inverse[p], radius[p]), Wide(0));
        }
        const P r = joined(radius);
        for (int a = 0; a < 3; ++a) P().store(w.moved + a * n + k);
        r.store(w.moved + 3 * n + k);
        store_rows(P(), P(), P(), r, w.displacement + 4 * k);
        joined(inverse).store(w.inverse_mass + k);
        joined(inertia).store(w.inverse_mass + n + k);
        if (w.mass) joined(mass).store(w.mass + k);
    }
}

// Of a column of the state, what some slots hold; zero for inert ones.
template <class Entry>
HWY_INLINE Wide of_slots(const Entry* column, const std::int32_t* index) {
    alignas(64) double numbers[Wide::lanes];
    for (int l = 0; l < Wide::lanes; ++l) numbers[l] = index[l] < 0 ? 0 : static_cast<double>(column[index[l]]);
    return Wide::load(numbers);
}

// What the owner holds in a register.
struct StoredOwners {
    Wide x, y, radius, mass;
};

// Contacts, and the forces of those that discs own; returns the virial of the start, J.
template <bool ledger, bool bonds, class T>
HWY_NOINLINE Virial<double> load_contacts(const AssemblyView& s, const SlotLayout& layout, const ContactLaw<double>& law_of_one, LaneWork<T>& w) {
    using P = Pack<T>;
    using F = ContactField;
    const ContactLaw<Wide> law = widened(law_of_one);
    const AssemblyNumbers& numbers = *s.numbers;
    const Wide xx(numbers.cell_xx), xy(numbers.cell_xy), yx(numbers.cell_yx), yy(numbers.cell_yy);
    const int n = w.disc_slots;
    Virial<Wide> virial;
    T* field = w.blocks;
    for (int g = 0; g < layout.groups; ++g) {
        StoredOwners own[parts<T>];
        for (int p = 0; p < parts<T>; ++p)
            gather_rows(w.stored, layout.own_rows.data() + g * P::lanes + p * Wide::lanes, own[p].x, own[p].y, own[p].radius, own[p].mass);
        P force[3];
        for (int k = layout.group_begin[static_cast<std::size_t>(g)], end = layout.group_begin[static_cast<std::size_t>(g) + 1]; k < end; k += P::lanes) {
            Wide nx[parts<T>], ny[parts<T>], inverse_length[parts<T>], overlap[parts<T>], tangential[parts<T>], bonded[parts<T>];
            Wide fx[parts<T>], fy[parts<T>], owner_torque[parts<T>], partner_torque[parts<T>];
            for (int p = 0; p < parts<T>; ++p) {
                const int slot = k + p * Wide::lanes;
                const std::int32_t* which = layout.contact.data() + slot;
                const Wide image_x = from_integers(layout.image_x.data() + slot), image_y = from_integers(layout.image_y.data() + slot);
                Wide x, y, radius, mass;
                gather_rows(w.stored, layout.partner.data() + slot, x, y, radius, mass);
                const auto there = from_integers(which) > Wide(-0.5); // an inert one: one metre apart, of no size
                if constexpr (bonds) bonded[p] = of_slots(s.bonded, which);
                const StoredContact<Wide, Mask<double>> contact{choose(there, branch_component(own[p].x, x, xx, xy, image_x, image_y), Wide(1)),
                                                                choose(there, branch_component(own[p].y, y, yx, yy, image_x, image_y), Wide(0)),
                                                                {choose(there, own[p].radius, Wide(0)), choose(there, radius, Wide(0))},
                                                                of_slots(s.tangential_force, which),
                                                                bonded[p] > Wide(0)};
                const ContactAtStart<Wide> at = contact_at_start(contact, law);
                nx[p] = at.start.normal_x, ny[p] = at.start.normal_y, inverse_length[p] = at.start.inverse_length, overlap[p] = at.start.overlap;
                tangential[p] = at.tangential;
                fx[p] = at.force_x, fy[p] = at.force_y, owner_torque[p] = at.owner_torque, partner_torque[p] = at.partner_torque;
                if constexpr (ledger) virial.add_contact(at.force_x, at.force_y, contact.x, contact.y);
            }
            const auto put = [&](int f, P value) HWY_ATTR { value.store(field + f * P::lanes); };
            put(F::normal_x, joined(nx));
            put(F::normal_y, joined(ny));
            put(F::inverse_length, joined(inverse_length));
            put(F::overlap, joined(overlap));
            put(F::tangential_start, joined(tangential));
            for (int f : {F::turn, F::elongation, F::tangential_change}) put(f, P());
            if constexpr (bonds) put(F::bonded, joined(bonded));
            if constexpr (ledger) put(F::tangential(bonds), joined(tangential));
            field += F::count(bonds, ledger) * P::lanes;
            const P x = joined(fx), y = joined(fy);
            store_rows(x, y, joined(partner_torque), P(), w.contact_force + 4 * k);
            force[0] -= x, force[1] -= y, force[2] += joined(owner_torque);
        }
        for (int a = 0; a < 3; ++a) force[a].store(w.force + a * n + g * P::lanes);
    }
    for (int a = 0; a < 4; ++a) w.contact_force[4 * w.contact_slots + a] = 0;
    return {virial.xx.sum(), virial.yy.sum(), virial.xy.sum()};
}

template <class T>
HWY_NOINLINE bool displacements_are_finite(const LaneWork<T>& w) {
    Pack<T> sum;
    for (int k = 0; k < 3 * w.disc_slots; k += Pack<T>::lanes) sum += Pack<T>::load(w.moved + k) * Pack<T>(0); // 0, or not a number
    return sum.sum() == 0;
}

template <bool ledger, bool bonds, class T>
HWY_NOINLINE void close_contacts(const ChunkMotion& cell, const SlotLayout& layout, const ContactLaw<double>& law_of_one, const LaneWork<T>& w, AssemblyView& s, bool give_back,
                               ContactSums<double>& total) {
    using P = Pack<T>;
    using F = ContactField;
    const ContactLaw<Wide> law = widened(law_of_one);
    const CellMotion<P> e = cell.template as<P>();
    const int n = w.disc_slots;
    ContactSums<Wide> sums;
    const T* field = w.blocks;
    for (int g = 0; g < layout.groups; ++g) {
        const T* own = w.moved + g * P::lanes;
        const P own_x = P::load(own), own_y = P::load(own + n), own_rotation = P::load(own + 2 * n), own_radius = P::load(own + 3 * n);
        for (int k = layout.group_begin[static_cast<std::size_t>(g)], end = layout.group_begin[static_cast<std::size_t>(g) + 1]; k < end; k += P::lanes) {
            const auto get = [&](int f) HWY_ATTR { return P::load(field + f * P::lanes); };
            P x, y, rotation, radius;
            gather_rows(w.displacement, layout.partner.data() + k, x, y, rotation, radius);
            const ContactAtEnd<P> at{{get(F::normal_x), get(F::normal_y), get(F::inverse_length), get(F::overlap)},
                                     {own_radius, radius},
                                     get(F::tangential_change),
                                     {x - own_x, y - own_y, own_rotation + rotation, own_rotation - rotation}};
            const BranchAtEnd<P> branch(e, at);
            P held;
            if constexpr (bonds) held = get(F::bonded);
            field += F::count(bonds, ledger) * P::lanes;
            each_part<T>([&](auto which) HWY_ATTR {
                constexpr int p = decltype(which)::value;
                const std::int32_t* contact = layout.contact.data() + k + p * Wide::lanes;
                alignas(64) double tangential[Wide::lanes];
                const ContactToClose<Wide, Mask<double>> closing{widened<p>(branch.normal_x),
                                                                 widened<p>(branch.normal_y),
                                                                 widened<p>(branch.strain),
                                                                 widened<p>(at.start.overlap),
                                                                 {widened<p>(at.radii.owner), widened<p>(at.radii.partner)},
                                                                 widened<p>(at.tangential_change),
                                                                 widened<p>(at.moved.rotation_difference),
                                                                 of_slots(s.tangential_force, contact),
                                                                 widened<p>(held) > Wide(0)};
                close_contact(law, closing, sums).store(tangential);
                if (!give_back) return;
                for (int l = 0; l < Wide::lanes; ++l)
                    if (contact[l] >= 0) s.tangential_force[contact[l]] = tangential[l];
                if constexpr (bonds) {
                    alignas(64) double bonded[Wide::lanes];
                    widened<p>(held).store(bonded);
                    for (int l = 0; l < Wide::lanes; ++l)
                        if (contact[l] >= 0) s.bonded[contact[l]] = bonded[l] > 0;
                }
            });
        }
    }
    total.virial = {sums.virial.xx.sum(), sums.virial.yy.sum(), sums.virial.xy.sum()};
    total.fabric_xx = sums.fabric_xx.sum(), total.fabric_yy = sums.fabric_yy.sum(), total.fabric_xy = sums.fabric_xy.sum();
    total.force = sums.force.sum(), total.stored_energy = sums.stored_energy.sum();
    total.contacts = sums.contacts.sum(), total.bonds = sums.bonds.sum();
}

// To the forces of the contacts that discs own, those of the contacts that come in; `degree` of them to a disc at most.
template <class T>
HWY_INLINE void add_incoming(const T* HWY_RESTRICT rows, const std::int32_t* HWY_RESTRICT incoming, int degree, Pack<T> (&force)[3]) {
    if (degree <= 0) return;
    RowsOfLanes<T> sum(rows, incoming);
    for (int m = 1; m < degree; ++m) sum += RowsOfLanes<T>(rows, incoming + m * Pack<T>::lanes);
    Pack<T> x, y, torque, nothing;
    sum.transpose(x.v, y.v, torque.v, nothing.v);
    force[0] += x, force[1] += y, force[2] += torque;
}

template <bool fluctuation, class T>
HWY_NOINLINE void close_discs(const ChunkRequest& request, const ChunkMotion& cell, const SlotLayout& layout, const LaneWork<T>& w, AssemblyView& s, DiscSums<double>& total) {
    using P = Pack<T>;
    const CellMotion<Wide> e = widened(cell);
    const Wide last_sub_step(request.substeps > 0 ? request.sub_step : s.numbers->last_sub_step);
    const int n = w.disc_slots;
    DiscSums<Wide> sums;
    const std::int32_t* incoming = layout.incoming_of_sets.data();
    for (const IncomingRun run : layout.runs)
        for (int k = run.first_slot, end = run.first_slot + run.sets * P::lanes; k < end; k += P::lanes, incoming += run.degree * P::lanes) {
            P force[3] = {P::load(w.force + k), P::load(w.force + n + k), P::load(w.force + 2 * n + k)};
            add_incoming(w.contact_force, incoming, run.degree, force);
            const P u[2] = {P::load(w.moved + k), P::load(w.moved + n + k)}, v[3] = {P::load(w.velocity + k), P::load(w.velocity + n + k), P::load(w.velocity + 2 * n + k)};
            each_part<T>([&](auto which) HWY_ATTR {
                constexpr int p = decltype(which)::value;
                const int first = k + p * Wide::lanes;
                const std::int32_t* disc = layout.disc.data() + first;
                alignas(64) double x[Wide::lanes], y[Wide::lanes], drift_x[Wide::lanes], drift_y[Wide::lanes];
                StoredDisc<Wide> stored;
                gather_rows(w.stored, layout.own_rows.data() + first, stored.x, stored.y, stored.radius, stored.mass);
                stored.drift_x = of_slots(s.drift_x, disc), stored.drift_y = of_slots(s.drift_y, disc);
                const DiscAtEnd<Wide> at{widened<p>(u[0]), widened<p>(u[1]), widened<p>(v[0]), widened<p>(v[1]), widened<p>(v[2]), widened<p>(force[0]), widened<p>(force[1]), widened<p>(force[2])};
                close_disc(e, at, last_sub_step, fluctuation, stored, sums);
                if (!request.give_back) return;
                stored.x.store(x), stored.y.store(y), stored.drift_x.store(drift_x), stored.drift_y.store(drift_y);
                for (int l = 0; l < Wide::lanes; ++l) {
                    const int i = disc[l];
                    if (i < 0) continue;
                    s.x[i] = x[l], s.y[i] = y[l], s.drift_x[i] = drift_x[l], s.drift_y[i] = drift_y[l];
                    const T* velocity = w.velocity + first + l;
                    s.velocity_x[i] = velocity[0], s.velocity_y[i] = velocity[n], s.spin[i] = velocity[2 * n];
                }
            });
        }
    total.fluctuation = {sums.fluctuation.xx.sum(), sums.fluctuation.yy.sum(), sums.fluctuation.xy.sum()};
    total.kinetic = sums.kinetic.sum(), total.unbalanced = sums.unbalanced.sum();
    total.force_xx = sums.force_xx.sum(), total.force_yy = sums.force_yy.sum(), total.force_xy = sums.force_xy.sum();
    total.largest_drift_squared = sums.largest_drift_squared.largest();
}

} // namespace talik::farm::inline HWY_NAMESPACE
