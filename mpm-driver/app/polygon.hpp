#pragma once
// Plane geometry of outlines, for the checks of a scene.
#include <cstddef>
#include <vector>

#include "common/math/matrix.hpp"

namespace talik::driver {

inline double cross(const Vector& a, const Vector& b) { return a[0] * b[1] - a[1] * b[0]; }

// Signed area, m^2: positive where the corners run counter-clockwise.
inline double polygon_area(const std::vector<Vector>& corners) {
    double twice = 0.0;
    for (std::size_t i = 0; i < corners.size(); ++i) twice += cross(corners[i], corners[(i + 1) % corners.size()]);
    return 0.5 * twice;
}

// Whether the closed segments ab and cd have a point in common.
inline bool segments_meet(const Vector& a, const Vector& b, const Vector& c, const Vector& d) {
    const auto side = [](const Vector& p, const Vector& q, const Vector& r) { const double s = cross(q - p, r - p); return (s > 0.0) - (s < 0.0); };
    const auto within = [](const Vector& p, const Vector& q, const Vector& r) {
        return (p.cwiseMin(q).array() <= r.array()).all() && (r.array() <= p.cwiseMax(q).array()).all();
    };
    const int abc = side(a, b, c), abd = side(a, b, d), cda = side(c, d, a), cdb = side(c, d, b);
    if (abc * abd < 0 && cda * cdb < 0) return true;
    return (abc == 0 && within(a, b, c)) || (abd == 0 && within(a, b, d)) || (cda == 0 && within(c, d, a)) || (cdb == 0 && within(c, d, b));
}

// No two sides meet but neighbours in their common corner.
inline bool polygon_is_simple(const std::vector<Vector>& corners) {
    const std::size_t n = corners.size();
    for (std::size_t i = 0; i < n; ++i)
        if (corners[i] == corners[(i + 1) % n]) return false;
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 2; j < n; ++j)
            if (!(i == 0 && j == n - 1) && segments_meet(corners[i], corners[i + 1], corners[j], corners[(j + 1) % n])) return false;
    return true;
}

} // namespace talik::driver
