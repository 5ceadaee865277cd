#pragma once
// A named view of doubles that belong to the state. One list of them serves checkpoints, restarts and output.
#include <string>
#include <vector>

namespace talik::driver {

struct StateColumn {
    std::string name;                    // "points/velocity", "ledger/kinetic_energy"
    std::string unit;                    // "m/s"
    std::string meaning;                 // one short line
    std::vector<std::string> components; // {""} for a scalar, {"x", "y"}, {"xx", "yy", "xy"}, ...: the order in memory
    double* data = nullptr;              // rows x components, one row after the other
    std::size_t rows = 0;

    std::size_t size() const { return rows * components.size(); }
};

} // namespace talik::driver
