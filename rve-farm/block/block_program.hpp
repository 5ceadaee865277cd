#pragma once
// The program of a thread block: a chunk of one RVE from its master state and back, in one launch. Two phases to a sub-step:
// every thread moves its discs, then takes the contacts that they own. A disc's own side of a contact is its thread's business;
// what goes to the partner lies in memory, and the partner pulls it in the next phase, in a fixed order. The same text runs on a
// GPU and on a CPU, where the threads of a phase are visited in scrambled order (block_team.hpp).
#include "common/team/block_team.hpp"
#include "rve-farm/block/block_work.hpp"
#include "rve-farm/physics/physics.hpp"

namespace talik::farm {

template <bool ledger_, class Real, class Physics, class Team>
class BlockProgram {
public:
    static constexpr bool bonds = Physics::with_bonds, ledger = ledger_;

    TALIK_BLOCK BlockProgram(const Team& team, const BlockTask& task, const BlockRve& rve, const Physics& physics, const ContactLaw<double>& law, const BlockWork<Real>& w)
        : team_(team), request_(task.request), rve_(rve), physics_(physics), law_(law), w_(w), shared_(*w.uniforms), s_(rve.view), threads_(team.threads()),
          discs_(rve.size.disc_slots()), dt_(Real(task.request.sub_step)), beta_(Real(task.request.beta)), own_(team) {
        s_.numbers = const_cast<AssemblyNumbers*>(&task.numbers); // read only
    }

    TALIK_BLOCK void run(BlockResult& result) {
        team_.phase([&](int thread) { load_list(thread); });
        team_.phase([&](int thread) { load(thread); });
        const int substeps = request_.substeps;
        for (int step = 0; step < substeps; ++step) {
            const Real kick = step == 0 ? Real(request_.first_kick) : dt_;
            const bool is_last = step + 1 == substeps;
            team_.phase([&](int thread) { move_discs(thread, kick, is_last); }); // Eqs. (44)-(46)
            team_.phase([&](int thread) { step_contacts(thread); });             // Eqs. (5)-(7)
        }
        judge();
        if (shared_.accepted) close();
        team_.phase([&](int thread) { report(thread, result); });
    }

private:
    // What a thread keeps to itself.
    struct Own {
        ChunkLedger booked;
        Real largest_squared = 0; // displacement of any of its discs, m^2
    };

    // The thread that does what is to be done once: of the last warp, which has the fewest discs.
    TALIK_BLOCK bool is_single(int thread) const { return thread == threads_ - 32; }
    TALIK_BLOCK Real mass_of(Real inverse_mass) const { return inverse_mass > Real(0) ? Real(1) / inverse_mass : Real(0); }

    TALIK_BLOCK static PlanarStretch<Real> in_short(const Symmetric& d) { return {Real(d.xx), Real(d.yy), Real(d.xy)}; }

    // The work of WorkLedger, -[V_old : (U - I) + V_new : (I - U^-1) - dt sum F . (I - U^-1) v] / 2 of every sub-step, sorted by virials: each
    // counts for the gain of its own sub-step and the change of the next, which are the same for all threads. J.
    TALIK_BLOCK static Real contract(const PlanarStretch<Real>& d, Real xx, Real yy, Real twice_xy) { return d.xx * xx + d.yy * yy + d.xy * twice_xy; }

    // body(contact slot) for the contacts that the disc of a slot owns, in their order.
    template <class Body>
    TALIK_BLOCK void each_owned(int k, Body&& body) const {
        const std::int32_t* begin = w_.group_begin + k / block_group;
        for (int c = begin[0] + k % block_group, end = begin[1]; c < end; c += block_group) body(c);
    }
    TALIK_BLOCK void add_incoming(int k, BlockForce<Real>& force) const {
        TALIK_SHORT_LOOP
        for (int m = w_.incoming_begin[k], end = w_.incoming_begin[k + 1]; m < end; ++m) {
            const BlockAction<Real> action = w_.action.at(w_.incoming[m]);
            force.x += action.x, force.y += action.y, force.torque += action.torque;
        }
    }
    TALIK_BLOCK static void add_owned(BlockForce<Real>& force, Real x, Real y, Real torque) { force.x -= x, force.y -= y, force.torque += torque; }
    TALIK_BLOCK RelativeMotion<Real> moved(const BlockRow<Real>& owner, const BlockRow<Real>& partner) const {
        return {partner.x - owner.x, partner.y - owner.y, owner.turn + partner.turn, owner.turn - partner.turn};
    }

