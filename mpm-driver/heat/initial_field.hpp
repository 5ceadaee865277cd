#pragma once
// Temperatures at the start, and where sources act: by body, or from a table over a regular grid of places.
#include <string>
#include <vector>

#include "mpm-driver/app/scene.hpp"
#include "mpm-driver/points/points.hpp"

namespace talik::driver {

// A CSV of x_m, y_m and one value on a full rectangular grid, read between its rows with bilinear pieces.
class PlaneTable {
public:
    PlaneTable(const std::string& file, const std::string& column);
    double at(const Vector& x) const; // beyond its edges: the value at the edge

private:
    std::vector<double> x_, y_, value_; // value_[i + j * columns]
};

std::vector<double> initial_temperatures(const std::vector<BodySpec>& bodies, const Points& points); // degrees C, by point
std::vector<double> source_factors(const HeatSourceSpec& source, const std::vector<BodySpec>& bodies, const std::vector<double>& half_size, const Points& points);

} // namespace talik::driver
