#pragma once
// From the parameters of an RVE to the type that says what acts in it, in the number that a kernel computes with.
#include "rve-farm/physics/physics.hpp"

namespace talik::farm {

TALIK_HOST_DEVICE ContactLaw<double> contact_law_of(const RveParameters& p) {
    return {p.contact.normal_stiffness, p.contact.tangential_stiffness, p.contact.friction};
}

// visit(physics): one of eight types, each with the code of its effects and no other.
template <class Real, class Visitor>
TALIK_HOST_DEVICE void with_physics(const RveParameters& p, Visitor&& visit) {
    const ContactLaw<Real> contact{Real(p.contact.normal_stiffness), Real(p.contact.tangential_stiffness), Real(p.contact.friction)};
    const auto fluctuating = [&](auto bond, auto damping) {
        if (p.fluctuation_stress) visit(Physics<decltype(bond), decltype(damping), KineticFluctuation, Real>{contact, bond, damping, {}});
        else visit(Physics<decltype(bond), decltype(damping), NoFluctuation, Real>{contact, bond, damping, {}});
    };
    const auto damped = [&](auto bond) {
        if (p.damping > 0) fluctuating(bond, LocalDamping<Real>{Real(p.damping)});
        else fluctuating(bond, NoDamping{});
    };
    if (p.bond) damped(BrittleBond<Real>{Real(p.bond->normal_strength), Real(p.bond->tangential_strength)});
    else damped(NoBond{});
}

} // namespace talik::farm
