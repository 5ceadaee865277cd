#pragma once
// What acts in an RVE, as a type: chosen once per farm, so that an absent effect has no code in the loop.
#include <variant>

#include "common/physics/rve_parameters.hpp"
#include "rve-farm/physics/bond.hpp"
#include "rve-farm/physics/contact.hpp"
#include "rve-farm/physics/damping.hpp"
#include "rve-farm/physics/fluctuation.hpp"

namespace talik::farm {

template <class BondLaw, class DampingLaw, class FluctuationLaw>
struct Physics {
    ContactLaw<double> contact;
    BondLaw bond;
    DampingLaw damping;
    FluctuationLaw fluctuation;
};

using AnyPhysics = std::variant<Physics<NoBond, NoDamping, NoFluctuation>, //
                                Physics<NoBond, NoDamping, KineticFluctuation>,
                                Physics<NoBond, LocalDamping<double>, NoFluctuation>,
                                Physics<NoBond, LocalDamping<double>, KineticFluctuation>,
                                Physics<BrittleBond<double>, NoDamping, NoFluctuation>,
                                Physics<BrittleBond<double>, NoDamping, KineticFluctuation>,
                                Physics<BrittleBond<double>, LocalDamping<double>, NoFluctuation>,
                                Physics<BrittleBond<double>, LocalDamping<double>, KineticFluctuation>>;

AnyPhysics choose_physics(const RveParameters& parameters);

// Refuses impossible mixes and values without meaning, all in one place.
void check(const RveParameters& parameters);

} // namespace talik::farm
