#pragma once
// The background grid: square cells of size h over the domain, with a ring of ghost cells around it, so that the support
// of a point inside the domain never leaves the arrays. Nodal columns live for one step.
#include <vector>

#include "common/math/matrix.hpp"

namespace talik::driver {

class Grid {
public:
    // size is rounded up to whole cells. mechanical: with the nodal columns below.
    Grid(const Vector& origin, const Vector& size, double cell, double thickness, bool mechanical = true);

    double cell() const { return cell_; }           // h, m
    double thickness() const { return thickness_; } // out of plane, m
    Vector domain_min() const { return first_node_.array() + cell_; }
    Vector domain_max() const;
    bool inside_domain(const Vector& x) const;

    int nodes(int axis) const { return nodes_[axis]; } // along an axis, ghosts included
    int node_count() const { return nodes_[0] * nodes_[1]; }
    int node(int i, int j) const { return i + nodes_[0] * j; }
    int stride(int axis) const { return axis == 0 ? 1 : nodes_[0]; } // from a node to the next along an axis
    Vector node_position(int node) const;
    // Position in units of cells, counted from node 0 (a ghost).
    double cells_from_first_node(int axis, double x) const { return (x - first_node_[axis]) / cell_; }

    // Nodal columns, Eqs. (17)-(30).
    std::vector<double> mass;                  // m_I, kg, lumped
    std::vector<Vector> velocity_before;       // v_I^n, m/s: mapped from the points
    std::vector<Vector> velocity;              // v_I^{n+1}, m/s: advanced, walls included
    std::vector<Vector> internal_force;        // -sum V_p sigma_p . grad phi, N
    std::vector<Vector> unit_pressure_force;   // -sum V_p grad phi, m^2: times p, the force of a pressure p on the surface
    std::vector<Vector> force;                 // all but the walls, N

private:
    Vector first_node_;
    double cell_, thickness_;
    int nodes_[Dim];
};

} // namespace talik::driver
