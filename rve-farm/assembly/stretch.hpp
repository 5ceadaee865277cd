#pragma once
// The motion of the cell in one sub-step of constant velocity gradient: G = exp(dt L) (Eq. 45, H <- exp(dt L) H), split
// by polar decomposition G = R U into a rotation, which only turns the RVE's frame, and a symmetric stretch.
// All rotations of the plane commute, so in a frame turned by theta the stretch is R(-theta) U R(theta).
#include <cmath>

#include "common/team/cpu_team.hpp"

namespace talik::farm {

// A symmetric 2 x 2 matrix, [[xx, xy], [xy, yy]].
struct Symmetric {
    double xx = 0, yy = 0, xy = 0;
};

struct Stretch {
    double rotation = 0;                        // angle of R, rad, counter-clockwise
    double mean = 0;                            // U - I = [[mean + difference, shear], [shear, mean - difference]]
    double difference = 0, shear = 0;           // -
    double cosine = 1, sine = 0;                // of minus twice the rotation: turns the deviator from one sub-step to the next

    TALIK_HOST_DEVICE Symmetric change() const { return {mean + difference, mean - difference, shear}; } // U - I

    // I - U^-1: what a branch of the end of the sub-step has gained by the stretch, per length.
    TALIK_HOST_DEVICE Symmetric change_seen_from_the_end() const {
        const Symmetric d = change();
        const double inverse_determinant = 1 / ((1 + d.xx) * (1 + d.yy) - d.xy * d.xy);
        const double product = d.xx * d.yy - d.xy * d.xy; // I - U^-1 = ((U - I) + det(U - I) I) / det U
        return {(d.xx + product) * inverse_determinant, (d.yy + product) * inverse_determinant, d.xy * inverse_determinant};
    }

    // The same stretch in axes turned by `rotation`: the deviator turns by minus twice that.
    TALIK_HOST_DEVICE void turn_with_the_frame() {
        const double d = difference;
        difference = cosine * d - sine * shear;
        shear = sine * d + cosine * shear;
    }

    // Bound of |ln U|: the largest relative change of any length in the sub-step.
    double largest_strain() const { return std::abs(mean) + std::hypot(difference, shear); }
};

// Exact to rounding. (xx, xy, yx, yy): dt L in fixed axes; frame_angle: theta at the start, rad.
// With a = tr/2, S the symmetric deviator, w the spin, q^2 = |S|^2 - w^2 and s = sinh(q)/q:
//   exp(dt L) = e^a (cosh q I + s (S + w J)), angle of R = atan2(s w, cosh q), U = m I + R^T e^a s S,
//   m = e^a sqrt(1 + s^2 |S|^2), in which cosh^2 q - s^2 q^2 = 1 was used: U = I in bits when only w differs from 0.
inline Stretch stretch_of(double xx, double xy, double yx, double yy, double frame_angle) {
    const double a = (xx + yy) / 2, d = (xx - yy) / 2, e = (xy + yx) / 2, w = (yx - xy) / 2;
    const double deviator_squared = d * d + e * e, q_squared = deviator_squared - w * w;
    const double q = std::sqrt(std::abs(q_squared));
    const double c = q_squared > 0 ? std::cosh(q) : std::cos(q);
    const double s = q > 0 ? (q_squared > 0 ? std::sinh(q) : std::sin(q)) / q : 1.0;

    Stretch stretch;
    stretch.rotation = std::atan2(s * w, c);
    stretch.mean = std::expm1(a + std::log1p(s * s * deviator_squared) / 2);
    stretch.cosine = std::cos(2 * stretch.rotation);
    stretch.sine = -std::sin(2 * stretch.rotation);
    const double turn = -(stretch.rotation + 2 * frame_angle); // R^T S: minus the angle; into the frame: minus twice theta
    const double scale = std::exp(a) * s;
    stretch.difference = scale * (std::cos(turn) * d - std::sin(turn) * e);
    stretch.shear = scale * (std::sin(turn) * d + std::cos(turn) * e);
    return stretch;
}

} // namespace talik::farm
