#include "common/scene/units.hpp"

#include <array>
#include <cmath>
#include <cstdlib>

#include <fmt/format.h>

namespace talik::scene {
namespace {

// value in SI = number * 10^exponent * times / over. The power of ten is put into the text before it is read, so that
// "2.5 mm" and 2.5e-3 are the same bits.
struct Unit {
    std::string_view text;
    Dimension dimension;
    int exponent = 0;
    double times = 1.0, over = 1.0;
};

using enum Dimension;

// The SI unit of each dimension comes first.
constexpr std::array units = {
    Unit{"-", none}, Unit{"%", none, -2},
    Unit{"m", length}, Unit{"mm", length, -3}, Unit{"cm", length, -2}, Unit{"um", length, -6}, Unit{"km", length, 3},
    Unit{"s", time}, Unit{"ms", time, -3}, Unit{"us", time, -6}, Unit{"min", time, 0, 60.0}, Unit{"h", time, 0, 3600.0}, Unit{"d", time, 0, 86400.0},
    Unit{"m/s", velocity}, Unit{"mm/s", velocity, -3}, Unit{"cm/s", velocity, -2}, Unit{"mm/min", velocity, -3, 1.0, 60.0}, Unit{"m/d", velocity, 0, 1.0, 86400.0},
    Unit{"m/s^2", acceleration}, Unit{"m/s2", acceleration},
    Unit{"Pa", pressure}, Unit{"kPa", pressure, 3}, Unit{"MPa", pressure, 6}, Unit{"GPa", pressure, 9},
    Unit{"N", force}, Unit{"kN", force, 3}, Unit{"mN", force, -3},
    Unit{"N/m", stiffness}, Unit{"kN/m", stiffness, 3}, Unit{"MN/m", stiffness, 6}, Unit{"N/mm", stiffness, 3},
    Unit{"kg/m^3", density}, Unit{"kg/m3", density}, Unit{"g/cm^3", density, 3}, Unit{"t/m^3", density, 3},
    Unit{"1/s", rate}, Unit{"1/min", rate, 0, 1.0, 60.0}, Unit{"1/h", rate, 0, 1.0, 3600.0}, Unit{"%/s", rate, -2}, Unit{"%/min", rate, -2, 1.0, 60.0},
    Unit{"rad", angle}, Unit{"deg", angle, 0, 3.14159265358979323846, 180.0},
    Unit{"C", temperature}, Unit{"degC", temperature}, Unit{"K", temperature_difference}, Unit{"mK", temperature_difference, -3},
    Unit{"W/(m K)", conductivity}, Unit{"J/(kg K)", heat_capacity}, Unit{"kJ/(kg K)", heat_capacity, 3},
    Unit{"J/kg", latent_heat}, Unit{"kJ/kg", latent_heat, 3}, Unit{"W/m^2", heat_flux}, Unit{"W/m2", heat_flux}, Unit{"mW/m^2", heat_flux, -3},
    Unit{"W/m^3", power_density}, Unit{"W/m3", power_density}, Unit{"kW/m^3", power_density, 3},
};

std::string_view trimmed(std::string_view text) {
    const auto first = text.find_first_not_of(" \t");
    return first == std::string_view::npos ? std::string_view() : text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

std::string how_to_write(Dimension dimension) {
    return fmt::format("give {} in {}, or a bare number in {}", one(dimension), fmt::join(accepted_units(dimension), ", "), si_unit(dimension));
}

// "2.5" with exponent -3 is read as "2.5e-3"; "1e6" with 3 as "1e9".
double scaled(const std::string& number, int exponent) {
    const auto e = number.find_first_of("eE");
    const int own = e == std::string::npos ? 0 : std::atoi(number.c_str() + e + 1);
    return std::strtod((number.substr(0, e) + "e" + std::to_string(own + exponent)).c_str(), nullptr);
}

} // namespace

std::string_view name_of(Dimension dimension) {
    constexpr std::array names = {"number", "length", "time", "velocity", "acceleration", "pressure", "force", "stiffness", "density", "rate", "angle",
                                  "temperature", "temperature difference", "conductivity", "heat capacity", "latent heat", "heat flux", "power density"};
    return names[static_cast<std::size_t>(dimension)];
}

std::string one(Dimension dimension) {
    return fmt::format("{} {}", name_of(dimension).front() == 'a' ? "an" : "a", name_of(dimension));
}

std::string_view si_unit(Dimension dimension) {
    for (const Unit& unit : units)
        if (unit.dimension == dimension) return unit.text;
    return "-";
}

std::vector<std::string_view> accepted_units(Dimension dimension) {
    std::vector<std::string_view> texts;
    for (const Unit& unit : units)
        if (unit.dimension == dimension) texts.push_back(unit.text);
    return texts;
}

ReadQuantity read_quantity(const std::string& text, Dimension dimension) {
    char* end = nullptr;
    const double bare = std::strtod(text.c_str(), &end);
    const std::string number(trimmed(std::string_view(text.c_str(), static_cast<std::size_t>(end - text.c_str()))));
    const std::string_view unit_text = trimmed(end);
    const bool decimal = number.find_first_of("xXnN") == std::string::npos; // no hexadecimals, no "inf", no "nan"
    if (number.empty() || !decimal) return {0.0, fmt::format("\"{}\" does not begin with a number", text), how_to_write(dimension)};
    if (!std::isfinite(bare)) return {0.0, fmt::format("\"{}\" is too large a number", text), how_to_write(dimension)};
    if (unit_text.empty()) return {bare, "", ""};
    for (const Unit& unit : units)
        if (unit.text == unit_text && unit.dimension == dimension) return {scaled(number, unit.exponent) * unit.times / unit.over, "", ""};
    for (const Unit& unit : units)
        if (unit.text == unit_text) return {0.0, fmt::format("\"{}\" is {}, not {}", text, one(unit.dimension), one(dimension)), how_to_write(dimension)};
    return {0.0, fmt::format("\"{}\" has an unknown unit \"{}\"", text, unit_text), how_to_write(dimension)};
}

} // namespace talik::scene
