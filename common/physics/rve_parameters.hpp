#pragma once
// What the material of an RVE is, apart from where its discs lie: read from a scene or a test specification, carried by
// the exchange to the farm. SI units; absent effects are empty optionals, and cost nothing.
#include <optional>
#include <string>

namespace talik {

struct ContactParameters {
    double normal_stiffness = 1e6;     // k_n, N/m
    double tangential_stiffness = 1e6; // k_t, N/m
    double friction = 0.5;             // mu, -
};

// Eqs. (6)-(8): strengths F_nb = beta_b c_n r^2, F_tb = beta_b c_t r^2 (r the smaller radius), beta_b = beta_a S_i.
struct BondParameters {
    double normal_strength = 1e7;     // c_n, Pa
    double tangential_strength = 1e7; // c_t, Pa
    double strength_factor = 1.0;     // beta_a, -: the strength at full ice saturation
    // Bonds form anew at the contacts present once S_i, having been below the threshold, reaches it again.
    bool rebond_on_freezing = false;
    double rebond_ice_saturation = 0.5; // the threshold, -

    double strength_at(double ice_saturation) const { return strength_factor * ice_saturation; } // beta_b = beta_a S_i (Eq. 8), -
};

struct RveParameters {
    ContactParameters contact;
    std::optional<BondParameters> bond;
    double grain_density = 2650.0;   // kg/m^3
    double thickness = 0.1;          // t, m
    double damping = 0.2;            // local non-viscous damping of the non-affine motion, -; 0 = none
    bool fluctuation_stress = false; // the kinetic part -(1/V) sum m v_f v_f of the stress, and its reaction on v_f
    double time_step = 1e-5;         // largest DEM sub-step, s: n = ceil(dt_macro / time_step)
    int substeps = 0;                // sub-steps per macro step where the scene fixes them; 0 = from time_step
    double skin = 0.0;               // of the neighbour list, m; 0 = chosen as it goes, from how fast it is used up
    std::string precision = "double"; // of the kernels, "double" or "single"; the state is double always
};

} // namespace talik
