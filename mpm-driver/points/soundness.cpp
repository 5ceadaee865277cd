#include "mpm-driver/points/soundness.hpp"

#include <cmath>

#include <fmt/format.h>

namespace talik::driver {

std::string NotFinite::words() const {
    const std::string name = column.substr(column.find('/') + 1);
    return fmt::format("{}{} is {}", name, component.empty() ? "" : " (" + component + ")", value);
}

std::optional<NotFinite> first_not_finite(std::span<const StateColumn> columns) {
    for (const StateColumn& column : columns)
        for (std::size_t k = 0; k < column.size(); ++k)
            if (!std::isfinite(column.data[k])) return NotFinite{column.name, column.components[k % column.components.size()], k / column.components.size(), column.data[k]};
    return std::nullopt;
}

} // namespace talik::driver
