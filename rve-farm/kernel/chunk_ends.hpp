#pragma once
// What happens to one contact and one disc at both ends of a chunk: into displacement form, and back with what it adds to the
// sums that an RVE answers. One text for every kernel; where the numbers are kept in between is the kernel's.
#include <cmath>

#include "rve-farm/assembly/columns.hpp"
#include "rve-farm/kernel/contact_step.hpp"
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

// Of a kernel's ledger, J.
struct ChunkLedger {
    double friction = 0, bond = 0, damping = 0, work = 0;
};

// Ledger of work, V sigma : D dt = -(f_old + f_new)/2 . (D b) dt of every contact: the trapezoid that leapfrog conserves.
// (D b) dt is (U - I) b_old = (I - U^-1)(b_new - dt (v_j - v_i)), so it comes out of the virials V = sum f x b of two
// successive sub-steps and of the discs' power: -[V_old : (U - I) + V_new : (I - U^-1) - dt sum F . (I - U^-1) v] / 2, J.
class WorkLedger {
public:
    WorkLedger() = default;
    TALIK_HOST_DEVICE explicit WorkLedger(const Virial<double>& at_start) : old_(at_start) {}

    // change: U - I; gained: I - U^-1. power: sum of F x v_f over the discs before the kick of this sub-step, which belongs to the
    // sub-step before; W. It is linear in the sums, so that each thread of a team may keep the ledger of its own part.
    TALIK_HOST_DEVICE void sub_step(const Symmetric& change, const Symmetric& gained, const Virial<double>& now, const Symmetric& power, double dt, ChunkLedger& ledger) {
        if (begun_) ledger.work += dt * contract(power, gained_) / 2;
        gained_ = gained;
        ledger.work -= (contract({old_.xx, old_.yy, old_.xy}, change) + contract({now.xx, now.yy, now.xy}, gained)) / 2;
        old_ = now;
        begun_ = true;
    }

private:
    TALIK_HOST_DEVICE static double contract(const Symmetric& a, const Symmetric& b) { return a.xx * b.xx + a.yy * b.yy + 2 * a.xy * b.xy; }
    Virial<double> old_;
    Symmetric gained_;
    bool begun_ = false;
};

// 1 / I of a disc about its axis, I = m r^2 / 2, 1/(kg m^2).
template <class Real>
TALIK_HOST_DEVICE Real inverse_inertia(Real inverse_mass, Real radius) { return Real(2) * inverse_mass / (radius * radius); }

// A candidate as the state has it, from its owner to its partner. f_t is the same from both ends.
template <class Real, class Condition>
struct StoredContact {
    Real x, y;                // branch, m
    ContactRadii<Real> radii; // m
    Real tangential;          // f_t, N
    Condition bonded;
};
TALIK_HOST_DEVICE StoredContact<double, bool> stored_contact(const AssemblyView& s, int c, bool turned) {
    const int owner = turned ? s.second[c] : s.first[c], partner = turned ? s.first[c] : s.second[c];
    const ContactGeometry g = geometry_of(s, c);
    return {turned ? -g.x : g.x, turned ? -g.y : g.y, {s.radius[owner], s.radius[partner]}, s.tangential_force[c], is_bonded(s, c)};
}
// Far apart and without a bond, for slots without a contact.
TALIK_HOST_DEVICE StoredContact<double, bool> inert_contact() { return {1, 0, {0, 0}, 0, false}; }

// A contact at the start, from its owner to its partner.
template <class Real>
struct ContactAtStart {
    ContactStart<Real> start;
    Real tangential;                                     // f_t0, N
    Real force_x, force_y, owner_torque, partner_torque; // N, N m
};

// Branch and overlap, and the force of the positions without slip or breaking: what the first kick needs.
template <class Real, class Condition>
TALIK_HOST_DEVICE ContactAtStart<Real> contact_at_start(const StoredContact<Real, Condition>& c, const ContactLaw<Real>& law) {
    const Real length = root(c.x * c.x + c.y * c.y), inverse = Real(1) / length, nx = c.x * inverse, ny = c.y * inverse;
    const Real overlap = (c.radii.owner + c.radii.partner) - length;
    const auto loaded = c.bonded | (overlap > Real(0));
    const Real fn = choose(loaded, law.normal_stiffness * overlap, Real(0)), ft = choose(loaded, c.tangential, Real(0)); // N
    const ContactArms<Real> arm(c.radii, overlap);
    return {{nx, ny, inverse, overlap}, ft, fn * nx - ft * ny, fn * ny + ft * nx, -ft * arm.owner, -ft * arm.partner};
}

