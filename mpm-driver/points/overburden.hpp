#pragma once
// The vertical stress of the ground above a point, from the outlines of the bodies: what packings are chosen by.
#include <vector>

#include "mpm-driver/app/scene.hpp"

namespace talik::driver {

class Overburden {
public:
    // Under the gravity of the first stage, which the initial stress is to balance. Bodies of RVEs without a density count
    // with that of their discs at the void ratio aimed at.
    explicit Overburden(const Scene& scene);

    // sigma_v = p + sum over the bodies of rho g l, compression positive, Pa: p the confining pressure, l (m) how much of
    // the vertical line above x lies in the body.
    double operator()(const Vector& x) const;

    double gravity() const { return gravity_; } // downward, m/s^2

private:
    struct Ground {
        std::vector<Vector> outline; // m
        double density;              // kg/m^3
    };
    std::vector<Ground> ground_;
    double gravity_, pressure_;
};

// The scene's K0 path, where it names no stresses of its own: from the shallowest point of law "rve" (at least the pressure
// of the packings, where the path begins) to the deepest.
void complete_k0_range(Scene& scene);

} // namespace talik::driver
