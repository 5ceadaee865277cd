#include "common/scene/schema.hpp"

namespace talik::scene {

void Place::fault(const std::string& name, const std::string& problem, const std::string& remedy) const {
    const Value* at = value.find(name);
    faults.push_back({at ? at->position : value.position, joined(key, name), problem, remedy});
}

std::string kind_of(Dimension dimension) {
    if (dimension == Dimension::none) return "number";
    return fmt::format("{} ({})", name_of(dimension), fmt::join(accepted_units(dimension), ", "));
}

std::string kind_of(const std::vector<std::string>& choices) { return fmt::format("\"{}\"", fmt::join(choices, "\" or \"")); }

std::string standard_text(double value, Dimension dimension) {
    return dimension == Dimension::none ? fmt::format("{:g}", value) : fmt::format("{:g} {}", value, si_unit(dimension));
}

std::string literal_list(const double* values, std::size_t count) {
    std::string list;
    for (std::size_t i = 0; i < count; ++i) list += (i ? ", " : "") + literal(values[i]);
    return "[" + list + "]";
}

} // namespace talik::scene
