#pragma once
// Brittle ice bonds, Eqs. (6)-(8) of the paper. "No bonds" is a member of the family with nothing in it.
#include "rve-farm/physics/contact.hpp"

namespace talik::farm {

struct NoBond {
    static constexpr bool exists = false; // no column, no code
};

// While bonded the normal spring acts in tension too and the tangential force is not cut at the Coulomb limit.
template <class Real>
struct BrittleBond {
    static constexpr bool exists = true;
    Real normal_strength;     // c_n, Pa
    Real tangential_strength; // c_t, Pa

    // The bond breaks for good once the tension exceeds F_nb = beta_b c_n r^2 (Eq. 6) or the shear F_tb = beta_b c_t r^2
    // (Eq. 7), r the smaller radius, m. Compression alone never breaks it.
    TALIK_HOST_DEVICE auto breaks(ContactForce<Real> force, Real smaller_radius, Real beta) const {
        const Real area = beta * smaller_radius * smaller_radius; // beta_b r^2, m^2
        return (-force.normal > normal_strength * area) | (magnitude(force.tangential) > tangential_strength * area);
    }
};

} // namespace talik::farm
