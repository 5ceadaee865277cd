#pragma once
// How much of a soil's water is frozen at a temperature: the frozen fraction f(T) of its water, by mass, which never grows
// with temperature. Above the top temperature nothing is frozen; just below it f is `jump` (all that freezes, for a sharp
// front); further down f follows the curve.
//
//   coarse soil, Eqs. (38), (39)   f = (1 - S_res) (T0 - T) / (T0 - T_res), constant below T_res; width zero allowed
//   fine soil, Eqs. (4), (40), A1  f = 1 - w / w_all,  w = wbar + (w0 - wbar) exp(a (T - T0)), clamped at f >= 0
//   saturation curve, Eq. (41)     f = 1 - S_f,  S_f = S_res + (1 - S_res) exp(-((T - T0)/W)^2)
//   table                          straight lines between rows of unfrozen saturation
#include <vector>

#include "mpm-driver/app/heat_scene.hpp"

namespace talik::driver {

class FreezingCurve {
public:
    FreezingCurve() = default; // water that never freezes
    // saturated_water_content: w_all, mass of all water over mass of grains, - (of the fine soil)
    FreezingCurve(const ThermalMaterialSpec& spec, double saturated_water_content);

    double top() const { return top_; }     // degrees C
    double jump() const { return jump_; }   // f just below the top
    double bottom() const;                  // degrees C: f is constant from here down (to rounding)
    double most() const { return fraction(bottom()); }
    std::vector<double> corners() const;    // temperatures where f has a corner, falling, top first

    double fraction(double temperature) const;       // f, - ; at the top itself: the jump
    double slope(double temperature) const;          // df/dT <= 0, 1/K
    double integral(double temperature) const;       // of f from the temperature up to the top, K
    bool straight() const { return kind_ == Kind::lines; }
    double excess() const { return excess_; }        // -f(T0) where the data would make it negative, else 0

private:
    enum class Kind { lines, exponential, gaussian };
    void set_lines(std::vector<double> temperatures, std::vector<double> fractions);

    Kind kind_ = Kind::lines;
    double top_ = 0.0, jump_ = 0.0, excess_ = 0.0;
    std::vector<double> temperature_, fraction_, integral_; // of the lines, from the top down
    double origin_ = 0.0, scale_ = 0.0, most_ = 0.0, width_ = 0.0; // f = most - scale exp(...)
};

} // namespace talik::driver
