#pragma once
// The kernel for lanes: the same laws as the plain one, with a schedule of its own. Contacts of a group of discs are taken
// side by side; the owner's side stays in registers, the partner's is fetched as a row and answered as a row, which the
// partner pulls in the next sub-step. Everything is in order and there is no scatter, so the bits are always the same.
// Included by the files of the instruction levels only (lanes_*.cpp).
#include <algorithm>
#include <type_traits>

#include "rve-farm/kernel/chunk.hpp"
#include "rve-farm/kernel/disc_step.hpp"
#include "rve-farm/kernel/lane_ends.hpp"
#include "rve-farm/physics/physics_choice.hpp"

namespace talik::farm::inline HWY_NAMESPACE {

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
        add_incoming(rows, incoming, degree, force);
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

// The branches of some groups move before any of their contacts answers: two short chains keep a core busier than a long one and
// need fewer registers, which outweighs what is put by between them. Measured: docs/performance.md.

// What a pack of contacts puts by from the one pass to the other.
template <class P>
struct MovedContacts {
    ContactMotion<P> motion;
    P partner_radius; // m
};
template <bool opening, class P, class T>
HWY_INLINE void put_by(const MovedContacts<P>& moved, T* at) {
    const ContactMotion<P>& m = moved.motion;
    m.normal_x.store(at);
    m.normal_y.store(at + P::lanes);
    m.overlap.store(at + 2 * P::lanes);
    m.slip.store(at + 3 * P::lanes);
    m.double_roll.store(at + 4 * P::lanes);
    moved.partner_radius.store(at + 5 * P::lanes);
    if constexpr (opening) m.opening.store(at + 6 * P::lanes);
}
template <bool opening, class P, class T>
HWY_INLINE MovedContacts<P> fetch(const T* at) {
    return {{P::load(at), P::load(at + P::lanes), P::load(at + 2 * P::lanes), P::load(at + 3 * P::lanes), P::load(at + 4 * P::lanes), opening ? P::load(at + 6 * P::lanes) : P()},
            P::load(at + 5 * P::lanes)};
}

// The discs that own the contacts of a group.
template <class P>
struct Owners {
    P x, y, rotation, radius;
};

// The branches of a pack of contacts.
template <class T, class P>
HWY_INLINE MovedContacts<P> move_branches(const CellMotion<P>& cell, const Owners<P>& own, const T* HWY_RESTRICT displacement, const std::int32_t* HWY_RESTRICT partner,
                                          T* HWY_RESTRICT field) {
    using F = ContactField;
    const auto get = [&](int f) HWY_ATTR { return P::load(field + f * P::lanes); };
    P x, y, rotation, radius;
    gather_rows(displacement, partner, x, y, rotation, radius);
    const RelativeMotion<P> moved{x - own.x, y - own.y, rotation + own.rotation, own.rotation - rotation};
    const ContactStart<P> start{get(F::normal_x), get(F::normal_y), get(F::inverse_length), get(F::overlap)};
    ContactMemory<P> memory{get(F::turn), get(F::elongation)};
    const ContactMotion<P> motion = contact_motion(cell, start, ContactRadii<P>{own.radius, radius}, moved, memory);
    memory.turn.store(field + F::turn * P::lanes);
    memory.elongation.store(field + F::elongation * P::lanes);
    return {motion, radius};
}

// Over the contacts of a group: what they give to their owners; and over all, for the ledger.
template <class P>
struct ContactSweep {
    P x, y, torque;          // N, N, N m
    P friction, bond;        // J
    ContactVirial<P> virial; // J
};

// And what they answer.
template <bool ledger, class T, class P, class Physics>
HWY_INLINE void answer_motion(const Physics& physics, const MovedContacts<P>& moved, P owner_radius, P beta, T* HWY_RESTRICT field, T* HWY_RESTRICT rows, ContactSweep<P>& sweep) {
    using F = ContactField;
    const ContactMotion<P>& motion = moved.motion;
    const ContactRadii<P> radii{owner_radius, moved.partner_radius};
    const auto get = [&](int f) HWY_ATTR { return P::load(field + f * P::lanes); };
    const auto put = [&](int f, P value) HWY_ATTR { value.store(field + f * P::lanes); };
    P change = get(F::tangential_change), old_tangential;
    if constexpr (ledger) old_tangential = get(F::tangential(Physics::with_bonds));
    ContactLoss<P> loss;
    ContactAction<P> action;
    if constexpr (Physics::with_bonds) {
        BondState<P> bonds{get(F::bonded), beta};
        action = contact_force<ledger>(physics, motion, radii, get(F::tangential_start), change, bonds, old_tangential, loss);
        put(F::bonded, bonds.bonded);
    } else {
        NoBondState<P> none;
        action = contact_force<ledger>(physics, motion, radii, get(F::tangential_start), change, none, old_tangential, loss);
    }
    put(F::tangential_change, change);
    store_rows(action.x, action.y, action.partner_torque, P(), rows);
    sweep.x -= action.x;
    sweep.y -= action.y;
    sweep.torque += action.owner_torque;
    if constexpr (ledger) {
        put(F::tangential(Physics::with_bonds), action.tangential);
        sweep.friction += loss.friction;
        if constexpr (Physics::with_bonds) sweep.bond += loss.bond;
        sweep.virial.add(motion, radii, action);
    }
}

template <bool ledger, class T, class Physics>
HWY_INLINE void step_contacts(const Physics& physics, const CellMotion<Pack<T>>& cell, T beta_of_now, const SlotLayout& layout, const LaneWork<T>& w, ContactBooks& books) {
    using P = Pack<T>;
    constexpr bool opening = ledger && Physics::with_bonds;
    constexpr int block = ContactField::count(Physics::with_bonds, ledger) * P::lanes, put_aside = LaneWork<T>::motions * P::lanes;
    const P beta(beta_of_now);
    const std::int32_t* HWY_RESTRICT group_begin = layout.group_begin.data();
    const std::int32_t* HWY_RESTRICT partner = layout.partner.data();
    const T* HWY_RESTRICT displacement = w.displacement;
    T* HWY_RESTRICT rows = w.contact_force;
    T* HWY_RESTRICT field = w.blocks;
    const int n = w.disc_slots;
    const auto owners_of = [&](int g) HWY_ATTR {
        const T* own = w.moved + g * P::lanes;
        return Owners<P>{P::load(own), P::load(own + n), P::load(own + 2 * n), P::load(own + 3 * n)};
    };
    ContactSweep<P> sweep;
    for (int first = 0; first < layout.groups; first += w.groups_at_once) {
        const int last = std::min(first + w.groups_at_once, layout.groups);
        T* HWY_RESTRICT moving = field;
        T* HWY_RESTRICT put = w.motion;
        for (int g = first; g < last; ++g) {
            const Owners<P> own = owners_of(g);
            for (int k = group_begin[g]; k < group_begin[g + 1]; k += P::lanes, partner += P::lanes, moving += block, put += put_aside)
                put_by<opening>(move_branches(cell, own, displacement, partner, moving), put);
        }
        const T* HWY_RESTRICT motion = w.motion;
        for (int g = first; g < last; ++g) {
            const P radius = owners_of(g).radius;
            sweep.x = sweep.y = sweep.torque = P();
            for (int k = group_begin[g]; k < group_begin[g + 1]; k += P::lanes, field += block, rows += 4 * P::lanes, motion += put_aside)
                answer_motion<ledger>(physics, fetch<opening, P>(motion), radius, beta, field, rows, sweep);
            T* force = w.force + g * P::lanes;
            sweep.x.store(force);
            sweep.y.store(force + n);
            sweep.torque.store(force + 2 * n);
        }
    }
    if constexpr (ledger) {
        books.friction = sweep.friction.sum();
        books.bond = sweep.bond.sum();
        books.virial = {sweep.virial.xx.sum(), sweep.virial.yy.sum(), sweep.virial.twice_xy.sum() / 2};
    }
}

template <bool ledger, class T, class Physics>
ChunkOutcome run_lanes(const Physics& physics, const ContactLaw<double>& law, const ChunkRequest& request, AssemblyView& s, const ColumnChoice& columns,
                       const SlotLayout& layout, WorkMemory& memory) {
    using P = Pack<T>;
    StageClock<ThisLevel> clock(request.time_stages);
    LaneWork<T> w(memory, layout, columns, ledger, false);
    load_discs(s, layout, w);
    const Virial<double> at_start = load_contacts<ledger, Physics::with_bonds>(s, layout, law, w);
    ChunkOutcome outcome;
    ChunkMotion cell;
    ChunkLedger booked;
    WorkLedger work(at_start);
    Stretch stretch = request.stretch;
    // A copy, which no store to the columns can change: so the constants stay in registers.
    const farm::Physics<decltype(physics.bond), NoDamping, NoFluctuation, P> contacts{physics.contact, physics.bond, {}, {}};
    P largest_squared;
    outcome.load_seconds = clock.lap();
    for (int step = 0; step < request.substeps; ++step) {
        DiscLoss<double> of_discs;
        move_discs<ledger>(physics, layout, stretch.change(), static_cast<T>(step == 0 ? request.first_kick : request.sub_step), static_cast<T>(request.sub_step), w,
                           largest_squared, of_discs); // Eqs. (44)-(46)
        cell.advance(stretch);
        ContactBooks of_contacts;
        step_contacts<ledger>(contacts, cell.template as<Pack<T>>(), static_cast<T>(request.beta), layout, w, of_contacts); // Eqs. (5)-(7)
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
    finish(request, clock, cell, law, s, booked, std::sqrt(largest_squared.largest()), displacements_are_finite(w), outcome, [&](ChunkSums& total) {
        close_contacts<ledger, Physics::with_bonds>(cell, layout, law, w, s, request.give_back, total.contacts);
        close_discs<Physics::with_fluctuation>(request, cell, layout, w, s, total.discs);
    });
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
    s.lanes = Pack<T>::lanes;
    s.lanes_of_a_vector = Pack<T>::lanes;
    row_order<T>(s.row_of_lane);
    return s;
}

} // namespace talik::farm::inline HWY_NAMESPACE
