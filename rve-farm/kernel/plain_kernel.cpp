// The plain kernel: the phases of a sub-step on a team, one slot after the other.
#include "rve-farm/kernel/chunk.hpp"
#include "rve-farm/kernel/disc_step.hpp"
#include "rve-farm/kernel/plain_ends.hpp"
#include "rve-farm/physics/physics_choice.hpp"
#include "rve-farm/kernel/plain_kernel.hpp"

namespace talik::farm {
namespace {

struct Plain {}; // Level tag

template <bool ledger, class Real, class Physics>
void move_disc(const Physics& physics, const SlotLayout& layout, const PlanarStretch<Real>& d, Real kick, Real dt, Work<Real, Plain>& w, int k) {
    Real force[3] = {0, 0, 0};
    add_owned(w, layout, k, force);
    add_incoming(w, layout, k, force);
    const int n = w.disc_slots;
    Real *velocity = w.velocity + k, *row = w.displacement + layout.own_rows[static_cast<std::size_t>(k)];
    const Real* im = w.inverse_mass + k;
    Real v[3] = {velocity[0], velocity[n], velocity[2 * n]}, u[3] = {row[0], row[1], row[2]};
    DiscLoss<double> loss;
    disc_step<ledger>(physics, d, kick, dt, force, {im[0], im[0], im[n]}, w.mass ? w.mass[k] : Real(0), v, u, loss);
    for (int a = 0; a < 3; ++a) velocity[a * n] = v[a], row[a] = u[a];
    if constexpr (ledger) {
        double* booked = w.booked + Work<Real, Plain>::booked_columns * k;
        booked[0] = loss.damping, booked[1] = loss.fluctuation_work;
        booked[2] = loss.power_xx, booked[3] = loss.power_yy, booked[4] = loss.twice_power_xy / 2;
    }
}

template <bool ledger, class Real, class Physics>
void step_contact(const Physics& physics, const SlotLayout& layout, const CellMotion<Real>& cell, Real beta, Work<Real, Plain>& w, int k) {
    const auto slot = static_cast<std::size_t>(k);
    using F = ContactField;
    Real* field = w.contact(k);
    const int lanes = w.lanes();
    const Real* wi = w.displacement + layout.owner[slot];
    const Real* wj = w.displacement + layout.partner[slot];
    const ContactStart<Real> start{field[F::normal_x * lanes], field[F::normal_y * lanes], field[F::inverse_length * lanes], field[F::overlap * lanes]};
    const ContactRadii<Real> radii{wi[3], wj[3]};
    const RelativeMotion<Real> moved{wj[0] - wi[0], wj[1] - wi[1], wi[2] + wj[2], wi[2] - wj[2]};
    ContactMemory<Real> memory{field[F::turn * lanes], field[F::elongation * lanes]};
    const Real tangential_start = field[F::tangential_start * lanes];
    Real& tangential_change = field[F::tangential_change * lanes];
    ContactLoss<Real> loss{0, 0};
    Real old_tangential = 0;
    if constexpr (ledger) old_tangential = field[F::tangential(Physics::with_bonds) * lanes];
    const ContactMotion<Real> motion = contact_motion(cell, start, radii, moved, memory);
    ContactAction<Real> action;
    if constexpr (Physics::with_bonds) {
        BondState<Real> bonds{field[F::bonded * lanes], beta};
        action = contact_force<ledger>(physics, motion, radii, tangential_start, tangential_change, bonds, old_tangential, loss);
        field[F::bonded * lanes] = bonds.bonded;
    } else {
        NoBondState<Real> none;
        action = contact_force<ledger>(physics, motion, radii, tangential_start, tangential_change, none, old_tangential, loss);
    }
    field[F::turn * lanes] = memory.turn;
    field[F::elongation * lanes] = memory.elongation;
    Real* row = w.contact_force + layout.row[slot];
    row[0] = action.x;
    row[1] = action.y;
    row[2] = action.partner_torque;
    row[3] = action.owner_torque;
    if constexpr (ledger) {
        field[F::tangential(Physics::with_bonds) * lanes] = action.tangential;
        double* booked = w.booked + Work<Real, Plain>::booked_columns * k;
        ContactVirial<double> virial;
        virial.add(motion, radii, action);
        booked[0] = loss.friction, booked[1] = loss.bond;
        booked[2] = virial.xx, booked[3] = virial.yy, booked[4] = virial.twice_xy / 2;
    }
}

template <class Real>
void sum_booked(const Work<Real, Plain>& w, int slots, double (&sums)[Work<Real, Plain>::booked_columns]) {
    for (double& sum : sums) sum = 0;
    for (int k = 0; k < slots; ++k)
        for (int a = 0; a < Work<Real, Plain>::booked_columns; ++a) sums[a] += w.booked[Work<Real, Plain>::booked_columns * k + a];
}

template <bool ledger, class Real, class Team, class Physics>
ChunkOutcome run_phases(const Team& team, const Physics& physics, const ContactLaw<double>& law, const ChunkRequest& request, AssemblyView& s,
                        const ColumnChoice& columns, const SlotLayout& layout, WorkMemory& memory) {
    StageClock<Plain> clock(request.time_stages);
    Work<Real, Plain> w(memory, layout, columns, ledger, true);
    load_discs(team, s, layout, w);
    load_contacts(team, s, layout, law, w);
    ChunkOutcome outcome;
    ChunkMotion cell;
    ChunkLedger booked;
    WorkLedger work(ledger ? virial_at_start(w, layout) : Virial<double>{});
    Stretch stretch = request.stretch;
    const Real dt = Real(request.sub_step), beta = Real(request.beta);
    double sums[Work<Real, Plain>::booked_columns], largest_squared = 0;
    outcome.load_seconds = clock.lap();
    for (int step = 0; step < request.substeps; ++step) {
        const Symmetric change = stretch.change();
        const PlanarStretch<Real> d{Real(change.xx), Real(change.yy), Real(change.xy)};
        const Real kick = Real(step == 0 ? request.first_kick : request.sub_step);
        team.each(w.disc_slots, [&](int k) { move_disc<ledger>(physics, layout, d, kick, dt, w, k); }); // Eqs. (44)-(46)
        for (int k = 0; k < w.disc_slots; ++k) {
            const Real *row = w.displacement + layout.own_rows[static_cast<std::size_t>(k)], x = row[0], y = row[1];
            largest_squared = larger(largest_squared, static_cast<double>(x * x + y * y));
        }
        Symmetric power;
        if constexpr (ledger) {
            sum_booked(w, w.disc_slots, sums);
            booked.damping += sums[0], booked.work += sums[1];
            power = {sums[2], sums[3], sums[4]};
        }
        cell.advance(stretch);
        const CellMotion<Real> e = cell.template as<Real>();
        team.each(w.contact_slots, [&](int k) { step_contact<ledger>(physics, layout, e, beta, w, k); }); // Eqs. (5)-(7)
        if constexpr (ledger) {
            sum_booked(w, w.contact_slots, sums);
            booked.friction += sums[0], booked.bond += sums[1];
            work.sub_step(change, stretch.change_seen_from_the_end(), {sums[2], sums[3], sums[4]}, power, request.sub_step, booked);
        }
        outcome.strain += stretch.largest_strain();
        outcome.last_stretch = stretch;
        stretch.turn_with_the_frame();
    }
    outcome.stretch = stretch;
    finish(request, clock, cell, law, s, booked, std::sqrt(largest_squared), displacements_are_finite(w), outcome, [&](ChunkSums& total) {
        close_contacts(cell, layout, law, w, s, request.give_back, total.contacts);
        close_discs(request, cell, layout, w, s, total.discs);
    });
    return outcome;
}

template <class Real, class Team>
ChunkOutcome run_plain(const Team& team, const RveParameters& parameters, const ChunkRequest& request, AssemblyView& s, const ColumnChoice& columns,
                       const SlotLayout& layout, WorkMemory& memory) {
    ChunkOutcome outcome;
    with_physics<Real>(parameters, [&](const auto& physics) {
        const ContactLaw<double> law = contact_law_of(parameters);
        outcome = request.ledger ? run_phases<true, Real>(team, physics, law, request, s, columns, layout, memory)
                                 : run_phases<false, Real>(team, physics, law, request, s, columns, layout, memory);
    });
    return outcome;
}

} // namespace

ChunkOutcome run_plain_double(const RveParameters& p, const ChunkRequest& r, AssemblyView& s, const ColumnChoice& c, const SlotLayout& l, WorkMemory& m) {
    return run_plain<double>(SerialTeam{}, p, r, s, c, l, m);
}
ChunkOutcome run_plain_single(const RveParameters& p, const ChunkRequest& r, AssemblyView& s, const ColumnChoice& c, const SlotLayout& l, WorkMemory& m) {
    return run_plain<float>(SerialTeam{}, p, r, s, c, l, m);
}
ChunkOutcome run_shuffled(std::uint64_t seed, Precision precision, const RveParameters& p, const ChunkRequest& r, AssemblyView& s, const ColumnChoice& c,
                          const SlotLayout& l, WorkMemory& m) {
    const ShuffledTeam team(seed);
    return precision == Precision::single_ ? run_plain<float>(team, p, r, s, c, l, m) : run_plain<double>(team, p, r, s, c, l, m);
}

} // namespace talik::farm
