#pragma once
// From what a launch asks for to the types that a block is compiled for. Local damping is always there, with a coefficient of 0
// where the scene has none, which changes no bit of a force: half as many instances.
#include <type_traits>

#include "rve-farm/block/device.hpp"
#include "rve-farm/physics/physics_choice.hpp"

namespace talik::farm {

// visit(ledger, spread, physics, Real()): ledger and spread are std::bool_constants.
template <class Real, class Visitor>
void visit_block_physics_in(const BlockLaunch& launch, Visitor&& visit) {
    const RveParameters& p = *launch.parameters;
    const ContactLaw<Real> contact{Real(p.contact.normal_stiffness), Real(p.contact.tangential_stiffness), Real(p.contact.friction)};
    const LocalDamping<Real> damping{Real(p.damping)};
    const auto with = [&](auto ledger, auto spread, auto bond, auto fluctuation) {
        visit(ledger, spread, Physics<decltype(bond), LocalDamping<Real>, decltype(fluctuation), Real>{contact, bond, damping, fluctuation}, Real());
    };
    const auto bonded = [&](auto ledger, auto spread, auto fluctuation) {
        if (p.bond) with(ledger, spread, BrittleBond<Real>{Real(p.bond->normal_strength), Real(p.bond->tangential_strength)}, fluctuation);
        else with(ledger, spread, NoBond{}, fluctuation);
    };
    const auto fluctuating = [&](auto ledger, auto spread) {
        if (p.fluctuation_stress) bonded(ledger, spread, KineticFluctuation{});
        else bonded(ledger, spread, NoFluctuation{});
    };
    const auto spreading = [&](auto ledger) {
        if (launch.spread) fluctuating(ledger, std::true_type{});
        else fluctuating(ledger, std::false_type{});
    };
    if (launch.ledger) spreading(std::true_type{});
    else spreading(std::false_type{});
}

template <class Visitor>
void visit_block_physics(const BlockLaunch& launch, Visitor&& visit) {
    if (launch.precision == Precision::single_) visit_block_physics_in<float>(launch, visit);
    else visit_block_physics_in<double>(launch, visit);
}

} // namespace talik::farm
