#pragma once
// The kernel for lanes: the same laws as the plain one, with a schedule of its own. Contacts of a group of discs are taken
// side by side; the owner's side stays in registers, the partner's is fetched as a row and answered as a row, which the
// partner pulls in the next sub-step. Everything is in order and there is no scatter, so the bits are always the same.
// Included by the files of the instruction levels only (lanes_*.cpp).
#include <type_traits>

#include "rve-farm/kernel/chunk.hpp"
#include "rve-farm/kernel/disc_step.hpp"
#include "rve-farm/kernel/lanes.hpp"
#include "rve-farm/physics/physics_choice.hpp"

namespace talik::farm::inline HWY_NAMESPACE {

struct ThisLevel {}; // keeps the code of this level apart

template <class T>
using LaneWork = Work<T, ThisLevel>;

// Running over the discs.
template <class T>
struct DiscSweep {
    Pack<T> largest_squared; // of the displacements, m^2
    DiscLoss<Pack<T>> loss;  // for the ledger
};

// What is the same for all discs in a sub-step.
template <class T>
struct DiscConstants {
    PlanarStretch<Pack<T>> change; // U - I
    Pack<T> kick, dt;              // s
};

// Newton for a run of discs. What comes in to a disc is added to what its own contacts have given, by number of contacts known
// when compiled (most >= 0) or not. The sweep goes in and out by value: what is written through pointers cannot change it.
template <int most, bool ledger, class T, class Physics>
HWY_INLINE DiscSweep<T> move_run(const Physics& physics, const DiscConstants<T> c, const IncomingRun run, const std::int32_t* HWY_RESTRICT incoming,
                                 const LaneWork<T>& w, DiscSweep<T> sweep) {
    using P = Pack<T>;
    const int degree = most >= 0 ? most : run.degree, n = w.disc_slots;
    const T* HWY_RESTRICT rows = w.contact_force;
    T* HWY_RESTRICT displacement = w.displacement;
    T* HWY_RESTRICT velocity = w.velocity;
    T* HWY_RESTRICT moved = w.moved;
    for (int k = run.first_slot, end = run.first_slot + run.sets * P::lanes; k < end; k += P::lanes, incoming += degree * P::lanes) {
        P force[3] = {P::load(w.force + k), P::load(w.force + n + k), P::load(w.force + 2 * n + k)};
        if (degree > 0) {
            RowsOfLanes<T> sum(rows, incoming);
            for (int m = 1; m < degree; ++m) sum += RowsOfLanes<T>(rows, incoming + m * P::lanes);
            P x, y, torque, nothing;
            sum.transpose(x.v[0], y.v[0], torque.v[0], nothing.v[0]);
            force[0] += x, force[1] += y, force[2] += torque;
        }
        const P inverse_mass = P::load(w.inverse_mass + k);
        P mass;
        if constexpr (ledger && Physics::with_fluctuation) mass = P::load(w.mass + k);
        P v[3] = {P::load(velocity + k), P::load(velocity + n + k), P::load(velocity + 2 * n + k)};
        P u[3] = {P::load(moved + k), P::load(moved + n + k), P::load(moved + 2 * n + k)};
        disc_step<ledger>(physics, c.change, c.kick, c.dt, force, {inverse_mass, inverse_mass, P::load(w.inverse_mass + n + k)}, mass, v, u, sweep.loss);
        for (int a = 0; a < 3; ++a) {
            v[a].store(velocity + a * n + k);
            u[a].store(moved + a * n + k);
        }
        store_rows(u[0], u[1], u[2], P::load(moved + 3 * n + k), displacement + 4 * k);
        sweep.largest_squared = larger(u[0] * u[0] + u[1] * u[1], sweep.largest_squared);
    }
    return sweep;
}

// Newton for all discs: those of equal degree follow one another, so that no branch is mispredicted.
template <bool ledger, class T, class Physics>
HWY_INLINE void move_discs(const Physics& physics, const SlotLayout& layout, const Symmetric& d, T kick, T dt, const LaneWork<T>& w, Pack<T>& largest_squared,
                           DiscLoss<double>& books) {
    const DiscConstants<T> c{{d.xx, d.yy, d.xy}, kick, dt};
    DiscSweep<T> sweep{largest_squared, {}};
    const std::int32_t* incoming = layout.incoming_of_sets.data();
    for (const IncomingRun run : layout.runs) {
        switch (run.degree) {
        case 0: sweep = move_run<0, ledger>(physics, c, run, incoming, w, sweep); break;
        case 1: sweep = move_run<1, ledger>(physics, c, run, incoming, w, sweep); break;
        case 2: sweep = move_run<2, ledger>(physics, c, run, incoming, w, sweep); break;
        case 3: sweep = move_run<3, ledger>(physics, c, run, incoming, w, sweep); break;
        case 4: sweep = move_run<4, ledger>(physics, c, run, incoming, w, sweep); break;
        case 5: sweep = move_run<5, ledger>(physics, c, run, incoming, w, sweep); break;
        default: sweep = move_run<-1, ledger>(physics, c, run, incoming, w, sweep);
        }
        incoming += run.degree * run.sets * Pack<T>::lanes;
    }
    largest_squared = sweep.largest_squared;
    if constexpr (ledger) {
        const DiscLoss<Pack<T>>& sum = sweep.loss;
        books = {sum.damping.sum(), sum.fluctuation_work.sum(), sum.power_xx.sum(), sum.power_yy.sum(), sum.twice_power_xy.sum()};
    }
}

struct ContactBooks {
    double friction = 0, bond = 0;
    Virial<double> virial;
};

// The same law on packs of contacts.
template <class T>
using Contacts = Pack<T, vectors_of_contacts>;
inline NoBond of_contacts(const NoBond&) { return {}; }
template <class T>
BrittleBond<Contacts<T>> of_contacts(const BrittleBond<Pack<T>>& b) { return {b.normal_strength, b.tangential_strength, b.strength_factor}; }
template <class T, class Physics>
auto physics_of_contacts(const Physics& p) {
    const ContactLaw<Contacts<T>> contact{p.contact.normal_stiffness, p.contact.tangential_stiffness, p.contact.friction};
    return farm::Physics<decltype(of_contacts(p.bond)), NoDamping, NoFluctuation, Contacts<T>>{contact, of_contacts(p.bond), {}, {}};
}

template <bool ledger, class T, class Physics>
HWY_INLINE void step_contacts(const Physics& physics, const CellMotion<Contacts<T>>& cell, T beta_of_now, const SlotLayout& layout, LaneWork<T>& w, ContactBooks& books) {
    using P = Contacts<T>;
    [[maybe_unused]] P friction_sum, bond_sum, xx_sum, yy_sum, xy_sum;
    [[maybe_unused]] const P beta(beta_of_now);
    using F = ContactField;
    constexpr int block = F::count(Physics::with_bonds, ledger) * P::lanes;
    const std::int32_t* HWY_RESTRICT partner = layout.partner.data();
    const std::int32_t* HWY_RESTRICT group_begin = layout.group_begin.data();
    const T* HWY_RESTRICT displacement = w.displacement;
    const T* HWY_RESTRICT own = w.moved;
    T* HWY_RESTRICT force = w.force;
    T* HWY_RESTRICT field = w.blocks;
    T* HWY_RESTRICT rows = w.contact_force;
    const int n = w.disc_slots;
    for (int g = 0; g < layout.groups; ++g, own += P::lanes, force += P::lanes) {
        const P own_x = P::load(own), own_y = P::load(own + n), own_rotation = P::load(own + 2 * n), own_half_radius = P::load(own + 3 * n);
        P sum_x, sum_y, sum_torque;
        for (int k = group_begin[g]; k < group_begin[g + 1]; k += P::lanes, partner += P::lanes, field += block, rows += 4 * P::lanes) {
            P x, y, rotation, half_radius;
            gather_rows(displacement, partner, x, y, rotation, half_radius);
            const ContactRadii<P> radii(own_half_radius, half_radius);
            const RelativeMotion<P> moved{x - own_x, y - own_y, rotation + own_rotation, own_rotation - rotation};
            const auto get = [&](int f) HWY_ATTR { return P::load(field + f * P::lanes); };
            const auto put = [&](int f, P value) HWY_ATTR { value.store(field + f * P::lanes); };
            const ContactStart<P> start{get(F::normal_x), get(F::normal_y), get(F::inverse_length), get(F::half_overlap), get(F::tangential_start)};
            ContactMemory<P> memory{get(F::double_turn), get(F::half_change), get(F::tangential_change)};
            ContactLoss<P> loss;
            P old_tangential;
            if constexpr (ledger) old_tangential = get(F::tangential(Physics::with_bonds));
            ContactAction<P> action;
            if constexpr (Physics::with_bonds) {
                BondState<P> bonds{get(F::bonded), P(2) * smaller(own_half_radius, half_radius), beta};
                action = contact_step<ledger>(physics, cell, start, radii, moved, memory, bonds, old_tangential, loss);
                put(F::bonded, bonds.bonded);
            } else {
                NoBondState<P> none;
                action = contact_step<ledger>(physics, cell, start, radii, moved, memory, none, old_tangential, loss);
            }
            put(F::double_turn, memory.double_turn);
            put(F::half_change, memory.half_change);
            put(F::tangential_change, memory.tangential_change);
            store_rows(action.x, action.y, action.partner_torque, P(), rows);
            sum_x -= action.x;
            sum_y -= action.y;
            sum_torque += action.owner_torque;
            if constexpr (ledger) {
                put(F::tangential(Physics::with_bonds), action.tangential);
                friction_sum += loss.friction;
                if constexpr (Physics::with_bonds) bond_sum += loss.bond;
                const P length = action.half_length + action.half_length, bx = length * action.normal_x, by = length * action.normal_y;
                xx_sum += action.x * bx;
                yy_sum += action.y * by;
                xy_sum += action.x * by + action.y * bx;
            }
        }
        sum_x.store(force);
        sum_y.store(force + n);
        sum_torque.store(force + 2 * n);
    }
    if constexpr (ledger) {
        books.friction = friction_sum.sum();
        books.bond = bond_sum.sum();
        books.virial = {xx_sum.sum(), yy_sum.sum(), xy_sum.sum() / 2};
    }
}

template <bool ledger, class T, class Physics>
ChunkOutcome run_lanes(const Physics& physics, const ContactLaw<double>& law, const ChunkRequest& request, AssemblyView& s, const ColumnChoice& columns,
                       const SlotLayout& layout, WorkMemory& memory) {
    using P = Pack<T>;
    const SerialTeam team;
    StageClock<ThisLevel> clock(request.time_stages);
    LaneWork<T> w(memory, layout, columns, ledger, false);
    load_discs(team, s, layout, w);
    load_contacts(team, s, layout, law, w);
    for (int a = 0; a < 4; ++a) w.contact_force[4 * w.contact_slots + a] = 0;
    for (int k = 0; k < w.disc_slots; ++k) {
        T sum[3] = {0, 0, 0};
        add_owned(w, layout, k, sum);
        for (int a = 0; a < 3; ++a) w.force[a * w.disc_slots + k] = sum[a];
    }
    ChunkOutcome outcome;
    ChunkMotion cell;
    ChunkLedger booked;
    WorkLedger work(ledger ? virial_at_start(w, layout) : Virial<double>{});
    Stretch stretch = request.stretch;
    const auto contacts = physics_of_contacts<T>(physics);
    P largest_squared;
    outcome.load_seconds = clock.lap();
    for (int step = 0; step < request.substeps; ++step) {
        DiscLoss<double> of_discs;
        move_discs<ledger>(physics, layout, stretch.change(), static_cast<T>(step == 0 ? request.first_kick : request.sub_step), static_cast<T>(request.sub_step), w,
                           largest_squared, of_discs); // Eqs. (44)-(46)
        cell.advance(stretch);
        ContactBooks of_contacts;
        step_contacts<ledger>(contacts, cell.template as<Contacts<T>>(), static_cast<T>(request.beta), layout, w, of_contacts); // Eqs. (5)-(7)
        if constexpr (ledger) {
            booked.damping += of_discs.damping;
            booked.friction += of_contacts.friction;
            booked.bond += of_contacts.bond;
            booked.work += of_discs.fluctuation_work;
            work.sub_step(stretch.change(), stretch.change_seen_from_the_end(), of_contacts.virial, {of_discs.power_xx, of_discs.power_yy, of_discs.twice_power_xy / 2}, request.sub_step, booked);
        }
        outcome.strain += stretch.largest_strain();
        outcome.last_stretch = stretch;
        stretch.turn_with_the_frame();
    }
    outcome.stretch = stretch;
    finish(request, clock, cell, law, layout, w, s, booked, std::sqrt(largest_squared.largest()), outcome);
    return outcome;
}

template <class T>
ChunkOutcome run(const RveParameters& parameters, const ChunkRequest& request, AssemblyView& s, const ColumnChoice& columns, const SlotLayout& layout,
                 WorkMemory& memory) {
    ChunkOutcome outcome;
    with_physics<Pack<T>>(parameters, [&](const auto& physics) {
        const ContactLaw<double> law = contact_law_of(parameters);
        outcome = request.ledger ? run_lanes<true, T>(physics, law, request, s, columns, layout, memory)
                                 : run_lanes<false, T>(physics, law, request, s, columns, layout, memory);
    });
    return outcome;
}

template <class T>
LaneShape shape() {
    LaneShape s;
    s.lanes = Contacts<T>::lanes;
    s.lanes_of_a_vector = Pack<T>::lanes;
    row_order<T, vectors_of_contacts>(s.row_of_lane);
    return s;
}

} // namespace talik::farm::inline HWY_NAMESPACE
