#pragma once
// Numbers that are none, found and named. Sums are looked at in every step, since a NaN or an infinite number poisons them;
// only then is it searched for.
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mpm-driver/points/state_column.hpp"

namespace talik::driver {

// 0, or not a number where x is none or infinite.
inline double poison(double x) { return 0.0 * x; }

struct NotFinite {
    std::string column, component; // "points/stress", "yy"
    std::size_t row = 0;
    double value = 0.0;

    std::string words() const; // "stress (yy) is nan"
};

std::optional<NotFinite> first_not_finite(std::span<const StateColumn> columns);

} // namespace talik::driver
