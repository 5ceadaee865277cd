#pragma once
// The largest stable step of leapfrog, 2/omega_max of the contact network M^-1 K: both springs of every contact, on the
// translations and the rotation of its discs. (2 sqrt(m/k) of a single contact would allow three to four times as much.)
#include "rve-farm/assembly/columns.hpp"
#include "rve-farm/physics/contact.hpp"

namespace talik::farm {

// Three estimates of omega_max^2, 1/s^2, from cheap and safe to dear and sharp.
// 1. Gershgorin, in any direction, with every candidate of the list counted as a contact: holds until the next rebuild.
double omega_squared_bound_of_list(const AssemblyView& s, const ContactLaw<double>& contact);
// 2. Gershgorin, of the contacts that carry force now.
double omega_squared_bound_of_contacts(const AssemblyView& s, const ContactLaw<double>& contact);
// 3. Power iteration on the contacts that carry force now; from below, to 1e-4.
double omega_squared_of_contacts(const AssemblyView& s, const ContactLaw<double>& contact);

double stable_step(double omega_squared); // 2 / omega, s; infinite without contacts

// Is sub_step, lengthened by shortening_by_damping(), within 2/omega_max? Asks the cheapest estimate that can say yes.
bool is_stable_by_list(AssemblyView& s, const ContactLaw<double>& contact, double sub_step); // by the first alone, which needs no positions
bool is_stable(AssemblyView& s, const ContactLaw<double>& contact, double sub_step);

} // namespace talik::farm
