#pragma once
// What the text of a law needs from a number besides + - * /: it is written once, for a float, a double, or a pack of
// lanes (lanes.hpp), which bring functions of the same names.
#include <cmath>
#include <concepts>

#include "common/team/cpu_team.hpp"

namespace talik::farm {

template <std::floating_point Real>
TALIK_HOST_DEVICE Real larger(Real a, Real b) { return a > b ? a : b; }
template <std::floating_point Real>
TALIK_HOST_DEVICE Real smaller(Real a, Real b) { return a < b ? a : b; }
template <std::floating_point Real>
TALIK_HOST_DEVICE Real magnitude(Real a) { return a < 0 ? -a : a; }
// The number brought back to at most `limit` >= 0 either way.
template <std::floating_point Real>
TALIK_HOST_DEVICE Real within(Real limit, Real a) { return smaller(larger(a, -limit), limit); }
// |a| with the sign of b.
template <std::floating_point Real>
TALIK_HOST_DEVICE Real with_sign_of(Real a, Real b) { return std::copysign(a, b); }
template <std::floating_point Real>
TALIK_HOST_DEVICE Real root(Real a) { return std::sqrt(a); }
template <std::floating_point Real>
TALIK_HOST_DEVICE Real choose(bool condition, Real yes, Real no) { return condition ? yes : no; }

// The scalar behind a number: of a pack, what its lanes hold.
template <class Real>
struct ScalarOf { using Type = Real; };
template <class Real>
using Scalar = typename ScalarOf<Real>::Type;

} // namespace talik::farm
