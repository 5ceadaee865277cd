#pragma once
// Which nodes each point touches in this step, and the other way round: which points each node sums over.
// Nodes gather, in an order fixed by the points' ids: no atomics, and the same bits for any number of threads.
#include <array>
#include <cstdint>
#include <vector>

#include "mpm-driver/grid/grid.hpp"
#include "mpm-driver/points/points.hpp"
#include "mpm-driver/shape/ugimp.hpp"

namespace talik::driver {

class Supports {
public:
    Supports(const Grid& grid, std::size_t points);

    // half_size: l_p by body, m. Every point must lie in the domain.
    void update(const Grid& grid, const Points& points, const std::vector<double>& half_size);

    // body(node, phi, grad phi) for the 9 nodes of a point.
    template <class Body>
    void each_node_of(std::size_t point, Body&& body) const {
        const Support& s = supports_[point];
        for (int b = 0; b < 3; ++b)
            for (int a = 0; a < 3; ++a)
                body(static_cast<std::size_t>(s.first_node + a + b * row_), s.value(a, b), s.gradient(a, b));
    }

    // body(point, phi, grad phi) for the points of a node: bin by bin, in a bin by id.
    template <class Body>
    void each_point_of(std::size_t node, Body&& body) const {
        for (int b = 0; b < 3; ++b)
            for (int a = 0; a < 3; ++a) {
                const int bin = static_cast<int>(node) - a - b * row_;
                if (bin < 0) return; // the further bins lie before the first node, too
                for (std::uint32_t k = bin_begin_[bin]; k < bin_begin_[bin + 1]; ++k) {
                    const std::uint32_t p = bin_points_[k];
                    body(p, supports_[p].value(a, b), supports_[p].gradient(a, b));
                }
            }
    }

private:
    struct Support { // a tensor product of the two axes' three weights
        int first_node = 0;
        std::array<double, 3> value_x, value_y, slope_x, slope_y;
        double value(int a, int b) const { return value_x[a] * value_y[b]; }
        Vector gradient(int a, int b) const { return {slope_x[a] * value_y[b], value_x[a] * slope_y[b]}; }
    };
    void sort_into_bins();

    int row_; // nodes in a row of the grid
    std::vector<Support> supports_;
    std::vector<std::uint32_t> bin_begin_, bin_points_; // points by first node
};

} // namespace talik::driver
