#include "mpm-driver/points/points.hpp"

namespace talik::driver {

static_assert(sizeof(LawEnergy) == 5 * sizeof(double), "a column of doubles");

void Points::resize(std::size_t n) {
    body.resize(n, 0);
    law.resize(n, 0);
    mass.resize(n, 0.0);
    initial_volume.resize(n, 0.0);
    initial_position.resize(n, Vector::Zero());
    position.resize(n, Vector::Zero());
    velocity.resize(n, Vector::Zero());
    deformation.resize(n, Matrix::Identity());
    volume.resize(n, 0.0);
    stress.resize(n, Stress::Zero());
    p_wave_modulus.resize(n, 0.0);
    initial_p_wave_modulus.resize(n, 0.0);
    energy.resize(n);
    displacement_gradient_increment.resize(n, Matrix::Zero());
}

std::vector<StateColumn> Points::state() {
    const std::size_t n = count();
    const std::vector<std::string> scalar = {""}, vector = {"x", "y"}, matrix = {"xx", "yx", "xy", "yy"};
    const auto doubles = [](auto& column) { return column.empty() ? nullptr : reinterpret_cast<double*>(column.data()); };
    return {
        {"points/position", "m", "position of the point", vector, doubles(position), n},
        {"points/velocity", "m/s", "velocity of the point", vector, doubles(velocity), n},
        {"points/deformation_gradient", "-", "deformation gradient since the start", matrix, doubles(deformation), n},
        {"points/volume", "m3", "volume of the point", scalar, doubles(volume), n},
        {"points/stress", "Pa", "Cauchy stress, tension positive", {"xx", "yy", "xy"}, doubles(stress), n},
        {"points/p_wave_modulus", "Pa", "stiffness against the fastest wave", scalar, doubles(p_wave_modulus), n},
        {"points/law_energy", "J", "energies booked by the point's law",
         {"stored", "kinetic", "friction_dissipation", "damping_dissipation", "bond_dissipation"}, doubles(energy), n},
        {"points/displacement_gradient_increment", "-", "dt grad v of the last step", matrix,
         doubles(displacement_gradient_increment), n},
    };
}

} // namespace talik::driver
