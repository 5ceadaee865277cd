#pragma once
// What one RVE answers after a macro step. Energies, work and counts of events are cumulative since it was made.
#include <array>
#include <limits>

namespace talik::farm {

// A fault inside a kernel is a value of this, never a crash; it travels back through the exchange to whoever asked.
enum class Status : int {
    ok = 0,
    not_finite = 1,        // a NaN or an infinite number, or discs that moved a good part of their radius in a sub-step
    contact_list_full = 2, // more neighbours than there is room for
    unstable_step = 3,     // the sub-step is beyond 2/(omega_max sqrt(1 + alpha)) of the contact network; the state is left as it was
    bad_request = 4        // a strain or ice that is no number, or more strain than a step can be; the state is left as it was
};

constexpr const char* name_of(Status status) {
    switch (status) {
    case Status::ok: return "ok";
    case Status::not_finite: return "not_finite";
    case Status::contact_list_full: return "contact_list_full";
    case Status::unstable_step: return "unstable_step";
    case Status::bad_request: return "bad_request";
    }
    return "unknown";
}

struct Answer {
    std::array<double, 3> stress = {0, 0, 0}; // sxx syy sxy, Pa, tension positive, in fixed axes (Eq. 49)
    Status status = Status::ok;
    double stiffness = 0;            // upper bound of the P-wave modulus of the present contacts, Pa; 0 without contacts
    double coordination_number = 0;  // Z = 2 Nc / N over the contacts that carry force
    int contacts = 0;                // Nc
    int bonds = 0;                   // intact
    int broken_bonds = 0;            // since the RVE was made
    double unbalanced_force = 0;     // mean |force on a disc| / mean |contact force|, -; 0 without contacts
    double stored_energy = 0;        // of normal and tangential springs, J
    double kinetic_energy = 0;       // of the non-affine motion, translation and rotation, J
    double friction_dissipation = 0; // J
    double damping_dissipation = 0;  // J
    double bond_dissipation = 0;     // energy lost when bonds broke, J
    double work = 0;                 // V sigma : D dt, J. work = d stored + d kinetic + friction + damping + bond
    double cell_area = 0;            // m^2 (times the thickness: the volume V)
    double void_ratio = 0;           // A_cell / sum(pi r^2) - 1
    int split_steps = 0;             // macro steps that took more sub-steps than asked for, since the RVE was made
    double largest_stable_step = std::numeric_limits<double>::infinity(); // set where status is unstable_step, s
};

} // namespace talik::farm
