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

// Rows of four in vectors of this level: some rows to a vector, or two vectors to a row.
template <class T>
struct RowPack {
    static constexpr int lanes = Pack<T>::lanes;
    static constexpr int pieces = lanes >= 4 ? 1 : 4 / lanes; // vectors of a row
    // The piece `p` of a row {a, b, c, 0}, in every row of the vector.
    static Pack<T> constant(const T (&row)[4], int p) {
        alignas(64) T buffer[lanes];
        for (int k = 0; k < lanes; ++k) buffer[k] = row[(p * lanes + k) % 4];
        return Pack<T>::load(buffer);
    }
    // Of the lanes of x and y of all rows.
    static double largest_in_the_plane(Pack<T> v) {
        alignas(64) T number[lanes];
        v.store(number);
        double largest = 0;
        for (int k = 0; k < lanes; ++k)
            if (k % 4 < 2 && static_cast<double>(number[k]) > largest) largest = static_cast<double>(number[k]);
        return largest;
    }
    // x and y of each row change places; so do the other two.
    static HWY_INLINE Pack<T> swapped(Pack<T> v) {
        if constexpr (sizeof(T) == 4) return hn::Shuffle2301(v.v[0]);
        else return hn::Shuffle01(v.v[0]);
    }
};

// Sums of a sub-step that the ledger takes from the discs.
struct DiscBooks {
    double damping = 0, fluctuation_work = 0;
    Symmetric power;
};

// What is the same for all discs in a sub-step.
template <class T>
struct DiscConstants {
    static constexpr int pieces = RowPack<T>::pieces;
    Pack<T> own[pieces], shear[pieces], planar[pieces], kick, dt;

    DiscConstants(const Symmetric& d, T kick_seconds, T dt_seconds) : kick(kick_seconds), dt(dt_seconds) {
        const T own_row[4] = {static_cast<T>(d.xx), static_cast<T>(d.yy), 0, 0}, shear_row[4] = {static_cast<T>(d.xy), static_cast<T>(d.xy), 0, 0};
        const T planar_row[4] = {1, 1, 0, 0};
        for (int p = 0; p < pieces; ++p) {
            own[p] = RowPack<T>::constant(own_row, p);
            shear[p] = RowPack<T>::constant(shear_row, p);
            planar[p] = RowPack<T>::constant(planar_row, p);
        }
    }
};

// Running over the discs.
template <class T>
struct DiscSweep {
    Pack<T> largest_squared;                    // of the displacements, m^2; only the first two lanes of a row count
    Pack<T> damping, fluctuation, power, cross; // for the ledger
};

// Newton for a run of discs. What comes in to a disc is added to what its own contacts have given, by number of vectors known
// when compiled (most >= 0) or not. The sweep goes in and out by value: what is written through pointers cannot change it.
template <int most, bool ledger, class T, class Physics>
HWY_INLINE DiscSweep<T> move_run(const Physics& physics, const DiscConstants<T> c, const IncomingRun run, const std::int32_t* HWY_RESTRICT incoming,
                                 const LaneWork<T>& w, DiscSweep<T> sweep) {
    using P = Pack<T>;
    using Rows = RowPack<T>;
    constexpr int set = P::lanes >= 4 ? P::lanes / 4 : 1; // discs
    const int degree = most >= 0 ? most : run.degree;
    const T* HWY_RESTRICT rows = w.contact_force;
    const T* HWY_RESTRICT forces = w.force;
    const T* HWY_RESTRICT inverse_masses = w.inverse_mass;
    T* HWY_RESTRICT velocities = w.velocity;
    T* HWY_RESTRICT displacements = w.displacement;
    const hn::ScalableTag<T> tag;
    for (int n = 0; n < run.sets; ++n, incoming += degree * set)
        for (int p = 0; p < Rows::pieces; ++p) {
            const int k = 4 * (run.first_slot + n * set) + p * P::lanes;
            P force = P::load(forces + k);
            for (int m = 0; m < degree; ++m) force += P(load_units<P::lanes < 4 ? P::lanes : 4, 1>(tag, rows + p * P::lanes, incoming + m * set));
            const P v = P::load(velocities + k), im = P::load(inverse_masses + k), u = P::load(displacements + k);
            P damped;
            P next = kicked(physics, force, v, c.kick, im, damped);
            if constexpr (ledger) {
                if constexpr (Physics::with_damping) sweep.damping += damping_loss(force, damped, v, next, c.kick);
                sweep.power += c.planar[p] * (force * v);
                sweep.cross += c.planar[p] * (force * Rows::swapped(v));
            }
            if constexpr (Physics::with_fluctuation) { // -D v_f, the reaction to the kinetic stress
                const P lost = stretched(c.own[p], c.shear[p], v, Rows::swapped(v));
                if constexpr (ledger) sweep.fluctuation += P::load(w.mass + k) * (lost * (v + next - lost));
                next = next - lost;
            }
            next.store(velocities + k);
            const P moved = u + (stretched(c.own[p], c.shear[p], u, Rows::swapped(u)) + c.dt * next); // w <- U w + dt v_f
            moved.store(displacements + k);
            const P squared = moved * moved; // |w|^2 in the first two lanes of a row
            if (p == 0) sweep.largest_squared = larger(squared + Rows::swapped(squared), sweep.largest_squared);
        }
    return sweep;
}

