#pragma once
// The material points, one column per quantity. A point's index is its id, and the id of its RVE.
#include <cstdint>
#include <string>
#include <vector>

#include "common/math/matrix.hpp"
#include "mpm-driver/points/state_column.hpp"

namespace talik::driver {

using Stress = Eigen::Vector3d; // Cauchy stress sxx, syy, sxy, Pa, tension positive

// What a law has booked for a point since its material was made, J, cumulative (kinetic: of the RVE's discs, now).
struct LawEnergy {
    double stored = 0.0;              // elastic energy
    double kinetic = 0.0;             // energy of the motion below the point's scale
    double friction_dissipation = 0.0;
    double damping_dissipation = 0.0;
    double bond_dissipation = 0.0;

    double total() const { return stored + kinetic + friction_dissipation + damping_dissipation + bond_dissipation; }
};

struct Points {
    // Set when the points are seeded.
    std::vector<int> body;                // index of the body in the scene
    std::vector<int> law;                 // index of the law that answers for the point
    std::vector<double> mass;             // m_p, kg
    std::vector<double> initial_volume;   // V_p^0, m^3
    std::vector<Vector> initial_position; // m
    std::vector<double> initial_p_wave_modulus; // M at the start, Pa: set by the laws

    bool mechanical = true; // false: at rest; the columns of mechanics are empty

    // The state that steps change.
    std::vector<Vector> position;         // x_p, m
    std::vector<Vector> velocity;         // v_p, m/s
    std::vector<Matrix> deformation;      // deformation gradient F_p, - (column-major: xx yx xy yy)
    std::vector<double> volume;           // V_p = det(F) V_p^0, m^3
    std::vector<Stress> stress;           // Pa
    std::vector<double> p_wave_modulus;   // M, Pa: the law's stiffness against the fastest wave
    std::vector<LawEnergy> energy;        // J

    // Where the scene has heat (sized by the heat solver); the last three are what it publishes.
    std::vector<double> enthalpy;         // E_p, J: zero where all is thawed at T0
    std::vector<double> temperature;      // T_p, degrees C
    std::vector<double> ice_saturation;   // S_i = theta_s / (theta_s + theta_f), -
    std::vector<double> ice_fraction;     // theta_s, of the present volume, -

    // Of the present step only.
    std::vector<Matrix> displacement_gradient_increment; // dt grad v, - (column-major)

    std::size_t count() const { return position.size(); }
    void resize(std::size_t count);

    Vector displacement(std::size_t p) const { return position[p] - initial_position[p]; } // u_p, m
    double density(std::size_t p) const { return mass[p] / volume[p]; }                     // kg/m^3

    // The columns that steps change, for checkpoints: all that a bit-exact restart needs beside the scene.
    std::vector<StateColumn> state();
};

} // namespace talik::driver
