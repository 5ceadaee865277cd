#include "rve-farm/physics/physics.hpp"

#include "common/base/error.hpp"

namespace talik::farm {
void check(const RveParameters& parameters) {
    const ContactParameters& c = parameters.contact;
    require(c.normal_stiffness > 0, "the normal stiffness of a contact is not positive", "give it in N/m, for example 1e6");
    require(c.tangential_stiffness > 0, "the tangential stiffness of a contact is not positive",
            "give it in N/m; for frictionless discs set the friction to 0 instead");
    require(c.friction >= 0, "the friction is negative", "give a coefficient of 0 or more");
    require(parameters.grain_density > 0, "the grain density is not positive", "give it in kg/m^3, for example 2650");
    require(parameters.thickness > 0, "the thickness of the discs is not positive", "give it in m, for example 0.1");
    require(parameters.damping >= 0 && parameters.damping < 1, "the local damping is outside [0, 1)", "0.2 is usual");
    require(parameters.time_step > 0, "the DEM time step is not positive", "give it in s, for example 1e-5");
    require(parameters.substeps >= 0, "the number of DEM sub-steps is negative", "0 chooses it from the time step");
    require(parameters.skin >= 0, "the skin of the neighbour list is negative", "0 chooses it from the mean radius");
    if (!parameters.bond) return;
    const BondParameters& b = *parameters.bond;
    require(b.normal_strength >= 0 && b.tangential_strength >= 0 && b.strength_factor >= 0,
            "a bond strength is negative", "give strengths in Pa and the factor beta_a, 0 or more");
}

} // namespace talik::farm
