#pragma once
// Drives an element test: each component of the strain rate is either prescribed or found so that a stress is held.
// One call gives the displacement-gradient increment of the next macro step from the answer of the last one.
#include <algorithm>
#include <array>
#include <cmath>

#include "rve-farm/assembly/answer.hpp"

namespace talik::farm {

struct ComponentTarget {
    enum class Control { rate, stress };
    Control control = Control::rate;
    double value = 0; // rate: strain rate, 1/s, extension positive (xy: tensor component, half of gamma). stress: Pa, tension positive

    static ComponentTarget rate(double per_second) { return {Control::rate, per_second}; }
    static ComponentTarget stress(double pascal) { return {Control::stress, pascal}; }
};

struct ServoTargets {
    ComponentTarget xx, yy, xy;
    double spin = 0; // 1/s, counter-clockwise: simple shear gamma_dot along x is xy = gamma_dot/2, spin = -gamma_dot/2
};

// Proportional and integral control of the rates. Gains are per macro step and dimensionless: the strain that an error
// of stress calls for is error / C, C the measured (Voigt) stiffness, which bounds the assembly's immediate response
// from above, so that a gain below 1 cannot overshoot it.
class Servo {
public:
    explicit Servo(ServoTargets targets, double largest_rate = 1.0, double gain = 0.2, double integral_gain = 0.005)
        : targets_(targets), largest_rate_(largest_rate), gain_(gain), integral_gain_(integral_gain) {}

    // Row-major dt grad v = dt (D + W) of the next macro step.
    std::array<double, 4> next(const Answer& present, double time_increment) {
        const double xx = rate(0, targets_.xx, present, time_increment);
        const double yy = rate(1, targets_.yy, present, time_increment);
        const double xy = rate(2, targets_.xy, present, time_increment);
        return {time_increment * xx, time_increment * (xy - targets_.spin), //
                time_increment * (xy + targets_.spin), time_increment * yy};
    }

    // Changes what is asked for; the rates found so far are kept where a component stays stress-controlled.
    void set_targets(const ServoTargets& targets) { targets_ = targets; }
    const ServoTargets& targets() const { return targets_; }

    // The largest error of the stress-controlled components, Pa.
    double error(const Answer& present) const {
        return std::max({error(0, targets_.xx, present), error(1, targets_.yy, present), error(2, targets_.xy, present)});
    }

private:
    static double error(std::size_t component, const ComponentTarget& target, const Answer& present) {
        return target.control == ComponentTarget::Control::stress ? std::abs(target.value - present.stress[component]) : 0;
    }

    double rate(std::size_t component, const ComponentTarget& target, const Answer& present, double time_increment) {
        if (target.control == ComponentTarget::Control::rate) {
            held_rate_[component] = 0;
            return target.value;
        }
        const double error = target.value - present.stress[component]; // Pa; positive calls for extension
        // xy: the tensor component of the strain meets 2 C66, which is about the same bound again.
        // Without contacts there is nothing to measure: the assembly is then closed (or opened) at the largest rate.
        const double stiffness = std::max(present.stiffness, 1e-9 * std::abs(error));
        const double wanted = stiffness > 0 ? error / (stiffness * time_increment) : 0; // 1/s
        const double rate = held_rate_[component] + gain_ * wanted;
        if (std::abs(rate) > largest_rate_) return std::copysign(largest_rate_, rate); // and the integral does not wind up
        held_rate_[component] += integral_gain_ * wanted;
        return rate;
    }

    ServoTargets targets_;
    double largest_rate_, gain_, integral_gain_;
    std::array<double, 3> held_rate_ = {0, 0, 0}; // 1/s, the integral part
};

} // namespace talik::farm
