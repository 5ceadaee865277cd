#pragma once
// The kinetic part of the stress and its reaction on the motion: both or neither, so that the energy closes either way.
#include "common/team/cpu_team.hpp"

namespace talik::farm {

// Slow flow: sigma = -(1/V) sum f x b, m dv_f/dt = F.
struct NoFluctuation {
    static constexpr bool exists = false;
};

// Fast flow: sigma = -(1/V) (sum f x b + sum m v_f x v_f), and m dv_f/dt = F - m D v_f: the power -sum m v_f D v_f that
// the kinetic stress takes from the boundary is what the discs lose or gain by it.
struct KineticFluctuation {
    static constexpr bool exists = true;
};

} // namespace talik::farm
