#pragma once
// What acts in an RVE, as a type: chosen once per chunk, so that an absent effect has no code in the loop.
#include "common/physics/rve_parameters.hpp"
#include "rve-farm/physics/bond.hpp"
#include "rve-farm/physics/contact.hpp"
#include "rve-farm/physics/damping.hpp"
#include "rve-farm/physics/fluctuation.hpp"

namespace talik::farm {

template <class BondLaw, class DampingLaw, class FluctuationLaw, class Real = double>
struct Physics {
    static constexpr bool with_bonds = BondLaw::exists, with_damping = DampingLaw::exists, with_fluctuation = FluctuationLaw::exists;

    ContactLaw<Real> contact;
    BondLaw bond;
    DampingLaw damping;
    FluctuationLaw fluctuation;
};

// Refuses impossible mixes and values without meaning, all in one place.
void check(const RveParameters& parameters);

} // namespace talik::farm
