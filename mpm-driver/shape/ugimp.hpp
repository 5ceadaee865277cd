#pragma once
// uGIMP shape functions, Eqs. (24), (25): the linear hats of the nodes, averaged over a point's constant extent 2 l_p.
//
// Eq. (24) lists the average piece by piece over the distance point - node. Seen from the point there are only three nodes
// to an axis, the first of them at or below the point's lower edge. With the edge xi cells above that node and
// lambda = l_p / h <= 1/2, the extent [xi, xi + 2 lambda] lies in the first cell or reaches into the second:
//     phi_0 = 1 - xi - lambda         dphi_0/dx = -1/h                      within the first cell
//     phi_0 = (1 - xi)^2 / (4 lambda) dphi_0/dx = -(1 - xi) / (2 lambda h)  reaching over by o = xi + 2 lambda - 1
//     phi_2 = o^2 / (4 lambda)        dphi_2/dx = o / (2 lambda h)          (0 within the first cell)
// and the middle node has the rest: partition of unity, and a gradient of constants of exactly zero.
#include <array>
#include <cmath>

namespace talik::driver {

struct ShapeWeights1D {
    int first_node = 0;             // of the three
    std::array<double, 3> value{};  // phi, -
    std::array<double, 3> slope{};  // dphi/dx, 1/m
};

// centre: the point's position in cells from node 0; lambda = l_p / h in (0, 1/2]; cell: h, m.
inline ShapeWeights1D ugimp_weights(double centre, double lambda, double cell) {
    // An edge that lies on a node but for rounding counts as on it: a node reached by 1e-13 of a cell would get a mass of
    // 1e-26 and a force of 1e-13, and answer to rounding. The gradient it would have had is below 1e-12 / h.
    constexpr double rounding = 1e-13;
    const double edge = centre - lambda;
    const double node = std::floor(edge + rounding);
    const double xi = edge - node > rounding ? edge - node : 0.0;
    const double over = xi + 2.0 * lambda - 1.0; // o

    ShapeWeights1D w;
    w.first_node = static_cast<int>(node);
    if (over > rounding) {
        w.value[0] = (1.0 - xi) * (1.0 - xi) / (4.0 * lambda);
        w.slope[0] = -(1.0 - xi) / (2.0 * lambda * cell);
        w.value[2] = over * over / (4.0 * lambda);
        w.slope[2] = over / (2.0 * lambda * cell);
    } else {
        w.value[0] = 1.0 - xi - lambda;
        w.slope[0] = -1.0 / cell;
    }
    w.value[1] = 1.0 - w.value[0] - w.value[2];
    w.slope[1] = -w.slope[0] - w.slope[2];
    return w;
}

} // namespace talik::driver