    TALIK_BLOCK void load_list(int thread) {
        for (int g = thread; g <= rve_.size.groups; g += threads_) w_.group_begin[g] = rve_.group_begin[g];
        for (int m = thread; m < rve_.size.incoming; m += threads_) w_.incoming[m] = rve_.incoming[m];
        for (int k = thread; k <= discs_; k += threads_) w_.incoming_begin[k] = rve_.incoming_begin[k];
    }
    TALIK_BLOCK void load(int thread) {
        Virial<double> virial;
        for (int k = thread; k < discs_; k += threads_) {
            const int i = rve_.disc[k];
            const bool there = i >= 0;
            const double inverse_mass = there ? 1 / s_.mass[i] : 0;
            BlockForce<Real> force{0, 0, 0, 0};
            each_owned(k, [&](int c) { load_contact(c, force, virial); });
            w_.displacement.put(k, {0, 0, 0, there ? Real(s_.radius[i]) : Real(0)});
            if (there) w_.motion.put(k, {Real(s_.velocity_x[i]), Real(s_.velocity_y[i]), Real(s_.spin[i]), Real(inverse_mass)});
            else w_.motion.put(k, {0, 0, 0, 0});
            w_.force.put(k, force);
            w_.inverse_inertia[k] = there ? Real(inverse_inertia(inverse_mass, s_.radius[i])) : Real(0);
        }
        const PlanarStretch<Real> change = in_short(request_.stretch.change());
        if (ledger && request_.substeps > 0) own_(thread).booked.work = -contract(change, Real(virial.xx), Real(virial.yy), Real(2 * virial.xy)) / 2;
        if (!is_single(thread)) return;
        shared_.motion = ChunkMotion();
        shared_.stretch = shared_.last_stretch = request_.stretch;
        shared_.discs = change;
        shared_.gained = {0, 0, 0};
    }
    TALIK_BLOCK void load_contact(int c, BlockForce<Real>& force, Virial<double>& virial) const {
        const int contact = rve_.contact[c];
        const StoredContact<double, bool> stored = contact < 0 ? inert_contact() : stored_contact(s_, contact, rve_.turned[c] != 0);
        const ContactAtStart<double> at = contact_at_start(stored, law_);
        w_.partner[c] = rve_.partner[c];
        w_.start.put(c, {Real(at.start.normal_x), Real(at.start.normal_y), Real(at.start.inverse_length), Real(at.start.overlap)});
        w_.memory.put(c, {0, 0, 0, Real(at.tangential)});
        w_.action.put(c, {Real(at.force_x), Real(at.force_y), Real(at.partner_torque), Real(at.tangential)});
        if constexpr (bonds) w_.bonded[c] = stored.bonded ? 1 : 0;
        if constexpr (ledger) virial.add_contact(at.force_x, at.force_y, stored.x, stored.y);
        add_owned(force, Real(at.force_x), Real(at.force_y), Real(at.owner_torque));
    }

