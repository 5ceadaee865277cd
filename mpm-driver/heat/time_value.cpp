#include "mpm-driver/heat/time_value.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/error.hpp"
#include "common/io/csv_table.hpp"

namespace talik::driver {

TimeValue::TimeValue(const TimeValueSpec& spec, const std::string& who) {
    constexpr double two_pi = 6.283185307179586476925;
    if (spec.file.empty()) {
        require(spec.constant.has_value(), who + " has neither a value nor a table of values", "give one of the two");
        constant_ = *spec.constant;
        if (spec.period > 0.0) amplitude_ = spec.amplitude, angular_ = two_pi / spec.period, shift_ = spec.shift;
        least_ = constant_ - std::abs(amplitude_);
        most_ = constant_ + std::abs(amplitude_);
        return;
    }
    const CsvTable table = read_finite_csv(spec.file);
    times_ = table.values("time_s");
    values_ = table.values("value");
    require(!times_.empty(), spec.file + ": has no rows", "give at least one time and value");
    integrals_.assign(times_.size(), 0.0);
    for (std::size_t i = 1; i < times_.size(); ++i) {
        if (times_[i] < times_[i - 1]) throw table.fault(i, "its time lies before that of the row above", "sort the rows by time");
        integrals_[i] = integrals_[i - 1] + 0.5 * (values_[i] + values_[i - 1]) * (times_[i] - times_[i - 1]);
    }
    least_ = *std::min_element(values_.begin(), values_.end());
    most_ = *std::max_element(values_.begin(), values_.end());
}

double TimeValue::at(double time) const {
    if (times_.empty()) return constant_ + (angular_ > 0.0 ? amplitude_ * std::sin(angular_ * (time - shift_)) : 0.0);
    const auto after = static_cast<std::size_t>(std::upper_bound(times_.begin(), times_.end(), time) - times_.begin());
    if (after == 0) return values_.front();
    if (after == times_.size()) return values_.back();
    const double share = (time - times_[after - 1]) / (times_[after] - times_[after - 1]);
    return values_[after - 1] + share * (values_[after] - values_[after - 1]);
}

double TimeValue::integral(double time) const {
    const auto after = static_cast<std::size_t>(std::upper_bound(times_.begin(), times_.end(), time) - times_.begin());
    if (after == 0) return values_.front() * (time - times_.front());
    return integrals_[after - 1] + 0.5 * (values_[after - 1] + at(time)) * (time - times_[after - 1]);
}

double TimeValue::mean(double begin, double end) const {
    if (times_.size() == 1) return values_.front();
    if (!(end > begin)) return at(begin);
    if (!times_.empty()) return (integral(end) - integral(begin)) / (end - begin);
    if (angular_ == 0.0) return constant_;
    // mean of sin over [u - d, u + d] = sin(u) sin(d) / d
    const double half = 0.5 * angular_ * (end - begin), middle = angular_ * (0.5 * (begin + end) - shift_);
    return constant_ + amplitude_ * std::sin(middle) * std::sin(half) / half;
}

} // namespace talik::driver