// Over the contacts of the end.
template <class Real>
struct ContactSums {
    Virial<Real> virial;                                                  // sum f x b, J
    Real fabric_xx = Real(0), fabric_yy = Real(0), fabric_xy = Real(0); // sum b x b over those with force, m^2
    Real force = Real(0), stored_energy = Real(0);                       // sum |f|, N; J
    Real contacts = Real(0), bonds = Real(0);
};

// What the kernel has of a contact at the end.
template <class Real>
struct ContactAtEnd {
    ContactStart<Real> start;
    ContactRadii<Real> radii;
    Real tangential_change; // N
    RelativeMotion<Real> moved;
};

// Where its branch is then, in the numbers of the kernel.
template <class Real>
struct BranchAtEnd {
    Real normal_x, normal_y, strain; // n, |b| / |b0| - 1

    TALIK_HOST_DEVICE BranchAtEnd(const CellMotion<Real>& e, const ContactAtEnd<Real>& at) {
        const Real nx = at.start.normal_x, ny = at.start.normal_y;
        const Real gx = (e.xx * nx + e.xy * ny) + at.moved.x * at.start.inverse_length;
        const Real gy = (e.yx * nx + e.yy * ny) + at.moved.y * at.start.inverse_length;
        const BranchMotion<Real> branch(nx * gx + ny * gy, nx * gy - ny * gx);
        normal_x = (nx + gx) * branch.inverse_stretch;
        normal_y = (ny + gy) * branch.inverse_stretch;
        strain = branch.strain;
    }
};

// The same, and what the state remembers, in double.
template <class Wide, class Condition>
struct ContactToClose {
    Wide normal_x, normal_y, strain;
    Wide overlap_at_start;      // m
    ContactRadii<Wide> radii;   // m
    Wide tangential_change;     // N
    Wide rotation_difference;   // theta_i - theta_j, rad
    Wide tangential_at_start;   // f_t0 of the state, N
    Condition bonded;
};

// The contact as it is at the end, in double from what the kernel has carried. Returns f_t: f_t0 in double + its change; and within
// the Coulomb limit to the last digit, N.
template <class Wide, class Condition>
TALIK_HOST_DEVICE Wide close_contact(const ContactLaw<Wide>& law, const ContactToClose<Wide, Condition>& c, ContactSums<Wide>& sums) {
    const Wide length_at_start = (c.radii.owner + c.radii.partner) - c.overlap_at_start, elongation = length_at_start * c.strain; // m
    const Wide overlap = c.overlap_at_start - elongation;
    const auto loaded = c.bonded | (overlap > Wide(0));
    const Wide fn = choose(loaded, law.normal_stiffness * overlap, Wide(0)); // N
    const Wide rolled = law.tangential_stiffness * (Wide(0.5) * (c.radii.owner - c.radii.partner) * c.rotation_difference);
    const Wide carried = c.tangential_at_start + (c.tangential_change + rolled);
    const Wide held = choose(c.bonded, carried, law.limited({fn, carried}).tangential);
    const Wide ft = choose(loaded, held, Wide(0));
    const Wide length = length_at_start + elongation, bx = length * c.normal_x, by = length * c.normal_y;
    const Wide one = choose(loaded, Wide(1), Wide(0));
    sums.virial.add_contact(fn * c.normal_x - ft * c.normal_y, fn * c.normal_y + ft * c.normal_x, bx, by);
    sums.fabric_xx += one * bx * bx, sums.fabric_yy += one * by * by, sums.fabric_xy += one * bx * by;
    sums.stored_energy += law.stored_energy({fn, ft});
    sums.force += root(fn * fn + ft * ft);
    sums.contacts += one;
    sums.bonds += choose(c.bonded, Wide(1), Wide(0));
    return ft;
}

// One contact of the state closed, and given back if asked for.
template <class Real>
TALIK_HOST_DEVICE void close_contact(const CellMotion<Real>& e, const ContactLaw<double>& law, const ContactAtEnd<Real>& at, bool bonded, AssemblyView& s, int c,
                                     bool give_back, ContactSums<double>& sums) {
    const BranchAtEnd<Real> branch(e, at);
    const ContactToClose<double, bool> closing{branch.normal_x, branch.normal_y, branch.strain, at.start.overlap, {at.radii.owner, at.radii.partner},
                                               at.tangential_change, at.moved.rotation_difference, s.tangential_force[c], bonded};
    const double ft = close_contact(law, closing, sums);
    if (!give_back) return;
    s.tangential_force[c] = ft;
    if (s.bonded) s.bonded[c] = bonded;
}

