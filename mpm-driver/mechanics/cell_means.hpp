#pragma once
// Volume strain and mean stress averaged over the points of a cell (B-bar): against stresses that ring inside a cell.
//
// In a cell, d v_y / d y does not vary with y while d v_x / d x does, so the volume strains of its points differ row by row; a
// material that resists change of volume, or dilates, turns that into pressures that the nodes, which see their sum, do not
// feel. Here every point of a cell gets the cell's mean volume strain, and, so that forces stay the work conjugates of strains
// (the adjoint map), the nodes feel the cell's mean of the mean stress. Uniform fields are left alone.
#include <vector>

#include "mpm-driver/grid/grid.hpp"
#include "mpm-driver/points/points.hpp"

namespace talik::driver {

class CellMeans {
public:
    CellMeans(const Grid& grid, std::size_t point_count);

    // Which cell each point's centre is in; once per step, before the others.
    void locate(const Grid& grid, const Points& points);
    // The stresses that the nodes are to feel: deviator of the point, mean stress sum V s / sum V of its cell. Pa
    const std::vector<Stress>& acting_stress(const Points& points);
    // dL_p <- dL_p + 1/2 (mean of tr dL over the cell - tr dL_p) I
    void average_volume_strain(Points& points);

private:
    template <class Value>
    void average(const Points& points, Value&& value);

    std::vector<std::size_t> cell_;           // of each point
    std::vector<double> volume_, mean_;       // of each cell: m^3; the quantity averaged
    std::vector<Stress> acting_;
};

} // namespace talik::driver
