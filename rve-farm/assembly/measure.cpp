#include "rve-farm/assembly/measure.hpp"

#include <algorithm>
#include <cmath>

#include "rve-farm/assembly/phases.hpp"
#include "rve-farm/physics/stress.hpp"

namespace talik::farm {
namespace {

struct ContactSums {
    Virial<double> virial;           // sum f x b, J
    double fabric_xx = 0, fabric_yy = 0, fabric_xy = 0; // sum b x b, m^2
    double stored_energy = 0, friction_dissipation = 0, bond_dissipation = 0, work = 0; // J
    double force = 0;                // sum |f|, N
    int loaded = 0, bonds = 0;
};

ContactSums sum_over_contacts(const AssemblyView& s, const ColumnChoice& columns, const ContactLaw<double>& law) {
    const AssemblyNumbers& n = *s.numbers;
    ContactSums sum;
    for (int c = 0; c < s.contact_count(); ++c) {
        sum.friction_dissipation += s.friction_dissipation[c];
        sum.work += s.work[c];
        if (columns.bond) {
            sum.bond_dissipation += s.bond_dissipation[c];
            sum.bonds += s.bonded[c];
        }
        const double fx = s.force_x[c], fy = s.force_y[c], ft = s.tangential_force[c];
        if (fx == 0 && fy == 0) continue;
        const double ix = s.image_x[c], iy = s.image_y[c];
        const double bx = s.x[s.second[c]] - s.x[s.first[c]] + (n.cell_xx * ix + n.cell_xy * iy);
        const double by = s.y[s.second[c]] - s.y[s.first[c]] + (n.cell_yx * ix + n.cell_yy * iy);
        sum.virial.add_contact(fx, fy, bx, by);
        sum.fabric_xx += bx * bx, sum.fabric_yy += by * by, sum.fabric_xy += bx * by;
        const double fn = law.normal_stiffness * 2 * s.half_overlap[c]; // N
        sum.stored_energy += law.stored_energy({fn, ft});
        sum.force += std::hypot(fx, fy);
        ++sum.loaded;
    }
    return sum;
}

struct DiscSums {
    Virial<double> fluctuation; // sum m v_f x v_f, J
    double kinetic_energy = 0, damping_dissipation = 0, work = 0; // J
    double unbalanced = 0; // sum |F|, N
};

// Velocities are half a sub-step behind the positions. m v- . (v- + dt F/m) / 2 is the kinetic energy at the positions'
// time that leapfrog conserves together with the springs' (exactly, for linear springs); it differs from m v^2 / 2 by the
// square of the step, and may be a shade below zero where every disc turns back at once.
DiscSums sum_over_discs(const AssemblyView& s, const ColumnChoice& columns) {
    DiscSums sum;
    for (int i = 0; i < s.disc_count(); ++i) {
        const DiscForce force = gather_forces(s, i);
        const double m = s.mass[i], inertia = m * s.radius[i] * s.radius[i] / 2; // kg, kg m^2
        const double vx = s.velocity_x[i], vy = s.velocity_y[i], spin = s.spin[i];
        const double power = force.x * vx + force.y * vy + force.torque * spin; // W
        sum.kinetic_energy += (m * (vx * vx + vy * vy) + inertia * spin * spin + s.numbers->last_sub_step * power) / 2;
        if (columns.damping) sum.damping_dissipation += s.damping_dissipation[i];
        if (columns.fluctuation) {
            sum.work += s.fluctuation_work[i];
            sum.fluctuation.add_fluctuation(m, vx, vy);
        }
        sum.unbalanced += std::hypot(force.x, force.y);
    }
    return sum;
}

// Upper bound of the P-wave modulus, Pa: max(k_n, k_t) times the largest eigenvalue of (1/V) sum b x b. The acoustic
// tensor of the affine (Voigt) stiffness in direction d, (1/V) sum (b.d)^2 (k_n n n + k_t t t), has no larger eigenvalue,
// and equals it where k_n = k_t; non-affine motion only softens it.
double stiffness_bound(const ContactSums& sum, const ContactLaw<double>& law, double volume) {
    const double mean = (sum.fabric_xx + sum.fabric_yy) / 2;
    const double largest = mean + std::hypot((sum.fabric_xx - sum.fabric_yy) / 2, sum.fabric_xy);
    return std::max(law.normal_stiffness, law.tangential_stiffness) * largest / volume;
}

bool finite(const Answer& a) {
    return std::isfinite(a.stress[0] + a.stress[1] + a.stress[2]) && std::isfinite(a.kinetic_energy + a.stored_energy) &&
           std::isfinite(a.cell_area);
}

} // namespace

double cell_area(const AssemblyNumbers& n) { return std::abs(n.cell_xx * n.cell_yy - n.cell_xy * n.cell_yx); }

Answer measure(const AssemblyView& s, const ColumnChoice& columns, const ContactLaw<double>& law) {
    const AssemblyNumbers& n = *s.numbers;
    const ContactSums contacts = sum_over_contacts(s, columns, law);
    const DiscSums discs = sum_over_discs(s, columns);

    Answer answer;
    answer.cell_area = cell_area(n);
    const double volume = answer.cell_area * n.thickness; // m^3
    Virial<double> virial = contacts.virial;
    if (columns.fluctuation) {
        virial.xx += discs.fluctuation.xx;
        virial.yy += discs.fluctuation.yy;
        virial.xy += discs.fluctuation.xy;
    }
    const Virial<double> stress = virial.stress(volume).turned(std::cos(n.frame_angle), std::sin(n.frame_angle));
    answer.stress = {stress.xx, stress.yy, stress.xy};
    answer.stiffness = stiffness_bound(contacts, law, volume);
    answer.contacts = contacts.loaded;
    answer.coordination_number = 2.0 * contacts.loaded / static_cast<double>(n.disc_count);
    answer.bonds = contacts.bonds;
    answer.broken_bonds = static_cast<int>(n.activated_bonds) - contacts.bonds;
    answer.unbalanced_force = contacts.loaded == 0 ? 0 // mean |F| over the discs / mean |f| over the contacts
                              : discs.unbalanced / static_cast<double>(n.disc_count) / (contacts.force / contacts.loaded);
    answer.stored_energy = contacts.stored_energy;
    answer.kinetic_energy = discs.kinetic_energy;
    answer.friction_dissipation = n.friction_dissipation + contacts.friction_dissipation;
    answer.damping_dissipation = discs.damping_dissipation;
    answer.bond_dissipation = n.bond_dissipation + contacts.bond_dissipation;
    answer.work = n.work + contacts.work + discs.work;
    answer.void_ratio = answer.cell_area / n.disc_area - 1;
    answer.split_steps = static_cast<int>(n.split_steps);
    answer.status = finite(answer) ? Status::ok : Status::not_finite;
    return answer;
}

} // namespace talik::farm
