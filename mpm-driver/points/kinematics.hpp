#pragma once
// How a point's material deforms and turns in one step, and the strain measures shown.
#include <cmath>

#include "common/math/matrix.hpp"

namespace talik::driver {

// exp(A) of a 2x2 matrix: exp(m) (cosh q I + sinh(q)/q D), m = tr A / 2, D = A - m I, q^2 = -det D.
inline Matrix exponential(const Matrix& a) {
    const double mean = 0.5 * a.trace();
    const Matrix deviator = a - mean * Matrix::Identity();
    const double q2 = -deviator.determinant();
    double even, odd; // cosh q and sinh(q)/q, or cos and sin where q is imaginary
    if (std::abs(q2) < 1e-8) { // series: the next terms are below 1e-26
        even = 1.0 + q2 / 2.0 + q2 * q2 / 24.0;
        odd = 1.0 + q2 / 6.0 + q2 * q2 / 120.0;
    } else {
        const double q = std::sqrt(std::abs(q2));
        even = q2 > 0.0 ? std::cosh(q) : std::cos(q);
        odd = (q2 > 0.0 ? std::sinh(q) : std::sin(q)) / q;
    }
    return std::exp(mean) * (even * Matrix::Identity() + odd * deviator);
}

// Angle of the rotation R in the polar decomposition F = R U, rad.
inline double polar_angle(const Matrix& f) { return std::atan2(f(1, 0) - f(0, 1), f(0, 0) + f(1, 1)); }

inline Matrix rotation(double angle) {
    Matrix r;
    r << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
    return r;
}

// Logarithmic (Hencky) strain ln V of a deformation gradient, V^2 = F F^T, -, tension positive. For output.
inline Matrix logarithmic_strain(const Matrix& f) {
    const Matrix left = f * f.transpose();
    const double mean = 0.5 * left.trace(), half = 0.5 * (left(0, 0) - left(1, 1)), shear = left(0, 1);
    const double radius = std::sqrt(half * half + shear * shear);
    if (radius < 1e-14 * mean) return 0.5 * std::log(mean) * Matrix::Identity();
    const double l1 = 0.5 * std::log(mean + radius);
    const double l2 = 0.5 * (std::log(f.determinant() * f.determinant()) - std::log(mean + radius)); // no cancellation
    const Matrix direction = (left - mean * Matrix::Identity()) / radius;
    return 0.5 * (l1 + l2) * Matrix::Identity() + 0.5 * (l1 - l2) * direction;
}

// Equivalent strain sqrt(1/2 e:e), e the deviator of the logarithmic strain in the plane, -.
inline double equivalent_strain(const Matrix& f) {
    const Matrix strain = logarithmic_strain(f);
    const Matrix deviator = strain - 0.5 * strain.trace() * Matrix::Identity();
    return std::sqrt(0.5 * deviator.squaredNorm());
}

} // namespace talik::driver
