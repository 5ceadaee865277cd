#pragma once
// All nodes prescribed: v(x) = v_0 + L (x - x_0). For tests: the driver then asks its laws for a known strain path.
#include "common/math/matrix.hpp"

namespace talik::driver {

struct PrescribedField {
    Matrix velocity_gradient = Matrix::Zero(); // L, 1/s
    Vector velocity = Vector::Zero();          // v_0, m/s
    Vector centre = Vector::Zero();            // x_0, m

    Vector operator()(const Vector& x) const { return velocity + velocity_gradient * (x - centre); }
};

} // namespace talik::driver
