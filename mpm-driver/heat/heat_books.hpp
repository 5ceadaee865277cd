#pragma once
// What heat has entered, by cause, J: every entry is booked where it arises, with its rounding carried along, so that the
// balance of a long run measures the method and not the adding up.
#include <cmath>
#include <string>
#include <vector>

#include "mpm-driver/points/state_column.hpp"

namespace talik::driver {

class HeatBooks {
public:
    void open(std::size_t entries, double content) {
        booked_.assign(entries, 0.0);
        carry_.assign(entries, 0.0);
        totals_ = {};
        totals_.initial = content;
    }
    void book(std::size_t entry, double heat) { // J, into the material (Neumaier's sum)
        const double sum = booked_[entry] + heat;
        carry_[entry] += std::abs(booked_[entry]) >= std::abs(heat) ? (booked_[entry] - sum) + heat : (heat - sum) + booked_[entry];
        booked_[entry] = sum;
        totals_.moved += std::abs(heat);
    }
    void see_temperature_outside(double kelvin) { totals_.overshoot = std::max(totals_.overshoot, kelvin); }

    double heat(std::size_t entry) const { return booked_[entry] + carry_[entry]; } // J
    double entered() const { // J
        double sum = 0.0;
        for (std::size_t i = 0; i < booked_.size(); ++i) sum += heat(i);
        return sum;
    }
    double initial() const { return totals_.initial; }
    double moved() const { return totals_.moved; }         // sum of |heat| over steps and causes, J
    double overshoot() const { return totals_.overshoot; } // K, beyond the range of initial and held temperatures

    std::vector<StateColumn> state() {
        return {{"heat/booked", "J", "heat entered by cause", {""}, booked_.data(), booked_.size()},
                {"heat/carry", "J", "rounding carried along", {""}, carry_.data(), carry_.size()},
                {"heat/totals", "SI", "content at the start J, heat moved J, overshoot K", {"initial", "moved", "overshoot"}, &totals_.initial, 1}};
    }

private:
    struct Totals { double initial = 0.0, moved = 0.0, overshoot = 0.0; };
    std::vector<double> booked_, carry_;
    Totals totals_;
};

} // namespace talik::driver