// Over the discs of the end.
template <class Real>
struct DiscSums {
    Virial<Real> fluctuation;                                             // sum m v_f x v_f, J; only with the fluctuation effect
    Real kinetic = Real(0), unbalanced = Real(0);                        // J; sum |F|, N
    Real force_xx = Real(0), force_yy = Real(0), force_xy = Real(0);    // sum of F x v_f, symmetric part, W: for the ledger
    Real largest_drift_squared = Real(0);                                // since the list was built, m^2
};

// What the kernel has of a disc at the end.
template <class Real>
struct DiscAtEnd {
    Real displacement_x, displacement_y;  // w, non-affine, m
    Real velocity_x, velocity_y, spin;    // m/s, m/s, 1/s
    Real force_x, force_y, torque;        // N, N, N m
};

// What the state has of it.
template <class Real>
struct StoredDisc {
    Real x, y, drift_x, drift_y, radius, mass; // m, kg
};

// The disc at the end: x <- F x + w (Eq. 45), and what it adds to the answer. Velocities are half a sub-step behind the
// positions: m v . (v + dt F/m) / 2 is the kinetic energy at the positions' time that leapfrog conserves together with the
// springs'; it differs from m v^2 / 2 by the square of the step.
template <class Real>
TALIK_HOST_DEVICE void close_disc(const CellMotion<Real>& e, const DiscAtEnd<Real>& at, Real last_sub_step, bool fluctuation, StoredDisc<Real>& disc, DiscSums<Real>& sums) {
    const Real fx = at.force_x, fy = at.force_y, vx = at.velocity_x, vy = at.velocity_y, wx = at.displacement_x, wy = at.displacement_y;
    const Real m = disc.mass, inertia = Real(0.5) * m * disc.radius * disc.radius; // kg, kg m^2
    const Real power = fx * vx + fy * vy + at.torque * at.spin;                    // W
    sums.kinetic += Real(0.5) * (m * (vx * vx + vy * vy) + inertia * at.spin * at.spin + last_sub_step * power);
    sums.unbalanced += root(fx * fx + fy * fy);
    sums.force_xx += fx * vx, sums.force_yy += fy * vy, sums.force_xy += Real(0.5) * (fx * vy + fy * vx);
    if (fluctuation) sums.fluctuation.add_fluctuation(m, vx, vy);
    const Real x = disc.x, y = disc.y, dx = disc.drift_x, dy = disc.drift_y;
    disc.x = x + (e.xx * x + e.xy * y + wx);
    disc.y = y + (e.yx * x + e.yy * y + wy);
    disc.drift_x = dx + (e.xx * dx + e.xy * dy + wx);
    disc.drift_y = dy + (e.yx * dx + e.yy * dy + wy);
    sums.largest_drift_squared = larger(sums.largest_drift_squared, disc.drift_x * disc.drift_x + disc.drift_y * disc.drift_y);
}

// One disc of the state closed, and given back if asked for.
template <class Real>
TALIK_HOST_DEVICE void close_disc(const ChunkMotion& cell, const DiscAtEnd<Real>& at, double last_sub_step, bool fluctuation, AssemblyView& s, int i, bool give_back,
                                  DiscSums<double>& sums) {
    StoredDisc<double> disc{s.x[i], s.y[i], s.drift_x[i], s.drift_y[i], s.radius[i], s.mass[i]};
    const DiscAtEnd<double> end{at.displacement_x, at.displacement_y, at.velocity_x, at.velocity_y, at.spin, at.force_x, at.force_y, at.torque};
    close_disc(cell.template as<double>(), end, last_sub_step, fluctuation, disc, sums);
    if (!give_back) return;
    s.x[i] = disc.x, s.y[i] = disc.y, s.drift_x[i] = disc.drift_x, s.drift_y[i] = disc.drift_y;
    s.velocity_x[i] = end.velocity_x, s.velocity_y[i] = end.velocity_y, s.spin[i] = end.spin;
}

// All that a chunk leaves besides the state of contacts and discs.
struct ChunkSums {
    ChunkLedger ledger;
    ContactSums<double> contacts;
    DiscSums<double> discs;
};

} // namespace talik::farm
