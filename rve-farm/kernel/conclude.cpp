#include "rve-farm/kernel/conclude.hpp"

#include <cmath>

namespace talik::farm {
namespace {

// Upper bound of the P-wave modulus, Pa: max(k_n, k_t) times the largest eigenvalue of (1/V) sum b x b. The acoustic
// tensor of the affine (Voigt) stiffness in direction d, (1/V) sum (b.d)^2 (k_n n n + k_t t t), has no larger eigenvalue,
// and equals it where k_n = k_t; non-affine motion only softens it.
inline double stiffness_bound(const ContactSums<double>& sums, const ContactLaw<double>& law, double volume) {
    const double mean = (sums.fabric_xx + sums.fabric_yy) / 2, half = (sums.fabric_xx - sums.fabric_yy) / 2;
    const double largest = mean + std::sqrt(half * half + sums.fabric_xy * sums.fabric_xy);
    return larger(law.normal_stiffness, law.tangential_stiffness) * largest / volume;
}

// Kahan's sum: value += change, with the rounding error kept for the next time.
inline void add_exactly(double& value, double& lost, double change) {
    const double corrected = change - lost;
    const double sum = value + corrected;
    lost = (sum - value) - corrected;
    value = sum;
}

// H' <- F H', theta <- theta + angle of the rotations (Eq. 45).
inline void move_cell(AssemblyNumbers& n, const ChunkMotion& cell) {
    const double xx = n.cell_xx, xy = n.cell_xy, yx = n.cell_yx, yy = n.cell_yy;
    add_exactly(n.cell_xx, n.lost_xx, cell.xx * xx + cell.xy * yx);
    add_exactly(n.cell_yx, n.lost_yx, cell.yx * xx + cell.yy * yx);
    add_exactly(n.cell_xy, n.lost_xy, cell.xx * xy + cell.xy * yy);
    add_exactly(n.cell_yy, n.lost_yy, cell.yx * xy + cell.yy * yy);
    add_exactly(n.frame_angle, n.lost_angle, cell.rotation);
}

} // namespace

void conclude(const ChunkRequest& request, const ChunkMotion& cell, const ContactLaw<double>& law, const ChunkSums& sums, AssemblyNumbers& numbers, ChunkOutcome& outcome) {
    AssemblyNumbers n = numbers;
    if (request.substeps > 0) {
        move_cell(n, cell);
        n.last_sub_step = request.sub_step;
    }
    ChunkLedger ledger = sums.ledger;
    if (request.ledger && request.substeps > 0) { // see WorkLedger: what the last sub-step's forces owe
        const Symmetric g = outcome.last_stretch.change_seen_from_the_end();
        ledger.work += request.sub_step * (sums.discs.force_xx * g.xx + sums.discs.force_yy * g.yy + 2 * sums.discs.force_xy * g.xy) / 2;
    }
    n.friction_dissipation += ledger.friction;
    n.bond_dissipation += ledger.bond;
    n.damping_dissipation += ledger.damping;
    n.work += ledger.work;
    if (request.give_back) n.displacement_bound = std::sqrt(sums.discs.largest_drift_squared);

    Virial<double> virial = sums.contacts.virial;
    virial.xx += sums.discs.fluctuation.xx, virial.yy += sums.discs.fluctuation.yy, virial.xy += sums.discs.fluctuation.xy;
    const double area = std::abs(n.cell_xx * n.cell_yy - n.cell_xy * n.cell_yx), volume = area * n.thickness; // m^2, m^3
    const Virial<double> stress = virial.stress(volume).turned(std::cos(n.frame_angle), std::sin(n.frame_angle));
    const auto count = static_cast<double>(n.disc_count);
    Answer& answer = outcome.answer;
    answer.contacts = static_cast<int>(sums.contacts.contacts);
    answer.bonds = static_cast<int>(sums.contacts.bonds);
    answer.stored_energy = sums.contacts.stored_energy;
    answer.stress = {stress.xx, stress.yy, stress.xy};
    answer.stiffness = stiffness_bound(sums.contacts, law, volume);
    answer.coordination_number = 2.0 * answer.contacts / count;
    answer.broken_bonds = static_cast<int>(n.activated_bonds) - answer.bonds;
    answer.unbalanced_force = sums.contacts.force > 0 ? sums.discs.unbalanced / count / (sums.contacts.force / answer.contacts) : 0; // mean |F| / mean |f|; bonds may be without force
    answer.kinetic_energy = sums.discs.kinetic;
    answer.friction_dissipation = n.friction_dissipation;
    answer.damping_dissipation = n.damping_dissipation;
    answer.bond_dissipation = n.bond_dissipation;
    answer.work = n.work;
    answer.cell_area = area;
    answer.void_ratio = area / n.disc_area - 1;
    answer.split_steps = static_cast<int>(n.split_steps);
    const double check = stress.xx + stress.yy + stress.xy + answer.kinetic_energy + answer.stored_energy + area;
    answer.status = check - check == 0 ? Status::ok : Status::not_finite;
    if (request.give_back) numbers = n;
}

} // namespace talik::farm
