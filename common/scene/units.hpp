#pragma once
// Values with units as text: "100 kPa", "2.5 mm", "20 d", "0.02 m/s", "1e6 N/m". A bare number means SI.
#include <string>
#include <string_view>
#include <vector>

namespace talik::scene {

enum class Dimension { none, length, time, velocity, acceleration, pressure, force, stiffness, density, rate, angle,
                       temperature, temperature_difference, conductivity, heat_capacity, latent_heat, heat_flux, power_density };

std::string_view name_of(Dimension);                    // "pressure"
std::string one(Dimension);                             // "a pressure", "an angle"
std::string_view si_unit(Dimension);                    // "Pa"; "-" where there is none
std::vector<std::string_view> accepted_units(Dimension);

// The value in SI, or the fault: what is wrong and what to write instead.
struct ReadQuantity {
    double value = 0.0;
    std::string problem, remedy; // empty = sound
};
ReadQuantity read_quantity(const std::string& text, Dimension);

} // namespace talik::scene
