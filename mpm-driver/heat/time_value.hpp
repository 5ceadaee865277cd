#pragma once
// A prescribed value in time: constant, sine (seasons), or a table with straight lines between its rows.
// A step uses the mean over its duration, so that what is imposed over many steps is exact whatever their size.
#include <string>
#include <vector>

#include "mpm-driver/app/heat_scene.hpp"

namespace talik::driver {

class TimeValue {
public:
    TimeValue(const TimeValueSpec& spec, const std::string& who);

    double at(double time) const;
    double mean(double begin, double end) const;
    double least() const { return least_; }  // of all times
    double most() const { return most_; }

private:
    double integral(double time) const; // of the table from its first row, or of the sine: value x s

    double constant_ = 0.0, amplitude_ = 0.0, angular_ = 0.0, shift_ = 0.0;
    std::vector<double> times_, values_, integrals_;
    double least_ = 0.0, most_ = 0.0;
};

} // namespace talik::driver
