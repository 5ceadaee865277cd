#pragma once
// Lagrange-Gauss reduction of the cell's basis: a skewed cell is replaced by the least skewed one of the same lattice, so
// that images stay few and linked cells stay wide however far the RVE is sheared.
#include <array>
#include <cmath>
#include <cstdint>

namespace talik::farm {

// Unimodular: H_reduced = H T, so an image n (in multiples of the old columns) is T^-1 n in multiples of the new ones.
struct BasisChange {
    std::int64_t xx = 1, xy = 0, yx = 0, yy = 1; // T
    bool identity() const { return xx == 1 && xy == 0 && yx == 0 && yy == 1; }

    std::array<std::int64_t, 2> image(std::int64_t x, std::int64_t y) const { // det T is 1 or -1
        const std::int64_t determinant = xx * yy - xy * yx;
        return {determinant * (yy * x - xy * y), determinant * (xx * y - yx * x)};
    }
};

// Reduces the columns (xx, yx) and (xy, yy) in place: |a.b| <= min(|a|^2, |b|^2) / 2 afterwards.
// `margin` keeps a basis that is as good as reduced, so that noise does not flip a square cell back and forth.
inline BasisChange reduce_basis(double& xx, double& xy, double& yx, double& yy, double margin = 0.05) {
    BasisChange t;
    for (int sweep = 0; sweep < 200; ++sweep) { // Gauss: halves the longer vector each time; a few sweeps suffice
        const double aa = xx * xx + yx * yx, bb = xy * xy + yy * yy, ab = xx * xy + yx * yy;
        const double shorter = aa < bb ? aa : bb;
        if (!(std::abs(ab) > (0.5 + margin) * shorter)) break;
        const double steps = std::round(ab / shorter);
        const std::int64_t k = static_cast<std::int64_t>(steps);
        if (aa < bb) { // b <- b - k a
            xy -= steps * xx, yy -= steps * yx;
            t.xy -= k * t.xx, t.yy -= k * t.yx;
        } else { // a <- a - k b
            xx -= steps * xy, yx -= steps * yy;
            t.xx -= k * t.xy, t.yx -= k * t.yy;
        }
    }
    return t;
}

} // namespace talik::farm
