#include "common/packing/packing.hpp"

#include <cmath>
#include <numbers>

namespace talik {

double Packing::void_ratio() const {
    double solid = 0.0;
    for (double r : radius) solid += std::numbers::pi * r * r;
    return std::abs(cell.determinant()) / solid - 1.0;
}

} // namespace talik
