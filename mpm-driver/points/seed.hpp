#pragma once
// Fills bodies with points.
#include <vector>

#include "mpm-driver/app/scene.hpp"
#include "mpm-driver/grid/grid.hpp"
#include "mpm-driver/points/points.hpp"

namespace talik::driver {

// l_p of a body's points, m: constant, half the spacing at the start (uGIMP).
double point_half_size(const BodySpec& body, double cell);

// Points stand on a regular sub-grid of spacing 2 l_p, those whose centre lies in the body. The sub-grid of a box starts
// at the box's corner, so that a box tiles without gaps wherever it stands; that of any other polygon at the grid's, so
// that neighbouring polygons fit together. Points get id, body, position, velocity, mass and volume; laws do the rest.
// mechanical: with the columns of mechanics.
Points seed_points(const std::vector<BodySpec>& bodies, const Grid& grid, bool mechanical = true);

// For the checks of a scene, without a grid: what seed_points will do with bodies that are sound by themselves.
bool holds_a_point(const BodySpec& body, const DomainSpec& domain);
double area_of_points(const BodySpec& body, const DomainSpec& domain); // m^2
// Whether two bodies claim the same ground: boxes exactly, other polygons where a point of one lies inside the other.
bool overlap(const BodySpec& a, const BodySpec& b, const DomainSpec& domain);

} // namespace talik::driver
