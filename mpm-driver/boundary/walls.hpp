#pragma once
// All walls of a scene on the grid's advanced velocity.
#include <vector>

#include "mpm-driver/boundary/wall.hpp"

namespace talik::driver {

// Rollers along different axes act on different components and meet without conflict, and so do rollers along one axis that share
// no row of nodes: one sweep is exact. A wall that holds the tangential component too meets the walls that hold it normally on the
// nodes of a corner, and walls that face each other across a few cells meet on the rows between them: the sweep is then repeated
// (projected Gauss-Seidel on the impulses, which converges as alternating projections do); the normal conditions have the last word.
constexpr int sweeps_where_walls_meet = 8;

inline int wall_sweeps(const std::vector<Wall>& walls) {
    bool meet = false;
    for (std::size_t k = 0; k < walls.size(); ++k) {
        meet = meet || (walls[k].has_tangential() && walls.size() > 1);
        for (std::size_t l = 0; l < k; ++l) meet = meet || walls[k].shares_rows_with(walls[l]);
    }
    return meet ? sweeps_where_walls_meet : 1;
}

// Before the grid is advanced: walls move on, and the mapped velocity is held where they held it in the last step.
inline void hold_mapped_velocity(std::vector<Wall>& walls, Grid& grid, double dt, double confining_pressure, double pic) {
    for (Wall& wall : walls) wall.start_step(grid, dt, confining_pressure, pic);
    const int sweeps = wall_sweeps(walls);
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        for (Wall& wall : walls)
            if (wall.has_tangential()) wall.hold_mapped_tangential(grid);
        for (Wall& wall : walls) wall.hold_mapped_normal(grid);
    }
    for (Wall& wall : walls) wall.remember_slip(grid);
}

// After it: walls stop, push and rub.
inline void constrain(std::vector<Wall>& walls, Grid& grid) {
    const int sweeps = wall_sweeps(walls);
    for (Wall& wall : walls) wall.constrain_normal(grid);
    for (int sweep = 0; sweep < sweeps && sweeps > 1; ++sweep) {
        for (Wall& wall : walls)
            if (wall.has_tangential()) wall.constrain_tangential(grid);
        for (Wall& wall : walls) wall.constrain_normal(grid);
    }
    if (sweeps == 1)
        for (Wall& wall : walls)
            if (wall.has_tangential()) wall.constrain_tangential(grid);
    for (Wall& wall : walls) wall.finish_step(grid);
}

} // namespace talik::driver
