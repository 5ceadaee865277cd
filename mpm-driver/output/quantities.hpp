#pragma once
// What a run reports of its state: the columns of history.csv and of the fields, in one place.
#include <string>
#include <vector>

#include "mpm-driver/mechanics/simulation.hpp"
#include "mpm-driver/output/fields.hpp"

namespace talik::driver {

// One number of the history: its column's name carries the unit.
struct HistoryValue {
    std::string name;
    double value;
};
// In fixed order for one scene: stage, walls, means over the bodies, energies, balances.
std::vector<HistoryValue> history_values(const Simulation& simulation);

// All point quantities, positions first; the laws' own columns last.
std::vector<FieldColumn> field_columns(const Simulation& simulation);

} // namespace talik::driver
