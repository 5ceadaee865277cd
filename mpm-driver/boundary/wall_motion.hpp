#pragma once
// Where a wall's face is: at rest, or moving along its axis with a velocity that grows smoothly over a ramp.
#include <algorithm>
#include <array>

namespace talik::driver {

class WallMotion {
public:
    WallMotion(double position, double velocity, double ramp)
        : state_{position, 0.0, 0.0}, velocity_(velocity), ramp_(ramp) {}

    double position() const { return state_[0]; }
    void start() { state_[2] = 1.0; }
    void stop() { state_[1] = state_[2] = 0.0; }

    // Moves on by dt and returns the mean velocity of the interval, so that the position is exact for any step.
    double advance(double dt) {
        if (state_[2] == 0.0) return 0.0;
        const double mean = (travelled(state_[1] + dt) - travelled(state_[1])) / dt;
        state_[1] += dt;
        state_[0] += dt * mean;
        return mean;
    }

    // For checkpoints: position (m), time since it began to move (s), moving (0 or 1).
    std::array<double, 3>& state() { return state_; }

private:
    // The path of V * smoothstep(t / ramp), smoothstep(q) = 3 q^2 - 2 q^3: V ramp (q^3 - q^4 / 2), then V per second. m
    double travelled(double t) const {
        if (ramp_ <= 0.0) return velocity_ * t;
        const double q = std::min(t / ramp_, 1.0);
        return velocity_ * (ramp_ * q * q * q * (1.0 - 0.5 * q) + std::max(t - ramp_, 0.0));
    }

    std::array<double, 3> state_;
    double velocity_, ramp_;
};

} // namespace talik::driver
