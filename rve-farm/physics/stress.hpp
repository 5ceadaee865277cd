#pragma once
// The homogenised stress of an RVE, Eq. (49) of the paper with tension positive (the paper prints the other sign).
#include "common/team/cpu_team.hpp"

namespace talik::farm {

// The symmetric part of a sum of dyads, J: divided by a volume it is a stress.
template <class Real>
struct Virial {
    Real xx = Real(0), yy = Real(0), xy = Real(0);

    // f x b of a contact: f the force on the disc that the branch b points to, N; b, m.
    TALIK_HOST_DEVICE void add_contact(Real force_x, Real force_y, Real branch_x, Real branch_y) {
        xx += force_x * branch_x;
        yy += force_y * branch_y;
        xy += Real(0.5) * (force_x * branch_y + force_y * branch_x);
    }

    // m v_f x v_f of a disc: fluctuation velocity, m/s.
    TALIK_HOST_DEVICE void add_fluctuation(Real mass, Real velocity_x, Real velocity_y) {
        xx += mass * velocity_x * velocity_x;
        yy += mass * velocity_y * velocity_y;
        xy += mass * velocity_x * velocity_y;
    }

    // sigma = -(1/V) sum f x b [- (1/V) sum m v_f x v_f], Pa. V = cell area times thickness, m^3.
    TALIK_HOST_DEVICE Virial stress(Real volume) const { return {-xx / volume, -yy / volume, -xy / volume}; }

    // Components in axes turned back by `angle`: R(angle) sigma R(angle)^T, from co-rotated to fixed axes.
    // Written on mean and deviator, so that the mean does not feel the rotation.
    TALIK_HOST_DEVICE Virial turned(Real cosine, Real sine) const {
        const Real mean = (xx + yy) / 2, half_difference = (xx - yy) / 2;
        const Real c2 = cosine * cosine - sine * sine, s2 = 2 * sine * cosine; // of twice the angle
        const Real turned_difference = c2 * half_difference - s2 * xy;
        return {mean + turned_difference, mean - turned_difference, s2 * half_difference + c2 * xy};
    }
};

} // namespace talik::farm
