#include "mpm-driver/points/points.hpp"

namespace talik::driver {

static_assert(sizeof(LawEnergy) == 5 * sizeof(double), "a column of doubles");

void Points::resize(std::size_t n) {
    body.resize(n, 0);
    mass.resize(n, 0.0);
    initial_volume.resize(n, 0.0);
    initial_position.resize(n, Vector::Zero());
    position.resize(n, Vector::Zero());
    volume.resize(n, 0.0);
    if (!mechanical) return;
    law.resize(n, 0);
    velocity.resize(n, Vector::Zero());
    deformation.resize(n, Matrix::Identity());
    stress.resize(n, Stress::Zero());
    p_wave_modulus.resize(n, 0.0);
    initial_p_wave_modulus.resize(n, 0.0);
    energy.resize(n);
    displacement_gradient_increment.resize(n, Matrix::Zero());
}

std::vector<StateColumn> Points::state() {
    const std::size_t n = count();
    const std::vector<std::string> scalar = {""}, vector = {"x", "y"}, matrix = {"xx", "yx", "xy", "yy"};
    std::vector<StateColumn> columns;
    const auto add = [&](const char* name, const char* unit, const char* meaning, const std::vector<std::string>& components, auto& column) {
        if (!column.empty()) columns.push_back({std::string("points/") + name, unit, meaning, components, reinterpret_cast<double*>(column.data()), n});
    };
    add("position", "m", "position of the point", vector, position);
    add("velocity", "m/s", "velocity of the point", vector, velocity);
    add("deformation_gradient", "-", "deformation gradient since the start", matrix, deformation);
    add("volume", "m3", "volume of the point", scalar, volume);
    add("stress", "Pa", "Cauchy stress, tension positive", {"xx", "yy", "xy"}, stress);
    add("p_wave_modulus", "Pa", "stiffness against the fastest wave", scalar, p_wave_modulus);
    add("law_energy", "J", "energies booked by the point's law",
        {"stored", "kinetic", "friction_dissipation", "damping_dissipation", "bond_dissipation"}, energy);
    add("displacement_gradient_increment", "-", "dt grad v of the last step", matrix, displacement_gradient_increment);
    add("enthalpy", "J", "heat of the point, zero where all is thawed at T0", scalar, enthalpy);
    add("temperature", "C", "temperature", scalar, temperature);
    add("ice_saturation", "-", "ice in the water of the pores", scalar, ice_saturation);
    add("ice_fraction", "-", "ice in the volume", scalar, ice_fraction);
    return columns;
}

} // namespace talik::driver