    // Reads the forces of the last phase and its own discs; writes its own discs.
    TALIK_BLOCK void move_discs(int thread, Real kick, bool is_last) {
        const PlanarStretch<Real> d = shared_.discs;
        Real largest = own_(thread).largest_squared;
        DiscLoss<Real> loss;
        for (int k = thread; k < discs_; k += threads_) {
            BlockForce<Real> sum = w_.force.at(k);
            add_incoming(k, sum);
            const BlockMotion<Real> motion = w_.motion.at(k);
            const BlockRow<Real> row = w_.displacement.at(k);
            const Real im = motion.inverse_mass, mass = ledger && Physics::with_fluctuation ? mass_of(im) : Real(0);
            const Real force[3] = {sum.x, sum.y, sum.torque}, inverse_mass[3] = {im, im, w_.inverse_inertia[k]};
            Real v[3] = {motion.x, motion.y, motion.spin}, u[3] = {row.x, row.y, row.turn};
            disc_step<ledger>(physics_, d, kick, dt_, force, inverse_mass, mass, v, u, loss);
            w_.motion.put(k, {v[0], v[1], v[2], im});
            w_.displacement.put(k, {u[0], u[1], u[2], row.radius});
            largest = larger(largest, u[0] * u[0] + u[1] * u[1]);
        }
        own_(thread).largest_squared = largest;
        if constexpr (ledger) {
            own_(thread).booked.damping += loss.damping;
            own_(thread).booked.work += loss.fluctuation_work + dt_ * contract(shared_.gained, loss.power_xx, loss.power_yy, loss.twice_power_xy) / 2;
        }
        if (!is_single(thread)) return;
        shared_.motion.advance(shared_.stretch);
        shared_.cell = shared_.motion.template as<Real>();
        shared_.next_stretch = shared_.stretch;
        shared_.next_stretch.turn_with_the_frame();
        if constexpr (ledger) {
            const Symmetric gained = shared_.stretch.change_seen_from_the_end(), change = shared_.next_stretch.change();
            shared_.next_gained = in_short(gained);
            shared_.counted = is_last ? shared_.next_gained : in_short({gained.xx + change.xx, gained.yy + change.yy, gained.xy + change.xy});
        }
    }

    // Reads all displacements; writes the contacts that its discs own, and what these give to both ends.
    TALIK_BLOCK void step_contacts(int thread) {
        const CellMotion<Real> cell = shared_.cell;
        ContactLoss<Real> sum{0, 0};
        ContactVirial<Real> virial;
        for (int k = thread; k < discs_; k += threads_) {
            const BlockRow<Real> owner = w_.displacement.at(k);
            BlockForce<Real> force{0, 0, 0, 0};
            each_owned(k, [&](int c) { step_contact(cell, owner, c, force, sum, virial); });
            w_.force.put(k, force);
        }
        if constexpr (ledger) {
            ChunkLedger& booked = own_(thread).booked;
            booked.friction += sum.friction;
            if constexpr (bonds) booked.bond += sum.bond;
            booked.work -= contract(shared_.counted, virial.xx, virial.yy, virial.twice_xy) / 2;
        }
        if (!is_single(thread)) return;
        shared_.last_stretch = shared_.stretch;
        shared_.stretch = shared_.next_stretch;
        shared_.discs = in_short(shared_.stretch.change());
        if constexpr (ledger) shared_.gained = shared_.next_gained;
    }
    TALIK_BLOCK void step_contact(const CellMotion<Real>& cell, const BlockRow<Real>& owner, int c, BlockForce<Real>& force, ContactLoss<Real>& sum, ContactVirial<Real>& virial) const {
        const BlockRow<Real> partner = w_.displacement.at(w_.partner[c]);
        const BlockMemory<Real> memory = w_.memory.at(c);
        const ContactRadii<Real> radii{owner.radius, partner.radius};
        ContactMemory<Real> memory_of_motion{memory.turn, memory.elongation};
        Real change = memory.tangential_change, old_tangential = 0;
        if constexpr (ledger) old_tangential = w_.action.at(c).tangential;
        ContactLoss<Real> loss{0, 0};
        const ContactMotion<Real> motion = contact_motion(cell, w_.start.at(c), radii, moved(owner, partner), memory_of_motion);
        ContactAction<Real> action;
        if constexpr (bonds) {
            BondState<Real> bond{Real(w_.bonded[c]), beta_};
            action = contact_force<ledger>(physics_, motion, radii, memory.tangential_start, change, bond, old_tangential, loss);
            w_.bonded[c] = bond.bonded > Real(0);
        } else {
            NoBondState<Real> none;
            action = contact_force<ledger>(physics_, motion, radii, memory.tangential_start, change, none, old_tangential, loss);
        }
        w_.memory.put(c, {memory_of_motion.turn, memory_of_motion.elongation, change, memory.tangential_start});
        w_.action.put(c, {action.x, action.y, action.partner_torque, action.tangential});
        add_owned(force, action.x, action.y, action.owner_torque);
        if constexpr (ledger) {
            sum.friction += loss.friction;
            if constexpr (bonds) sum.bond += loss.bond;
            virial.add(motion, radii, action);
        }
    }

