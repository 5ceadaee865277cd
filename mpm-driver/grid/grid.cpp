#include "mpm-driver/grid/grid.hpp"

#include <cmath>

#include "common/base/error.hpp"

namespace talik::driver {

Grid::Grid(const Vector& origin, const Vector& size, double cell, double thickness, bool mechanical)
    : first_node_(origin.array() - cell), cell_(cell), thickness_(thickness) {
    require(cell > 0.0, "the cell size of the domain is not positive", "give domain.cell as a length above 0");
    require(thickness > 0.0, "the thickness of the domain is not positive", "give domain.thickness as a length above 0");
    require((size.array() > 0.0).all(), "the size of the domain is not positive", "give domain.size as two lengths above 0");
    require((size / cell).prod() <= 1e9, "the domain has too many cells", "give a larger domain.cell"); // node numbers are of type int
    for (int axis = 0; axis < Dim; ++axis) {
        const int cells = static_cast<int>(std::ceil(size[axis] / cell - 1e-9)); // a size of 10 cells is 10, not 11
        nodes_[axis] = cells + 3; // cells + 1 nodes, and a ghost at each end
    }
    if (!mechanical) return;
    const auto n = static_cast<std::size_t>(node_count());
    mass.resize(n, 0.0);
    for (auto* column : {&velocity_before, &velocity, &internal_force, &unit_pressure_force, &force})
        column->resize(n, Vector::Zero());
}

Vector Grid::domain_max() const {
    return domain_min() + cell_ * Vector(nodes_[0] - 3, nodes_[1] - 3);
}

bool Grid::inside_domain(const Vector& x) const { // written so that a NaN is outside
    const double slack = 1e-9 * cell_; // a point on the edge that has moved by rounding; the ghosts bear it
    return (x.array() >= domain_min().array() - slack).all() && (x.array() <= domain_max().array() + slack).all();
}

Vector Grid::node_position(int n) const {
    return first_node_ + cell_ * Vector(n % nodes_[0], n / nodes_[0]);
}

} // namespace talik::driver
