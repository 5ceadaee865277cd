#pragma once
// Small vectors and matrices: Eigen types with the names used throughout.
// Kernels shared with the GPU use common/math/mat2.hpp instead, which needs nothing but arithmetic.
#include <Eigen/Dense>

namespace talik {

constexpr int Dim = 2; // plane strain; formulas are written for Dim where that costs nothing

using Vector = Eigen::Matrix<double, Dim, 1>;
using Matrix = Eigen::Matrix<double, Dim, Dim>;

} // namespace talik
