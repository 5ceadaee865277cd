#pragma once
// What every kernel does before and after the sub-steps of a chunk: the state in slot order and displacement form, and
// back, with the sums that an RVE answers. Plain loops over slots, index i writing only slot i, for any team.
#include <time.h>

#include <cmath>

#include "rve-farm/kernel/contact_step.hpp"
#include "rve-farm/kernel/work.hpp"
#include "rve-farm/physics/physics.hpp"
#include "rve-farm/physics/stress.hpp"

namespace talik::farm {

// The cell's motion since the start of the chunk less the identity, F - I: small numbers keep their digits.
struct ChunkMotion {
    double xx = 0, xy = 0, yx = 0, yy = 0; // F - I
    double rotation = 0;                   // of the frame, rad

    TALIK_HOST_DEVICE void advance(const Stretch& stretch) { // F <- U F (Eq. 45)
        const Symmetric d = stretch.change();
        const double old_xx = xx, old_xy = xy;
        xx += d.xx + (d.xx * xx + d.xy * yx);
        xy += d.xy + (d.xx * xy + d.xy * yy);
        yx += d.xy + (d.xy * old_xx + d.yy * yx);
        yy += d.yy + (d.xy * old_xy + d.yy * yy);
        rotation += stretch.rotation;
    }
    template <class Real>
    TALIK_HOST_DEVICE CellMotion<Real> as() const {
        return {Real(xx), Real(xy), Real(yx), Real(yy)};
    }
};

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

// Of a kernel's ledger, J.
struct ChunkLedger {
    double friction = 0, bond = 0, damping = 0, work = 0;
};

template <class Real, class Level>
void load_discs(const auto& team, const AssemblyView& s, const SlotLayout& layout, Work<Real, Level>& w) {
    team.each(w.disc_slots, [&](int k) {
        const int i = layout.disc[static_cast<std::size_t>(k)], row = 4 * k;
        const double inverse_mass = i < 0 ? 0 : 1 / s.mass[i];
        for (int a = 0; a < 4; ++a) w.displacement[row + a] = w.force[row + a] = 0;
        w.velocity[row] = static_cast<Real>(i < 0 ? 0 : s.velocity_x[i]);
        w.velocity[row + 1] = static_cast<Real>(i < 0 ? 0 : s.velocity_y[i]);
        w.velocity[row + 2] = static_cast<Real>(i < 0 ? 0 : s.spin[i]);
        w.velocity[row + 3] = 0;
        w.inverse_mass[row] = w.inverse_mass[row + 1] = static_cast<Real>(inverse_mass);
        w.inverse_mass[row + 2] = static_cast<Real>(i < 0 ? 0 : 2 * inverse_mass / (s.radius[i] * s.radius[i])); // 1 / (m r^2 / 2)
        w.inverse_mass[row + 3] = 0;
        if (!w.mass) return;
        w.mass[row] = w.mass[row + 1] = static_cast<Real>(i < 0 ? 0 : s.mass[i]);
        w.mass[row + 2] = w.mass[row + 3] = 0;
    });
}

// Branches and overlaps in double, forces of the positions without slip or breaking: what the first kick needs.
template <class Real, class Level>
void load_contacts(const auto& team, const AssemblyView& s, const SlotLayout& layout, const ContactLaw<double>& law, Work<Real, Level>& w) {
    team.each(w.contact_slots, [&](int k) {
        const auto slot = static_cast<std::size_t>(k);
        const int c = layout.contact[slot];
        const int row = layout.row[slot], lanes = w.lanes();
        Real* field = w.contact(k);
        using F = ContactField;
        field[F::turn * lanes] = field[F::length_change * lanes] = field[F::tangential_change * lanes] = 0;
        if (c < 0) { // inert: far apart, no bond
            field[F::normal_x * lanes] = field[F::length * lanes] = field[F::inverse_length * lanes] = 1;
            field[F::normal_y * lanes] = field[F::half_difference * lanes] = field[F::tangential_start * lanes] = 0;
            field[F::overlap * lanes] = -1;
            if (w.bonds) field[F::bonded * lanes] = field[F::smaller_radius * lanes] = 0;
            if (w.ledger) field[F::tangential(w.bonds) * lanes] = 0;
            for (int a = 0; a < 4; ++a) w.contact_force[row + a] = 0;
            return;
        }
        const bool turned = layout.turned[slot] != 0; // from the other end: branch the other way, f_t the same
        const double sign = turned ? -1 : 1;
        const ContactGeometry g = geometry_of(s, c);
        const double inverse = sign / g.length, nx = g.x * inverse, ny = g.y * inverse;
        const double difference = sign * (s.radius[s.first[c]] - s.radius[s.second[c]]) / 2; // m
        const bool loaded = g.overlap > 0 || is_bonded(s, c);
        const double fn = loaded ? law.normal_stiffness * g.overlap : 0, ft = loaded ? s.tangential_force[c] : 0; // N
        field[F::normal_x * lanes] = static_cast<Real>(nx);
        field[F::normal_y * lanes] = static_cast<Real>(ny);
        field[F::length * lanes] = static_cast<Real>(g.length);
        field[F::inverse_length * lanes] = static_cast<Real>(sign * inverse);
        field[F::overlap * lanes] = static_cast<Real>(g.overlap);
        field[F::half_difference * lanes] = static_cast<Real>(difference);
        field[F::tangential_start * lanes] = static_cast<Real>(ft);
        if (w.ledger) field[F::tangential(w.bonds) * lanes] = static_cast<Real>(ft);
        if (w.bonds) {
            const double smaller = s.radius[s.first[c]] < s.radius[s.second[c]] ? s.radius[s.first[c]] : s.radius[s.second[c]];
            field[F::bonded * lanes] = is_bonded(s, c) ? 1 : 0;
            field[F::smaller_radius * lanes] = static_cast<Real>(smaller);
        }
        w.contact_force[row] = static_cast<Real>(fn * nx - ft * ny);
        w.contact_force[row + 1] = static_cast<Real>(fn * ny + ft * nx);
        w.contact_force[row + 2] = static_cast<Real>(-ft * (g.length / 2 - difference));
        w.contact_force[row + 3] = static_cast<Real>(-ft * (g.length / 2 + difference));
    });
}

// Sum of f x b of the forces at the start, J.
template <class Real, class Level>
Virial<double> virial_at_start(const Work<Real, Level>& w, const SlotLayout& layout) {
    Virial<double> sum;
    for (int k = 0; k < w.contact_slots; ++k) {
        const Real* f = w.contact_force + layout.row[static_cast<std::size_t>(k)];
        const Real* field = w.contact(k);
        const double length = field[ContactField::length * w.lanes()];
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

// The contacts as they are at the end, in double from what the kernel has carried; the sums that an RVE answers; and, if
// asked for, the state of the contacts given back.
template <class Level, class Real>
void close_contacts(const ChunkMotion& cell, const SlotLayout& layout, const ContactLaw<double>& law, Work<Real, Level>& w, AssemblyView& s,
                    bool give_back, Answer& answer, Virial<double>& virial, double (&fabric)[3], double& force_sum) {
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
        const Real nx = field[F::normal_x * lanes], ny = field[F::normal_y * lanes], length0 = field[F::length * lanes];
        const Real inverse0 = field[F::inverse_length * lanes];
        const Real gx = (e.xx * nx + e.xy * ny) + (wj[0] - wi[0]) * inverse0;
        const Real gy = (e.yx * nx + e.yy * ny) + (wj[1] - wi[1]) * inverse0;
        const BranchMotion<Real> branch(length0, nx * gx + ny * gy, nx * gy - ny * gx);
        const bool bonded = w.bonds && field[F::bonded * lanes] > 0;
        const double overlap = field[F::overlap * lanes] - branch.length_change; // m
        const bool loaded = bonded || overlap > 0;
        // f_t = f_t0 in double + its change; and within the Coulomb limit to the last digit.
        double ft = 0;
        const double fn = loaded ? law.normal_stiffness * overlap : 0; // N
        if (loaded) {
            const double rolled = law.tangential_stiffness * (field[F::half_difference * lanes] * static_cast<double>(wi[2] - wj[2]));
            ft = s.tangential_force[c] + (field[F::tangential_change * lanes] + rolled);
            if (!bonded) ft = law.limited({fn, ft}).tangential;
        }
        if (give_back) {
            s.tangential_force[c] = ft;
            if (s.bonded) s.bonded[c] = bonded;
        }
        answer.bonds += bonded;
        if (!loaded) continue;
        const double mx = (nx + gx) * branch.inverse_stretch, my = (ny + gy) * branch.inverse_stretch;
        const double length = static_cast<double>(length0) + branch.length_change, bx = length * mx, by = length * my;
        virial.add_contact(fn * mx - ft * my, fn * my + ft * mx, bx, by);
        fabric[0] += bx * bx, fabric[1] += by * by, fabric[2] += bx * by;
        answer.stored_energy += law.stored_energy({fn, ft});
        force_sum += std::sqrt(fn * fn + ft * ft);
        ++answer.contacts;
    }
}

struct DiscSums {
    Virial<double> fluctuation;              // sum m v_f x v_f, J
    double kinetic = 0, unbalanced = 0;      // J; sum |F|, N
    double force_xx = 0, force_yy = 0, force_xy = 0; // sum of F x v_f, symmetric part, W: for the ledger
};

// The discs at the end: x <- F x + w (Eq. 45), and what they add to the answer. Velocities are half a sub-step behind the
// positions: m v . (v + dt F/m) / 2 is the kinetic energy at the positions' time that leapfrog conserves together with the
// springs'; it differs from m v^2 / 2 by the square of the step.
template <class Real, class Level>
DiscSums close_discs(const ChunkMotion& cell, const SlotLayout& layout, const Work<Real, Level>& w, AssemblyView& s, bool give_back,
                     bool owner_sums_are_ready, double& largest_drift_squared) {
    DiscSums sums;
    for (int k = 0; k < w.disc_slots; ++k) {
        const int i = layout.disc[static_cast<std::size_t>(k)], row = 4 * k;
        if (i < 0) continue;
        Real force[3] = {0, 0, 0};
        if (owner_sums_are_ready) force[0] = w.force[row], force[1] = w.force[row + 1], force[2] = w.force[row + 2];
        else add_owned(w, layout, k, force);
        add_incoming(w, layout, k, force);
        const double fx = force[0], fy = force[1], torque = force[2];
        const double vx = w.velocity[row], vy = w.velocity[row + 1], spin = w.velocity[row + 2];
        const double m = s.mass[i], inertia = m * s.radius[i] * s.radius[i] / 2; // kg, kg m^2
        const double power = fx * vx + fy * vy + torque * spin;                  // W
        sums.kinetic += (m * (vx * vx + vy * vy) + inertia * spin * spin + s.numbers->last_sub_step * power) / 2;
        sums.unbalanced += std::sqrt(fx * fx + fy * fy);
        sums.force_xx += fx * vx, sums.force_yy += fy * vy, sums.force_xy += (fx * vy + fy * vx) / 2;
        if (w.mass) sums.fluctuation.add_fluctuation(m, vx, vy);
        if (!give_back) continue;
        const double wx = w.displacement[row], wy = w.displacement[row + 1], x = s.x[i], y = s.y[i], dx = s.drift_x[i], dy = s.drift_y[i];
        s.x[i] = x + (cell.xx * x + cell.xy * y + wx);
        s.y[i] = y + (cell.yx * x + cell.yy * y + wy);
        s.drift_x[i] = dx + (cell.xx * dx + cell.xy * dy + wx);
        s.drift_y[i] = dy + (cell.yx * dx + cell.yy * dy + wy);
        s.velocity_x[i] = vx;
        s.velocity_y[i] = vy;
        s.spin[i] = spin;
        const double squared = s.drift_x[i] * s.drift_x[i] + s.drift_y[i] * s.drift_y[i];
        largest_drift_squared = squared > largest_drift_squared ? squared : largest_drift_squared;
    }
    return sums;
}

// Upper bound of the P-wave modulus, Pa: max(k_n, k_t) times the largest eigenvalue of (1/V) sum b x b. The acoustic
// tensor of the affine (Voigt) stiffness in direction d, (1/V) sum (b.d)^2 (k_n n n + k_t t t), has no larger eigenvalue,
// and equals it where k_n = k_t; non-affine motion only softens it.
TALIK_HOST_DEVICE double stiffness_bound(const double (&fabric)[3], const ContactLaw<double>& law, double volume) {
    const double mean = (fabric[0] + fabric[1]) / 2, half = (fabric[0] - fabric[1]) / 2;
    const double largest = mean + std::sqrt(half * half + fabric[2] * fabric[2]);
    return larger(law.normal_stiffness, law.tangential_stiffness) * largest / volume;
}

// Kahan's sum: value += change, with the rounding error kept for the next time.
TALIK_HOST_DEVICE void add_exactly(double& value, double& lost, double change) {
    const double corrected = change - lost;
    const double sum = value + corrected;
    lost = (sum - value) - corrected;
    value = sum;
}

// H' <- F H', theta <- theta + angle of the rotations (Eq. 45).
TALIK_HOST_DEVICE void move_cell(AssemblyNumbers& n, const ChunkMotion& cell) {
    const double xx = n.cell_xx, xy = n.cell_xy, yx = n.cell_yx, yy = n.cell_yy;
    add_exactly(n.cell_xx, n.lost_xx, cell.xx * xx + cell.xy * yx);
    add_exactly(n.cell_yx, n.lost_yx, cell.yx * xx + cell.yy * yx);
    add_exactly(n.cell_xy, n.lost_xy, cell.xx * xy + cell.xy * yy);
    add_exactly(n.cell_yy, n.lost_yy, cell.yx * xy + cell.yy * yy);
    add_exactly(n.frame_angle, n.lost_angle, cell.rotation);
}

// Everything after the last sub-step: the answer, and the state given back.
template <class Real, class Level>
void close_chunk(const ChunkRequest& request, const ChunkMotion& cell, const ContactLaw<double>& law, const SlotLayout& layout, Work<Real, Level>& w,
                 AssemblyView& s, ChunkLedger ledger, bool owner_sums_are_ready, ChunkOutcome& outcome) {
    AssemblyNumbers& n = *s.numbers;
    AssemblyNumbers now = n;
    if (request.substeps > 0) {
        move_cell(now, cell);
        now.last_sub_step = request.sub_step;
    }
    const AssemblyNumbers before = n;
    n = now; // the sums are those of the end
    Answer& answer = outcome.answer;
    Virial<double> virial;
    double fabric[3] = {0, 0, 0}, force_sum = 0, largest_drift_squared = 0;
    close_contacts(cell, layout, law, w, s, request.give_back, answer, virial, fabric, force_sum);
    const DiscSums discs = close_discs(cell, layout, w, s, request.give_back, owner_sums_are_ready, largest_drift_squared);
    virial.xx += discs.fluctuation.xx, virial.yy += discs.fluctuation.yy, virial.xy += discs.fluctuation.xy;
    if (request.ledger && request.substeps > 0) { // see WorkLedger, below: what the last sub-step's forces owe
        const Symmetric g = outcome.last_stretch.change_seen_from_the_end();
        ledger.work += request.sub_step * (discs.force_xx * g.xx + discs.force_yy * g.yy + 2 * discs.force_xy * g.xy) / 2;
    }
    n.friction_dissipation += ledger.friction;
    n.bond_dissipation += ledger.bond;
    n.damping_dissipation += ledger.damping;
    n.work += ledger.work;
    if (request.give_back) n.displacement_bound = std::sqrt(largest_drift_squared);

    const double area = std::abs(n.cell_xx * n.cell_yy - n.cell_xy * n.cell_yx), volume = area * n.thickness; // m^2, m^3
    const Virial<double> stress = virial.stress(volume).turned(std::cos(n.frame_angle), std::sin(n.frame_angle));
    const auto count = static_cast<double>(n.disc_count);
    answer.stress = {stress.xx, stress.yy, stress.xy};
    answer.stiffness = stiffness_bound(fabric, law, volume);
    answer.coordination_number = 2.0 * answer.contacts / count;
    answer.broken_bonds = static_cast<int>(n.activated_bonds) - answer.bonds;
    answer.unbalanced_force = force_sum > 0 ? discs.unbalanced / count / (force_sum / answer.contacts) : 0; // mean |F| / mean |f|; bonds may be without force
    answer.kinetic_energy = discs.kinetic;
    answer.friction_dissipation = n.friction_dissipation;
    answer.damping_dissipation = n.damping_dissipation;
    answer.bond_dissipation = n.bond_dissipation;
    answer.work = n.work;
    answer.cell_area = area;
    answer.void_ratio = area / n.disc_area - 1;
    answer.split_steps = static_cast<int>(n.split_steps);
    const double check = stress.xx + stress.yy + stress.xy + answer.kinetic_energy + answer.stored_energy + area;
    answer.status = check - check == 0 ? Status::ok : Status::not_finite;
    if (!request.give_back) n = before;
}

// The last word on a chunk: is it sound, has the list held, and then everything of close_chunk.
template <class Real, class Level>
void finish(const ChunkRequest& request, StageClock<Level>& clock, const ChunkMotion& cell, const ContactLaw<double>& law, const SlotLayout& layout, Work<Real, Level>& w,
            AssemblyView& s, const ChunkLedger& ledger, double largest_displacement, bool owner_sums_are_ready, ChunkOutcome& outcome) {
    outcome.inner_seconds = clock.lap();
    outcome.largest_displacement = largest_displacement;
    outcome.finite = displacements_are_finite(w);
    outcome.accepted = outcome.finite && (request.substeps == 0 || largest_displacement <= request.displacement_allowed);
    if (outcome.accepted) close_chunk(request, cell, law, layout, w, s, ledger, owner_sums_are_ready, outcome);
    outcome.close_seconds = clock.lap();
}

// Ledger of work, V sigma : D dt = -(f_old + f_new)/2 . (D b) dt of every contact: the trapezoid that leapfrog conserves.
// (D b) dt is (U - I) b_old = (I - U^-1)(b_new - dt (v_j - v_i)), so it comes out of the virials V = sum f x b of two
// successive sub-steps and of the discs' power: -[V_old : (U - I) + V_new : (I - U^-1) - dt sum F . (I - U^-1) v] / 2, J.
class WorkLedger {
public:
    explicit WorkLedger(const Virial<double>& at_start) : old_(at_start) {}

    // power: sum of F x v_f over the discs before the kick of this sub-step, which belongs to the sub-step before; W.
    void sub_step(const Stretch& stretch, const Virial<double>& now, const Symmetric& power, double dt, ChunkLedger& ledger) {
        if (begun_) ledger.work += dt * contract(power, gained_) / 2;
        const Symmetric change = stretch.change();
        gained_ = stretch.change_seen_from_the_end();
        ledger.work -= (contract({old_.xx, old_.yy, old_.xy}, change) + contract({now.xx, now.yy, now.xy}, gained_)) / 2;
        old_ = now;
        begun_ = true;
    }

private:
    static double contract(const Symmetric& a, const Symmetric& b) { return a.xx * b.xx + a.yy * b.yy + 2 * a.xy * b.xy; }
    Virial<double> old_;
    Symmetric gained_;
    bool begun_ = false;
};

} // namespace talik::farm
