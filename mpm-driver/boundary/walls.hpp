#pragma once
// All walls of a scene on the grid's advanced velocity.
#include <vector>

#include "mpm-driver/boundary/wall.hpp"

namespace talik::driver {

// Rollers along different axes act on different components and meet without conflict: one sweep is exact. A wall that
// holds the tangential component too meets the walls that hold it normally on the nodes of a corner: the sweep is then
// repeated (projected Gauss-Seidel on the impulses, which converges as alternating projections do); the normal
// conditions have the last word.
inline void constrain(std::vector<Wall>& walls, Grid& grid, double dt, double confining_pressure) {
    constexpr int sweeps_where_walls_meet = 8; // the remaining conflict is a few percent of the corner nodes' share
    bool tangential = false;
    for (Wall& wall : walls) {
        wall.start_step(grid, dt, confining_pressure);
        tangential = tangential || wall.has_tangential();
    }
    const int sweeps = tangential && walls.size() > 1 ? sweeps_where_walls_meet : 1;
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        for (Wall& wall : walls) wall.constrain_normal(grid);
        for (Wall& wall : walls)
            if (wall.has_tangential()) wall.constrain_tangential(grid);
    }
    if (sweeps > 1)
        for (Wall& wall : walls) wall.constrain_normal(grid);
    for (Wall& wall : walls) wall.finish_step(grid);
}

} // namespace talik::driver
