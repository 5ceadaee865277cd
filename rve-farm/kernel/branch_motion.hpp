#pragma once
// How a branch has changed since the start of a chunk, from the motion of its end along its first direction n0 and across:
// differences of small numbers never come from large ones, so that floats keep every digit of a slow thaw.
#include "rve-farm/physics/real.hpp"

namespace talik::farm {

template <class Real>
constexpr bool is_single = sizeof(Scalar<Real>) == 4;

// The series below hold while branches turn and stretch by at most this since the start of a chunk (advance keeps to it by
// the length of its chunks), rad and strain: what they leave out is then of the size of a rounding, at most 2e-9 rad of an
// angle, 2e-8 of a stretch and 3e-9 of a length in single, 9e-15 in double.
template <class Real>
constexpr double largest_turn_of_a_branch = is_single<Real> ? 0.06 : 0.02;

// 1 / (1 + e). In float by its series, which is off by e^8 < 2e-10 of itself: no division, whose latency is the longest of the
// whole contact.
template <class Real>
TALIK_HOST_DEVICE Real reciprocal_of_one_plus(Real e) {
    if constexpr (is_single<Real>) {
        const Real squared = e * e, f = Real(1) - e, g = f + f * squared;
        return g + g * (squared * squared); // (1 - e)(1 + e^2)(1 + e^4)
    } else {
        return Real(1) / (Real(1) + e);
    }
}

template <class Real>
struct BranchMotion {
    Real strain;          // |b| / |b0| - 1, -
    Real inverse_stretch; // |b0| / |b|, -
    Real tangent, arcus;  // q = tan of the angle from n0 to n, counter-clockwise; atan(q) / q - 1

    // along, across: components of (b - b0) / |b0| along n0 and t0 = (-n0_y, n0_x), -.
    // With q = across / (1 + along): |b| / |b0| = (1 + along) sqrt(1 + q^2), angle = atan q.
    TALIK_HOST_DEVICE BranchMotion(Real along, Real across) {
        const Real reciprocal = reciprocal_of_one_plus(along), q = across * reciprocal, u = q * q;
        Real root, inverse_root; // sqrt(1 + u) - 1, 1 / sqrt(1 + u) - 1
        if constexpr (is_single<Real>) {
            root = u * (Real(1.0 / 2) - u * Real(1.0 / 8));
            inverse_root = u * (Real(-1.0 / 2) + u * Real(3.0 / 8));
            arcus = u * (Real(-1.0 / 3) + u * Real(1.0 / 5));
        } else {
            inverse_root = u * (Real(-1.0 / 2) + u * (Real(3.0 / 8) + u * Real(-5.0 / 16)));
            root = u + (inverse_root + u * inverse_root); // (1 + u) / sqrt(1 + u) - 1
            arcus = u * (Real(-1.0 / 3) + u * (Real(1.0 / 5) + u * Real(-1.0 / 7)));
        }
        strain = along + (root + along * root);
        inverse_stretch = reciprocal + reciprocal * inverse_root;
        tangent = q;
    }

    // The angle less half of `rotation`, rad; of a branch that rolls, the small difference of the two comes first.
    TALIK_HOST_DEVICE Real angle_less_half(Real rotation) const { return (tangent - Real(0.5) * rotation) + tangent * arcus; }
};

} // namespace talik::farm