    // Is it sound, has the list held?
    TALIK_BLOCK void judge() {
        team_.phase([&](int thread) {
            Real sum = 0;
            for (int k = thread; k < discs_; k += threads_) {
                const BlockRow<Real> row = w_.displacement.at(k);
                sum += (row.x + row.y + row.turn) * Real(0); // 0, or not a number
            }
            w_.verdicts[thread] = own_(thread).largest_squared + sum;
        });
        team_.phase([&](int thread) {
            if (!is_single(thread)) return;
            Real largest = 0, sum = 0;
            for (int t = 0; t < threads_; ++t) {
                largest = larger(w_.verdicts[t], largest);
                sum += w_.verdicts[t] * Real(0);
            }
            shared_.finite = sum == Real(0);
            shared_.largest_displacement = std::sqrt(static_cast<double>(largest));
            shared_.accepted = shared_.finite && (request_.substeps == 0 || shared_.largest_displacement <= request_.displacement_allowed);
        });
    }

    // The state given back, and what each thread has to say of it.
    TALIK_BLOCK void close() {
        typename Team::template Privates<ChunkSums> sums(team_);
        const CellMotion<Real> e = shared_.motion.template as<Real>();
        const double last_sub_step = request_.substeps > 0 ? request_.sub_step : s_.numbers->last_sub_step;
        team_.phase([&](int thread) {
            ChunkSums& own = sums(thread);
            own.ledger = own_(thread).booked;
            for (int k = thread; k < discs_; k += threads_) {
                const int i = rve_.disc[k];
                if (i < 0) continue;
                each_owned(k, [&](int c) { close_owned(e, k, c, own.contacts); });
                BlockForce<Real> force = w_.force.at(k);
                add_incoming(k, force);
                const BlockRow<Real> row = w_.displacement.at(k);
                const BlockMotion<Real> motion = w_.motion.at(k);
                const DiscAtEnd<Real> at{row.x, row.y, motion.x, motion.y, motion.spin, force.x, force.y, force.torque};
                close_disc(shared_.motion, at, last_sub_step, Physics::with_fluctuation, s_, i, request_.give_back, own.discs);
            }
        });
        team_.phase([&](int thread) { reinterpret_cast<ChunkSums*>(w_.scratch)[thread] = sums(thread); });
    }
    TALIK_BLOCK void close_owned(const CellMotion<Real>& e, int k, int c, ContactSums<double>& sums) {
        const int contact = rve_.contact[c];
        if (contact < 0) return;
        const BlockRow<Real> owner = w_.displacement.at(k), partner = w_.displacement.at(w_.partner[c]);
        bool bonded = false;
        if constexpr (bonds) bonded = w_.bonded[c] != 0;
        const ContactAtEnd<Real> at{w_.start.at(c), {owner.radius, partner.radius}, w_.memory.at(c).tangential_change, moved(owner, partner)};
        close_contact(e, law_, at, bonded, s_, contact, request_.give_back, sums);
    }

    // Sums in the order of the threads, each by one of them.
    TALIK_BLOCK void report(int thread, BlockResult& result) {
        if (shared_.accepted) {
            double* total = reinterpret_cast<double*>(&result.sums);
            for (int n = thread; n < BlockScratch::sums; n += threads_) {
                const bool is_drift = n == BlockScratch::sums - 1; // the largest, not the sum
                double sum = 0;
                for (int t = 0; t < threads_; ++t) {
                    const double value = w_.scratch[t * BlockScratch::sums + n];
                    sum = is_drift ? larger(sum, value) : sum + value;
                }
                total[n] = sum;
            }
        }
        if (!is_single(thread)) return;
        result.accepted = shared_.accepted;
        result.finite = shared_.finite;
        result.largest_displacement = shared_.largest_displacement;
        result.cell = shared_.motion;
        result.stretch = shared_.stretch;
        result.last_stretch = shared_.last_stretch;
    }

    const Team& team_;
    const ChunkRequest& request_;
    const BlockRve& rve_;
    const Physics& physics_;
    const ContactLaw<double>& law_;
    const BlockWork<Real>& w_;
    BlockUniforms<Real>& shared_;
    AssemblyView s_;
    const int threads_, discs_;
    const Real dt_, beta_; // in registers, where all else is looked up when it is needed
    typename Team::template Privates<Own> own_;
};

} // namespace talik::farm
