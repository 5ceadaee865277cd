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
          discs_(rve.size.disc_slots()), contacts_(rve.size.contact_slots),
          group_begin_(rve.group_begin), dt_(Real(task.request.sub_step)), beta_(Real(task.request.beta)), own_(team) {
        s_.numbers = const_cast<AssemblyNumbers*>(&task.numbers); // read only
    }

    TALIK_BLOCK void run(BlockResult& result) {
        team_.phase([&](int thread) { load(thread); });
        for (int step = 0; step < request_.substeps; ++step) {
            const Real kick = step == 0 ? Real(request_.first_kick) : dt_;
            team_.phase([&](int thread) { move_discs(thread, kick); });  // Eqs. (44)-(46)
            team_.phase([&](int thread) { step_contacts(thread); });     // Eqs. (5)-(7)
        }
        judge();
        if (shared_.accepted) close();
        team_.phase([&](int thread) { report(thread, result); });
    }

private:
    // What a thread keeps to itself.
    struct Own {
        WorkLedger work;
        ChunkLedger booked;
        Symmetric power;
        Real largest_squared = 0; // displacement of any of its discs, m^2
    };

    // The thread that does what is to be done once: of the last warp, which has the fewest discs.
    TALIK_BLOCK bool is_single(int thread) const { return thread == threads_ - 32; }
    TALIK_BLOCK Real mass_of(Real inverse_mass) const { return inverse_mass > Real(0) ? Real(1) / inverse_mass : Real(0); }

    TALIK_BLOCK void take_stretch() {
        const Symmetric change = shared_.stretch.change();
        shared_.discs = {Real(change.xx), Real(change.yy), Real(change.xy)};
    }

    // body(contact slot) for the contacts that the disc of a slot owns, in their order.
    template <class Body>
    TALIK_BLOCK void each_owned(int k, Body&& body) const {
        const int group = k / block_group, end = group_begin_[group + 1];
        for (int c = group_begin_[group] + k % block_group; c < end; c += block_group) body(c);
    }
    TALIK_BLOCK void add_incoming(int k, Real (&force)[3]) const {
        for (int m = w_.incoming_begin[k], end = w_.incoming_begin[k + 1]; m < end; ++m) {
            const int c = w_.incoming[m];
            for (int a = 0; a < 3; ++a) force[a] += w_.contact_force[a * contacts_ + c];
        }
    }
    TALIK_BLOCK RelativeMotion<Real> moved(const BlockRow<Real>& owner, const BlockRow<Real>& partner) const {
        return {partner.x - owner.x, partner.y - owner.y, owner.turn + partner.turn, owner.turn - partner.turn};
    }
    TALIK_BLOCK Real& start(int field, int c) const { return w_.start[field * contacts_ + c]; }
    TALIK_BLOCK Real& memory(int field, int c) const { return w_.memory[field * contacts_ + c]; }

    TALIK_BLOCK void load(int thread) {
        for (int m = thread; m < rve_.size.incoming; m += threads_) w_.incoming[m] = rve_.incoming[m];
        for (int k = thread; k <= discs_; k += threads_) w_.incoming_begin[k] = rve_.incoming_begin[k];
        Virial<double> virial;
        for (int k = thread; k < discs_; k += threads_) {
            load_disc(k);
            Real force[3] = {0, 0, 0};
            each_owned(k, [&](int c) { load_contact(c, force, virial); });
            for (int a = 0; a < 3; ++a) w_.force[a * discs_ + k] = force[a];
        }
        if constexpr (ledger) own_(thread).work = WorkLedger(virial);
        if (!is_single(thread)) return;
        shared_.motion = ChunkMotion();
        shared_.stretch = shared_.last_stretch = request_.stretch;
        take_stretch();
    }
    TALIK_BLOCK void load_disc(int k) const {
        const int i = rve_.disc[k];
        const DiscAtStart at = i < 0 ? DiscAtStart{} : disc_at_start(s_, i);
        w_.displacement[k] = {0, 0, 0, i < 0 ? Real(0) : Real(s_.radius[i])};
        w_.velocity[k] = Real(at.velocity_x);
        w_.velocity[discs_ + k] = Real(at.velocity_y);
        w_.velocity[2 * discs_ + k] = Real(at.spin);
        w_.inverse_mass[k] = Real(at.inverse_mass);
        w_.inverse_mass[discs_ + k] = Real(at.inverse_inertia);
    }
    TALIK_BLOCK void load_contact(int c, Real (&force)[3], Virial<double>& virial) const {
        const int contact = rve_.contact[c];
        const ContactAtStart at = contact < 0 ? ContactAtStart::inert() : contact_at_start(s_, contact, rve_.turned[c] != 0, law_);
        w_.partner[c] = rve_.partner[c];
        start(0, c) = Real(at.start.normal_x), start(1, c) = Real(at.start.normal_y);
        start(2, c) = Real(at.start.inverse_length), start(3, c) = Real(at.start.overlap), start(4, c) = Real(at.tangential);
        for (int field = 0; field < 3; ++field) memory(field, c) = 0;
        if constexpr (bonds) memory(BlockWork<Real>::bonded, c) = at.bonded ? 1 : 0;
        if constexpr (ledger) {
            memory(BlockWork<Real>::tangential(bonds), c) = Real(at.tangential);
            const Virial<double> own = at.virial();
            virial.xx += own.xx, virial.yy += own.yy, virial.xy += own.xy;
        }
        w_.contact_force[c] = Real(at.force_x);
        w_.contact_force[contacts_ + c] = Real(at.force_y);
        w_.contact_force[2 * contacts_ + c] = Real(at.partner_torque);
        force[0] -= Real(at.force_x), force[1] -= Real(at.force_y), force[2] += Real(at.owner_torque);
    }

    // Reads the forces of the last phase and its own discs; writes its own discs.
    TALIK_BLOCK void move_discs(int thread, Real kick) {
        const PlanarStretch<Real> d = shared_.discs;
        Real largest = own_(thread).largest_squared;
        DiscLoss<double> loss;
        for (int k = thread; k < discs_; k += threads_) {
            Real force[3] = {w_.force[k], w_.force[discs_ + k], w_.force[2 * discs_ + k]};
            add_incoming(k, force);
            const Real im = w_.inverse_mass[k];
            const Real inverse_mass[3] = {im, im, w_.inverse_mass[discs_ + k]};
            Real v[3] = {w_.velocity[k], w_.velocity[discs_ + k], w_.velocity[2 * discs_ + k]};
            BlockRow<Real> row = w_.displacement[k];
            Real u[3] = {row.x, row.y, row.turn};
            const Real mass = ledger && Physics::with_fluctuation ? mass_of(im) : Real(0);
            disc_step<ledger>(physics_, d, kick, dt_, force, inverse_mass, mass, v, u, loss);
            for (int a = 0; a < 3; ++a) w_.velocity[a * discs_ + k] = v[a];
            w_.displacement[k] = {u[0], u[1], u[2], row.radius};
            largest = larger(largest, u[0] * u[0] + u[1] * u[1]);
        }
        own_(thread).largest_squared = largest;
        if constexpr (ledger) {
            own_(thread).booked.damping += loss.damping;
            own_(thread).booked.work += loss.fluctuation_work;
            own_(thread).power = {loss.power_xx, loss.power_yy, loss.twice_power_xy / 2};
        }
        if (!is_single(thread)) return;
        shared_.motion.advance(shared_.stretch);
        shared_.cell = shared_.motion.template as<Real>();
        if constexpr (ledger) {
            shared_.change = shared_.stretch.change();
            shared_.gained = shared_.stretch.change_seen_from_the_end();
        }
    }

    // Reads all displacements; writes the contacts that its discs own, and what these give to both ends.
    TALIK_BLOCK void step_contacts(int thread) {
        const CellMotion<Real> cell = shared_.cell;
        ContactLoss<Real> sum{0, 0};
        ContactVirial<Real> virial;
        for (int k = thread; k < discs_; k += threads_) {
            const BlockRow<Real> owner = w_.displacement[k];
            Real force[3] = {0, 0, 0};
            each_owned(k, [&](int c) { step_contact(cell, owner, c, force, sum, virial); });
            for (int a = 0; a < 3; ++a) w_.force[a * discs_ + k] = force[a];
        }
        if constexpr (ledger) {
            Own& own = own_(thread);
            own.booked.friction += sum.friction;
            own.booked.bond += sum.bond;
            own.work.sub_step(shared_.change, shared_.gained, {virial.xx, virial.yy, virial.twice_xy / 2}, own.power, request_.sub_step, own.booked);
        }
        if (!is_single(thread)) return;
        shared_.last_stretch = shared_.stretch;
        shared_.stretch.turn_with_the_frame();
        take_stretch();
    }
    TALIK_BLOCK void step_contact(const CellMotion<Real>& cell, const BlockRow<Real>& owner, int c, Real (&force)[3], ContactLoss<Real>& sum, ContactVirial<Real>& virial) const {
        using W = BlockWork<Real>;
        const BlockRow<Real> partner = w_.displacement[w_.partner[c]];
        const ContactStart<Real> at{start(0, c), start(1, c), start(2, c), start(3, c)};
        const ContactRadii<Real> radii{owner.radius, partner.radius};
        ContactMemory<Real> memory_of_contact{memory(W::turn, c), memory(W::elongation, c)};
        Real old_tangential = 0;
        if constexpr (ledger) old_tangential = memory(W::tangential(bonds), c);
        ContactLoss<Real> loss{0, 0};
        const ContactMotion<Real> motion = contact_motion(cell, at, radii, moved(owner, partner), memory_of_contact);
        Real& change = memory(W::tangential_change, c);
        ContactAction<Real> action;
        if constexpr (bonds) {
            BondState<Real> bond{memory(W::bonded, c), beta_};
            action = contact_force<ledger>(physics_, motion, radii, start(4, c), change, bond, old_tangential, loss);
            memory(W::bonded, c) = bond.bonded;
        } else {
            NoBondState<Real> none;
            action = contact_force<ledger>(physics_, motion, radii, start(4, c), change, none, old_tangential, loss);
        }
        memory(W::turn, c) = memory_of_contact.turn;
        memory(W::elongation, c) = memory_of_contact.elongation;
        w_.contact_force[c] = action.x;
        w_.contact_force[contacts_ + c] = action.y;
        w_.contact_force[2 * contacts_ + c] = action.partner_torque;
        force[0] -= action.x, force[1] -= action.y, force[2] += action.owner_torque;
        if constexpr (ledger) {
            memory(W::tangential(bonds), c) = action.tangential;
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
                const BlockRow<Real> row = w_.displacement[k];
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
                Real force[3] = {w_.force[k], w_.force[discs_ + k], w_.force[2 * discs_ + k]};
                add_incoming(k, force);
                const BlockRow<Real> row = w_.displacement[k];
                const DiscAtEnd<Real> at{row.x, row.y, w_.velocity[k], w_.velocity[discs_ + k], w_.velocity[2 * discs_ + k], force[0], force[1], force[2]};
                close_disc(shared_.motion, at, last_sub_step, Physics::with_fluctuation, s_, i, request_.give_back, own.discs, own.largest_drift_squared);
            }
        });
        team_.phase([&](int thread) { reinterpret_cast<ChunkSums*>(w_.scratch)[thread] = sums(thread); });
    }
    TALIK_BLOCK void close_owned(const CellMotion<Real>& e, int k, int c, ContactSums& sums) {
        const int contact = rve_.contact[c];
        if (contact < 0) return;
        const BlockRow<Real> owner = w_.displacement[k], partner = w_.displacement[w_.partner[c]];
        bool bonded = false;
        if constexpr (bonds) bonded = memory(BlockWork<Real>::bonded, c) > Real(0);
        const ContactAtEnd<Real> at{start(0, c), start(1, c), start(2, c), start(3, c), {owner.radius, partner.radius},
                                    memory(BlockWork<Real>::tangential_change, c), bonded, moved(owner, partner)};
        close_contact(e, law_, at, s_, contact, request_.give_back, sums);
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
    const int threads_, discs_, contacts_;
    const std::int32_t* const group_begin_; // with dt and beta: in registers, where all else is looked up when it is needed
    const Real dt_, beta_;
    typename Team::template Privates<Own> own_;
};

} // namespace talik::farm
