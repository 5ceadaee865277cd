#pragma once
// What an RVE answers: stress, energies and numbers of its present state. Every sum runs in list order.
#include "rve-farm/assembly/columns.hpp"
#include "rve-farm/assembly/answer.hpp"
#include "rve-farm/physics/contact.hpp"

namespace talik::farm {

Answer measure(const AssemblyView& s, const ColumnChoice& columns, const ContactLaw<double>& contact);

// Cell area, m^2.
double cell_area(const AssemblyNumbers& numbers);

} // namespace talik::farm
