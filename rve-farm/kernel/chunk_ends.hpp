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

struct DiscAtStart {
    double velocity_x, velocity_y, spin;   // m/s, m/s, 1/s
    double inverse_mass, inverse_inertia;  // 1/kg, 1/(kg m^2)
};
TALIK_HOST_DEVICE DiscAtStart disc_at_start(const AssemblyView& s, int i) {
    const double inverse_mass = 1 / s.mass[i];
    return {s.velocity_x[i], s.velocity_y[i], s.spin[i], inverse_mass, 2 * inverse_mass / (s.radius[i] * s.radius[i])}; // 1 / (m r^2 / 2)
}

// A contact at the start, from its owner to its partner.
struct ContactAtStart {
    ContactStart<double> start;
    double tangential;                                     // f_t0, N
    double force_x, force_y, partner_torque, owner_torque; // N, N m
    bool bonded;

    TALIK_HOST_DEVICE Virial<double> virial() const { // f x b, J
        Virial<double> sum;
        sum.add_contact(force_x, force_y, start.normal_x / start.inverse_length, start.normal_y / start.inverse_length);
        return sum;
    }
    // Far apart and without a bond, for slots without a contact.
    TALIK_HOST_DEVICE static ContactAtStart inert() { return {{1, 0, 1, -1}, 0, 0, 0, 0, 0, false}; }
};

// Branch and overlap in double, force of the positions without slip or breaking: what the first kick needs.
TALIK_HOST_DEVICE ContactAtStart contact_at_start(const AssemblyView& s, int c, bool turned, const ContactLaw<double>& law) {
    const double sign = turned ? -1 : 1; // from the other end: branch the other way, f_t the same
    const ContactGeometry g = geometry_of(s, c);
    const double inverse = sign / g.length, nx = g.x * inverse, ny = g.y * inverse;
    const double first = s.radius[s.first[c]], second = s.radius[s.second[c]];
    const double difference = sign * (first - second) / 2; // m
    const bool loaded = g.overlap > 0 || is_bonded(s, c);
    const double fn = loaded ? law.normal_stiffness * g.overlap : 0, ft = loaded ? s.tangential_force[c] : 0; // N
    ContactAtStart at;
    at.start = {nx, ny, sign * inverse, g.overlap};
    at.tangential = ft;
    at.force_x = fn * nx - ft * ny;
    at.force_y = fn * ny + ft * nx;
    at.partner_torque = -ft * (g.length / 2 - difference);
    at.owner_torque = -ft * (g.length / 2 + difference);
    at.bonded = is_bonded(s, c);
    return at;
}

// Over the contacts of the end.
struct ContactSums {
    Virial<double> virial;                     // sum f x b, J
    double fabric_xx = 0, fabric_yy = 0, fabric_xy = 0; // sum b x b over those with force, m^2
    double force = 0, stored_energy = 0;       // sum |f|, N; J
    double contacts = 0, bonds = 0;
};

// What the kernel has of a contact at the end.
template <class Real>
struct ContactAtEnd {
    Real normal_x, normal_y, inverse_length, overlap; // of the start
    ContactRadii<Real> radii;
    Real tangential_change; // N
    bool bonded;
    RelativeMotion<Real> moved;
};