// Newton for all discs: those of equal degree follow one another, so that no branch is mispredicted.
template <bool ledger, class T, class Physics>
HWY_INLINE void move_discs(const Physics& physics, const SlotLayout& layout, const Symmetric& d, T kick, T dt, const LaneWork<T>& w, Pack<T>& largest_squared,
                           DiscBooks& books) {
    const DiscConstants<T> c(d, kick, dt);
    DiscSweep<T> sweep;
    sweep.largest_squared = largest_squared;
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
        incoming += run.degree * run.sets * layout.shape.rows_of_a_vector;
    }
    largest_squared = sweep.largest_squared;
    if constexpr (ledger) {
        books.damping = sweep.damping.sum();
        books.fluctuation_work = -sweep.fluctuation.sum() / 2;
        alignas(64) T power[Pack<T>::lanes];
        sweep.power.store(power);
        double x = 0, y = 0;
        for (int k = 0; k < Pack<T>::lanes; k += 2) { // rows {x, y, 0, 0}
            x += static_cast<double>(power[k]);
            y += static_cast<double>(power[k + 1]);
        }
        books.power = {x, y, sweep.cross.sum() / 2};
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
    const hn::ScalableTag<T> d;
    [[maybe_unused]] P friction_sum, bond_sum, xx_sum, yy_sum, xy_sum;
    [[maybe_unused]] const P beta(beta_of_now);
    using F = ContactField;
    constexpr int block = F::count(Physics::with_bonds, ledger) * P::lanes;
    const std::int32_t* HWY_RESTRICT partner = layout.partner.data();
    const std::int32_t* HWY_RESTRICT own_rows = layout.own_rows.data();
    const std::int32_t* HWY_RESTRICT group_begin = layout.group_begin.data();
    const T* HWY_RESTRICT displacement = w.displacement;
    T* HWY_RESTRICT field = w.blocks;
    T* HWY_RESTRICT rows = w.contact_force;
    for (int g = 0; g < layout.groups; ++g) {
        P own_x, own_y, own_rotation;
        gather_rows(displacement, own_rows + g * P::lanes, own_x, own_y, own_rotation);
        P sum_x, sum_y, sum_torque;
        for (int k = group_begin[g]; k < group_begin[g + 1]; k += P::lanes, partner += P::lanes, field += block, rows += 4 * P::lanes) {
            P x, y, rotation;
            gather_rows(displacement, partner, x, y, rotation);
            const RelativeMotion<P> moved{x - own_x, y - own_y, rotation + own_rotation, own_rotation - rotation};
            const auto get = [&](int f) HWY_ATTR { return P::load(field + f * P::lanes); };
            const auto put = [&](int f, P value) HWY_ATTR { value.store(field + f * P::lanes); };
            const ContactStart<P> start{get(F::normal_x), get(F::normal_y), get(F::length), get(F::inverse_length), get(F::overlap), get(F::half_difference), get(F::tangential_start)};
            ContactMemory<P> memory{get(F::turn), get(F::length_change), get(F::tangential_change)};
            ContactLoss<P> loss;
            P old_tangential;
            if constexpr (ledger) old_tangential = get(F::tangential(Physics::with_bonds));
            ContactAction<P> action;
            if constexpr (Physics::with_bonds) {
                BondState<P> bonds{get(F::bonded), get(F::smaller_radius), beta};
                action = contact_step<ledger>(physics, cell, start, moved, memory, bonds, old_tangential, loss);
                put(F::bonded, bonds.bonded);
            } else {
                NoBondState<P> none;
                action = contact_step<ledger>(physics, cell, start, moved, memory, none, old_tangential, loss);
            }
            put(F::turn, memory.turn);
            put(F::length_change, memory.length_change);
            put(F::tangential_change, memory.tangential_change);
            store_rows(action.x, action.y, action.partner_torque, rows);
            sum_x -= action.x;
            sum_y -= action.y;
            sum_torque += action.owner_torque;
            if constexpr (ledger) {
                put(F::tangential(Physics::with_bonds), action.tangential);
                friction_sum += loss.friction;
                if constexpr (Physics::with_bonds) bond_sum += loss.bond;
                const P bx = action.length * action.normal_x, by = action.length * action.normal_y;
                xx_sum += action.x * bx;
                yy_sum += action.y * by;
                xy_sum += action.x * by + action.y * bx;
            }
        }
        for (int k = 0; k < vectors_of_contacts; ++k) // in the order of the discs
            hn::StoreInterleaved4(sum_x.v[k], sum_y.v[k], sum_torque.v[k], hn::Zero(d), d, w.force + 4 * (g * P::lanes + k * Pack<T>::lanes));
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
        for (int a = 0; a < 3; ++a) w.force[4 * k + a] = sum[a];
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
        DiscBooks of_discs;
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
            work.sub_step(stretch.change(), stretch.change_seen_from_the_end(), of_contacts.virial, of_discs.power, request.sub_step, booked);
        }
        outcome.strain += stretch.largest_strain();
        outcome.last_stretch = stretch;
        stretch.turn_with_the_frame();
    }
    outcome.stretch = stretch;
    const double largest = RowPack<T>::largest_in_the_plane(largest_squared);
    finish(request, clock, cell, law, layout, w, s, booked, std::sqrt(largest), true, outcome);
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
    s.rows_of_a_vector = Pack<T>::lanes >= 4 ? Pack<T>::lanes / 4 : 1;
    row_order<T, vectors_of_contacts>(s.row_of_lane);
    return s;
}

} // namespace talik::farm::inline HWY_NAMESPACE
