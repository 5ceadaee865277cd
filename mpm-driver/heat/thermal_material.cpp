#include "mpm-driver/heat/thermal_material.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "common/base/error.hpp"
#include "common/io/csv_table.hpp"

namespace talik::driver {
namespace {

constexpr double air_capacity = 1.2e3;     // of air, J/(m^3 K)

// All water of the pores as mass over mass of grains, -.
double saturated_water_content(const ThermalMaterialSpec& s) {
    return s.porosity < 1.0 ? s.porosity * s.saturation * s.water_density / ((1.0 - s.porosity) * s.grain_density) : 1.0;
}

// Where a falling list passes a value: the last index whose entry is not below it.
std::size_t index_above(const std::vector<double>& falling, double value) {
    const auto first_below = std::partition_point(falling.begin(), falling.end(), [&](double entry) { return entry >= value; });
    const auto index = first_below - falling.begin() - 1;
    return static_cast<std::size_t>(std::max<std::ptrdiff_t>(index, 0));
}

} // namespace

ThermalMaterial::ThermalMaterial(const ThermalMaterialSpec& spec) : spec_(spec) {
    if (spec.curve != "none") curve_ = FreezingCurve(spec, saturated_water_content(spec));
    grains_ = 1.0 - spec.porosity;
    water_ = spec.porosity * spec.saturation;
    air_ = spec.porosity - water_;
    // Eq. (3): rho_f theta_f + rho_s theta_s stays; where "fills pores", theta_f + theta_s does.
    ice_ = spec.frozen_water == "fills pores" ? water_ : water_ * spec.water_density / spec.ice_density;
    // Eq. (1): rho c = (1 - n) rho_g c_g + theta_f rho_f c_f + theta_s rho_s c_s, J/(m^3 K)
    const double water_capacity = water_ * spec.water_density * spec.water_heat_capacity, ice_capacity = ice_ * spec.ice_density * spec.ice_heat_capacity;
    thawed_capacity_ = grains_ * spec.grain_density * std::max(spec.grain_heat_capacity, 0.0) + water_capacity + air_ * air_capacity;
    frozen_change_ = ice_capacity - water_capacity;
    latent_ = spec.latent_heat * spec.ice_density * ice_;
    if (!spec.conductivity_file.empty()) {
        const CsvTable table = read_finite_csv(spec.conductivity_file);
        given_temperature_ = table.values("temperature_C");
        given_conductivity_ = table.values("conductivity_W_per_mK");
        require(!given_temperature_.empty(), spec.conductivity_file + ": has no rows", "give at least one");
        for (std::size_t i = 0; i < given_temperature_.size(); ++i) {
            if (!(given_conductivity_[i] > 0.0)) throw table.fault(i, fmt::format("a conductivity of {:g} W/(m K) is not positive", given_conductivity_[i]), "give a positive one");
            if (i > 0 && !(given_temperature_[i] > given_temperature_[i - 1])) throw table.fault(i, "its temperature is not above that of the row before", "sort the rows from cold to warm");
        }
    }
    tabulate();
}

// Knots of the curve, each piece cut finely; Theta by Simpson's rule on k, read with cubic Hermite pieces (k is its slope).
void ThermalMaterial::tabulate() {
    std::vector<double> knots = curve_.corners();
    for (double t : given_temperature_) knots.push_back(t);
    if (!given_temperature_.empty()) knots.push_back(curve_.top());
    std::sort(knots.begin(), knots.end(), std::greater<>());
    knots.erase(std::unique(knots.begin(), knots.end()), knots.end());
    constexpr int pieces = 400;
    table_temperature_ = {knots.front()};
    for (std::size_t i = 1; i < knots.size(); ++i)
        for (int k = 1; k <= pieces; ++k) table_temperature_.push_back(k == pieces ? knots[i] : knots[i - 1] + (knots[i] - knots[i - 1]) * k / pieces);
    table_potential_ = {0.0};
    for (std::size_t i = 0; i < table_temperature_.size(); ++i) {
        const double t = table_temperature_[i];
        table_enthalpy_.push_back(enthalpy({t, 1.0}));
        table_conductivity_.push_back(conductivity_at(t));
        if (i == 0) continue;
        const double d = table_temperature_[i - 1] - t, a = 0.5 - std::sqrt(3.0 / 20.0); // three-point Gauss
        const double mean = (5.0 * conductivity_at(t + a * d) + 8.0 * conductivity_at(t + 0.5 * d) + 5.0 * conductivity_at(t + (1.0 - a) * d)) / 18.0;
        table_potential_.push_back(table_potential_.back() - mean * d);
    }
}

double ThermalMaterial::frozen_fraction(const ThermalState& state) const {
    if (state.temperature == curve_.top()) return curve_.jump() * state.frozen;
    return curve_.fraction(state.temperature);
}

double ThermalMaterial::enthalpy(const ThermalState& state) const {
    // Exact primitive of (rho c)(T) = C_thawed + (d rho c / d f) f(T), less the latent heat of what is frozen, J/m^3
    const double sensible = thawed_capacity_ * (state.temperature - spec_.freezing_temperature) - frozen_change_ * curve_.integral(state.temperature);
    return sensible - latent_ * frozen_fraction(state);
}

// C h^2 / (2 k), C the sensible capacity, J/(m^3 K), k the largest conductivity along any axis, W/(m K).
double ThermalMaterial::largest_step(double cell) const {
    return least_capacity() * cell * cell / (2.0 * most_conductivity() * largest_anisotropy());
}

double ThermalMaterial::capacity_at(double temperature) const {
    // Eq. (A2): C = rho c - L rho_s d theta_s / dT, J/(m^3 K)
    return thawed_capacity_ + frozen_change_ * (temperature < curve_.top() ? curve_.fraction(temperature) : 0.0) - latent_ * curve_.slope(temperature);
}

ThermalState ThermalMaterial::state_of(double enthalpy) const {
    const double at_top = thawed_capacity_ * (curve_.top() - spec_.freezing_temperature); // thawed, J/m^3
    if (enthalpy >= at_top) return {enthalpy == at_top ? curve_.top() : curve_.top() + (enthalpy - at_top) / thawed_capacity_, 0.0};
    const double jump = latent_ * curve_.jump();
    if (enthalpy >= at_top - jump) return {curve_.top(), jump > 0.0 ? (at_top - enthalpy) / jump : 0.0};
    return curve_.straight() ? state_in_lines(enthalpy) : state_by_newton(enthalpy);
}

// Below the top, of a curve of straight lines: from the knot above, with x = T_knot - T >= 0 and f = f_0 + s x,
//   H_knot - H = (C + dC f_0 + L' s) x + dC s x^2 / 2: a quadratic, solved in the form that does not cancel.
ThermalState ThermalMaterial::state_in_lines(double enthalpy) const {
    const std::size_t knot = index_above(table_enthalpy_, enthalpy);
    const double top = table_temperature_[knot], drop = table_enthalpy_[knot] - enthalpy;
    const double f = curve_.fraction(top);
    double s = 0.0;
    if (knot + 1 < table_temperature_.size()) s = (curve_.fraction(table_temperature_[knot + 1]) - f) / (top - table_temperature_[knot + 1]);
    const double linear = thawed_capacity_ + frozen_change_ * f + latent_ * s, quadratic = 0.5 * frozen_change_ * s;
    const double root = std::sqrt(std::max(0.0, linear * linear + 4.0 * quadratic * drop));
    const double temperature = top - 2.0 * drop / (linear + root);
    return {temperature == curve_.top() ? std::nextafter(temperature, -1e300) : temperature, 1.0};
}

ThermalState ThermalMaterial::state_by_newton(double enthalpy) const {
    const std::size_t knot = index_above(table_enthalpy_, enthalpy);
    if (knot + 1 >= table_temperature_.size()) { // below the bottom f is constant
        const double capacity = thawed_capacity_ + frozen_change_ * curve_.most();
        return {table_temperature_.back() - (table_enthalpy_.back() - enthalpy) / capacity, 1.0};
    }
    double high = table_temperature_[knot], low = table_temperature_[knot + 1];
    double t = high - (high - low) * (table_enthalpy_[knot] - enthalpy) / (table_enthalpy_[knot] - table_enthalpy_[knot + 1]);
    for (int i = 0; i < 60; ++i) { // safeguarded Newton: H grows with T
        const double missing = enthalpy - this->enthalpy({t, 1.0});
        (missing > 0.0 ? low : high) = t;
        double next = t + missing / capacity_at(t);
        if (!(next > low && next < high)) next = 0.5 * (low + high);
        if (std::abs(next - t) <= 1e-15 * (std::abs(t) + 1.0)) return {next, 1.0};
        t = next;
    }
    return {t, 1.0};
}

double ThermalMaterial::least_capacity() const {
    return std::min(thawed_capacity_, thawed_capacity_ + frozen_change_ * curve_.most());
}

double ThermalMaterial::ice_saturation(double f) const {
    const double ice = ice_volume(f), all = ice + water_volume(f);
    return all > 0.0 ? ice / all : 0.0;
}

double ThermalMaterial::conductivity(double f, double stretch, double expansion) const {
    // Eq. (2), over volume fractions theta that add up to 1: ice may take more room than its water did, and air gives way first.
    const double pores = spec_.porosity + std::max(0.0, stretch - 1.0); // with what dilation has opened
    const double ice = std::max(ice_volume(f), (1.0 + expansion) * water_ * f), water = water_volume(f);
    const double part[4] = {grains_, water, ice, std::max(0.0, pores - water - ice)};
    const double k[4] = {spec_.grain_conductivity, spec_.water_conductivity, spec_.ice_conductivity, spec_.air_conductivity};
    double all = 0.0, sum = 0.0;
    for (int i = 0; i < 4; ++i) {
        if (part[i] <= 0.0) continue;
        all += part[i];
        sum += part[i] * (spec_.conductivity_mean == "geometric" ? std::log(k[i]) : spec_.conductivity_mean == "arithmetic" ? k[i] : 1.0 / k[i]);
    }
    const double mean = sum / all;
    return spec_.conductivity_mean == "geometric" ? std::exp(mean) : spec_.conductivity_mean == "arithmetic" ? mean : 1.0 / mean;
}

double ThermalMaterial::conductivity_at(double temperature) const {
    if (given_temperature_.empty()) return conductivity(curve_.fraction(temperature)); // at the top itself: frozen
    const auto after = static_cast<std::size_t>(std::upper_bound(given_temperature_.begin(), given_temperature_.end(), temperature) - given_temperature_.begin());
    if (after == 0) return given_conductivity_.front();
    if (after == given_temperature_.size()) return given_conductivity_.back();
    const double share = (temperature - given_temperature_[after - 1]) / (given_temperature_[after] - given_temperature_[after - 1]);
    return given_conductivity_[after - 1] + share * (given_conductivity_[after] - given_conductivity_[after - 1]);
}

double ThermalMaterial::most_conductivity() const {
    double most = given_conductivity_.empty() ? conductivity(0.0) : 0.0;
    for (double k : table_conductivity_) most = std::max(most, k);
    return most;
}

double ThermalMaterial::potential(double temperature) const {
    const double top = table_temperature_.front();
    if (temperature >= top) return (given_temperature_.empty() ? conductivity(0.0) : given_conductivity_.back()) * (temperature - top);
    if (!(temperature > table_temperature_.back())) // what is no number too, and stays one
        return table_potential_.back() + table_conductivity_.back() * (temperature - table_temperature_.back());
    const std::size_t i = index_above(table_temperature_, temperature);
    const double d = table_temperature_[i] - table_temperature_[i + 1], x = (table_temperature_[i] - temperature) / d;
    // Cubic Hermite: value and slope at both ends
    const double a = table_potential_[i], b = table_potential_[i + 1], ka = -d * table_conductivity_[i], kb = -d * table_conductivity_[i + 1];
    return a + x * (ka + x * (3.0 * (b - a) - 2.0 * ka - kb + x * (2.0 * (a - b) + ka + kb)));
}

Matrix ThermalMaterial::anisotropy() const {
    Matrix tensor;
    tensor << spec_.anisotropy[0], spec_.anisotropy[2], spec_.anisotropy[2], spec_.anisotropy[1];
    return tensor;
}

double ThermalMaterial::largest_anisotropy() const {
    const double mean = 0.5 * (spec_.anisotropy[0] + spec_.anisotropy[1]), half = 0.5 * (spec_.anisotropy[0] - spec_.anisotropy[1]);
    return mean + std::hypot(half, spec_.anisotropy[2]);
}

std::string ThermalMaterial::warning() const {
    if (!(curve_.excess() > 0.0)) return "";
    return fmt::format("material \"{}\": its water content w0 is more than its pores hold: theta_s = {:.3g} at T0 (set to 0 there); the consistent w0 is {:.4g}",
                       spec_.name, -ice_ * curve_.excess(), saturated_water_content(spec_));
}

ThermalState state_of_mixture(const std::vector<ThermalMaterial>& materials, const double* shares, double enthalpy) {
    const auto sum = [&](const ThermalState& state) {
        double h = 0.0;
        for (std::size_t m = 0; m < materials.size(); ++m)
            if (shares[m] > 0.0) h += shares[m] * materials[m].enthalpy(state);
        return h;
    };
    double low = -1e300, high = 1e300; // of the temperature
    double capacity = 0.0;
    for (std::size_t m = 0; m < materials.size(); ++m) {
        if (!(shares[m] > 0.0)) continue;
        const double top = materials[m].curve().top();
        capacity += shares[m] * materials[m].least_capacity();
        const double thawed = sum({top, 0.0}), frozen = sum({top, 1.0});
        if (enthalpy <= thawed && enthalpy >= frozen) return {top, thawed > frozen ? (thawed - enthalpy) / (thawed - frozen) : 0.0};
        if (enthalpy > thawed) low = std::max(low, top);
        else high = std::min(high, top);
    }
    // Between tops the sum is smooth but for corners, and grows with T at least as fast as the sensible capacity.
    if (low == -1e300) low = high - std::max(1.0, (sum({high, 1.0}) - enthalpy) / capacity);
    if (high == 1e300) high = low + std::max(1.0, (enthalpy - sum({low, 0.0})) / capacity);
    double t = 0.5 * (low + high);
    for (int i = 0; i < 200; ++i) {
        const double missing = enthalpy - sum({t, 1.0});
        (missing > 0.0 ? low : high) = t;
        double slope = 0.0;
        for (std::size_t m = 0; m < materials.size(); ++m)
            if (shares[m] > 0.0) slope += shares[m] * materials[m].capacity_at(t);
        double next = t + missing / slope;
        if (!(next > low && next < high)) next = 0.5 * (low + high);
        if (std::abs(next - t) <= 1e-15 * (std::abs(t) + 1.0)) return {next, 1.0};
        t = next;
    }
    return {t, 1.0};
}

} // namespace talik::driver
