#include "mpm-driver/heat/freezing_curve.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "common/base/error.hpp"
#include "common/io/csv_table.hpp"

namespace talik::driver {
namespace {

// Rows of a table from warm to cold, checked.
void read_lines(const std::string& file, std::vector<double>& temperatures, std::vector<double>& fractions) {
    const CsvTable table = read_finite_csv(file);
    const auto t = table.values("temperature_C"), s = table.values("unfrozen_saturation");
    require(t.size() >= 2, file + ": has fewer than two rows", "give at least a frozen and a thawed row");
    for (std::size_t i = 0; i < t.size(); ++i) {
        if (!(s[i] >= 0.0 && s[i] <= 1.0)) throw table.fault(i, fmt::format("an unfrozen saturation of {:g} is not in [0, 1]", s[i]), "give it as a fraction of all water");
        if (i > 0 && !(t[i] > t[i - 1])) throw table.fault(i, "its temperature is not above that of the row before", "sort the rows from cold to warm");
        if (i > 0 && s[i] < s[i - 1]) throw table.fault(i, fmt::format("the freezing curve is not monotonic: {:g} of the water is unfrozen at {:g} C, {:g} at {:g} C", s[i], t[i], s[i - 1], t[i - 1]),
                                                        "unfrozen water may only grow with temperature");
    }
    if (s.back() != 1.0) throw table.fault(t.size() - 1, fmt::format("{:g} of the water is unfrozen in the warmest row", s.back()), "end with a row where it is 1");
    for (std::size_t i = t.size(); i-- > 0;) {
        temperatures.push_back(t[i]);
        fractions.push_back(1.0 - s[i]);
    }
}

} // namespace

FreezingCurve::FreezingCurve(const ThermalMaterialSpec& spec, double saturated_water_content) {
    top_ = spec.freezing_temperature;
    if (spec.curve == "ramp") {
        const double all = 1.0 - spec.residual_saturation;
        if (spec.residual_temperature < top_) set_lines({top_, spec.residual_temperature}, {0.0, all});
        else set_lines({top_}, {all}); // a sharp front
    } else if (spec.curve == "table") {
        std::vector<double> temperatures, fractions;
        read_lines(spec.curve_file, temperatures, fractions);
        set_lines(temperatures, fractions);
    } else if (spec.curve == "saturation") {
        kind_ = Kind::gaussian;
        origin_ = top_;
        most_ = scale_ = 1.0 - spec.residual_saturation;
        width_ = spec.width;
    } else if (spec.curve == "fine") {
        kind_ = Kind::exponential;
        origin_ = top_;
        width_ = 1.0 / spec.decay;
        const double w0 = spec.water_content.value_or(saturated_water_content);
        most_ = 1.0 - spec.residual_water_content / saturated_water_content;
        scale_ = (w0 - spec.residual_water_content) / saturated_water_content;
        jump_ = most_ - scale_;
        require(most_ > 0.0 && scale_ > 0.0, fmt::format("curve \"fine\": a residual_water_content of {:g} leaves nothing to freeze", spec.residual_water_content), "give less than water_content and than what the pores hold, or curve = \"none\"");
        if (jump_ < 0.0) { // theta_s < 0 at T0: nothing freezes until w has fallen to what the pores hold
            excess_ = -jump_;
            top_ = origin_ + width_ * std::log(most_ / scale_);
            jump_ = 0.0;
        }
    }
}

void FreezingCurve::set_lines(std::vector<double> temperatures, std::vector<double> fractions) {
    temperature_ = std::move(temperatures);
    fraction_ = std::move(fractions);
    top_ = temperature_.front();
    jump_ = fraction_.front();
    integral_.assign(temperature_.size(), 0.0);
    for (std::size_t i = 1; i < temperature_.size(); ++i)
        integral_[i] = integral_[i - 1] + 0.5 * (fraction_[i] + fraction_[i - 1]) * (temperature_[i - 1] - temperature_[i]);
}

double FreezingCurve::bottom() const {
    if (kind_ == Kind::exponential) return origin_ - 37.0 * width_; // exp(-37) = 1e-16
    if (kind_ == Kind::gaussian) return origin_ - 6.1 * width_;
    return temperature_.empty() ? top_ : temperature_.back();
}

std::vector<double> FreezingCurve::corners() const {
    return kind_ == Kind::lines && !temperature_.empty() ? temperature_ : std::vector<double>{top_, bottom()};
}

double FreezingCurve::fraction(double temperature) const {
    if (temperature > top_) return 0.0;
    if (kind_ == Kind::exponential) return std::max(0.0, most_ - scale_ * std::exp((temperature - origin_) / width_));
    if (kind_ == Kind::gaussian) {
        const double u = (temperature - origin_) / width_;
        return -scale_ * std::expm1(-u * u);
    }
    if (temperature_.empty()) return 0.0;
    if (std::isnan(temperature)) return temperature; // compares with nothing: the search below would leave the table
    if (temperature <= temperature_.back()) return fraction_.back();
    std::size_t i = 1;
    while (temperature_[i] > temperature) ++i;
    return fraction_[i - 1] + (fraction_[i] - fraction_[i - 1]) * (temperature_[i - 1] - temperature) / (temperature_[i - 1] - temperature_[i]);
}

double FreezingCurve::slope(double temperature) const {
    if (temperature > top_) return 0.0;
    const double u = (temperature - origin_) / (width_ > 0.0 ? width_ : 1.0);
    if (kind_ == Kind::exponential) return -scale_ / width_ * std::exp(u);
    if (kind_ == Kind::gaussian) return 2.0 * u * scale_ / width_ * std::exp(-u * u);
    if (temperature_.empty() || !(temperature > temperature_.back())) return 0.0; // nor where it is no number
    std::size_t i = 1;
    while (i + 1 < temperature_.size() && temperature_[i] > temperature) ++i;
    return -(fraction_[i] - fraction_[i - 1]) / (temperature_[i - 1] - temperature_[i]);
}

double FreezingCurve::integral(double temperature) const {
    if (temperature >= top_) return 0.0;
    if (kind_ == Kind::exponential) // most (top - T) - scale width (e^{(top-o)/w} - e^{(T-o)/w})
        return most_ * (top_ - temperature) + scale_ * width_ * std::exp((top_ - origin_) / width_) * std::expm1((temperature - top_) / width_);
    if (kind_ == Kind::gaussian) { // of exp(-u^2) from T to T0: sqrt(pi)/2 W erf((T0 - T)/W)
        constexpr double half_root_pi = 0.886226925452758013649;
        return scale_ * ((origin_ - temperature) - half_root_pi * width_ * std::erf((origin_ - temperature) / width_));
    }
    if (temperature_.empty()) return 0.0;
    std::size_t i = 1;
    while (i < temperature_.size() && temperature_[i] > temperature) ++i;
    return integral_[i - 1] + 0.5 * (fraction_[i - 1] + fraction(temperature)) * (temperature_[i - 1] - temperature);
}

} // namespace talik::driver