// The contact as it is at the end, in double from what the kernel has carried; given back if asked for.
template <class Real>
TALIK_HOST_DEVICE void close_contact(const CellMotion<Real>& e, const ContactLaw<double>& law, const ContactAtEnd<Real>& at, AssemblyView& s, int c, bool give_back,
                                     ContactSums& sums) {
    const Real nx = at.normal_x, ny = at.normal_y;
    const Real gx = (e.xx * nx + e.xy * ny) + at.moved.x * at.inverse_length;
    const Real gy = (e.yx * nx + e.yy * ny) + at.moved.y * at.inverse_length;
    const BranchMotion<Real> branch(nx * gx + ny * gy, nx * gy - ny * gx);
    const double length_at_start = static_cast<double>(at.radii.owner) + at.radii.partner - at.overlap, elongation = length_at_start * branch.strain; // m
    const double overlap = at.overlap - elongation;
    const bool loaded = at.bonded || overlap > 0;
    // f_t = f_t0 in double + its change; and within the Coulomb limit to the last digit.
    double ft = 0;
    const double fn = loaded ? law.normal_stiffness * overlap : 0; // N
    if (loaded) {
        const double rolled = law.tangential_stiffness * ((static_cast<double>(at.radii.owner) - at.radii.partner) / 2 * at.moved.rotation_difference);
        ft = s.tangential_force[c] + (at.tangential_change + rolled);
        if (!at.bonded) ft = law.limited({fn, ft}).tangential;
    }
    if (give_back) {
        s.tangential_force[c] = ft;
        if (s.bonded) s.bonded[c] = at.bonded;
    }
    sums.bonds += at.bonded;
    if (!loaded) return;
    const double mx = (nx + gx) * branch.inverse_stretch, my = (ny + gy) * branch.inverse_stretch;
    const double length = length_at_start + elongation, bx = length * mx, by = length * my;
    sums.virial.add_contact(fn * mx - ft * my, fn * my + ft * mx, bx, by);
    sums.fabric_xx += bx * bx, sums.fabric_yy += by * by, sums.fabric_xy += bx * by;
    sums.stored_energy += law.stored_energy({fn, ft});
    sums.force += std::sqrt(fn * fn + ft * ft);
    sums.contacts += 1;
}

// Over the discs of the end.
struct DiscSums {
    Virial<double> fluctuation;                      // sum m v_f x v_f, J; only with the fluctuation effect
    double kinetic = 0, unbalanced = 0;              // J; sum |F|, N
    double force_xx = 0, force_yy = 0, force_xy = 0; // sum of F x v_f, symmetric part, W: for the ledger
};

template <class Real>
struct DiscAtEnd {
    Real displacement_x, displacement_y;  // w, non-affine, m
    Real velocity_x, velocity_y, spin;    // m/s, m/s, 1/s
    Real force_x, force_y, torque;        // N, N, N m
};

// The disc at the end: x <- F x + w (Eq. 45), and what it adds to the answer. Velocities are half a sub-step behind the
// positions: m v . (v + dt F/m) / 2 is the kinetic energy at the positions' time that leapfrog conserves together with the
// springs'; it differs from m v^2 / 2 by the square of the step.
template <class Real>
TALIK_HOST_DEVICE void close_disc(const ChunkMotion& cell, const DiscAtEnd<Real>& at, double last_sub_step, bool fluctuation, AssemblyView& s, int i, bool give_back,
                                  DiscSums& sums, double& largest_drift_squared) {
    const double fx = at.force_x, fy = at.force_y, torque = at.torque;
    const double vx = at.velocity_x, vy = at.velocity_y, spin = at.spin;
    const double m = s.mass[i], inertia = m * s.radius[i] * s.radius[i] / 2; // kg, kg m^2
    const double power = fx * vx + fy * vy + torque * spin;                  // W
    sums.kinetic += (m * (vx * vx + vy * vy) + inertia * spin * spin + last_sub_step * power) / 2;
    sums.unbalanced += std::sqrt(fx * fx + fy * fy);
    sums.force_xx += fx * vx, sums.force_yy += fy * vy, sums.force_xy += (fx * vy + fy * vx) / 2;
    if (fluctuation) sums.fluctuation.add_fluctuation(m, vx, vy);
    if (!give_back) return;
    const double wx = at.displacement_x, wy = at.displacement_y, x = s.x[i], y = s.y[i], dx = s.drift_x[i], dy = s.drift_y[i];
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

// All that a chunk leaves besides the state of contacts and discs.
struct ChunkSums {
    ChunkLedger ledger;
    ContactSums contacts;
    DiscSums discs;
    double largest_drift_squared = 0; // since the list was built, m^2
};

} // namespace talik::farm
