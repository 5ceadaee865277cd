#include "mpm-driver/heat/initial_field.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "common/base/error.hpp"
#include "common/io/csv_table.hpp"

namespace talik::driver {
namespace {

std::vector<double> sorted(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
    return values;
}

// The interval of a sorted list around x, and where in it.
std::pair<std::size_t, double> place_in(const std::vector<double>& knots, double x) {
    if (knots.size() == 1) return {0, 0.0};
    const auto after = std::upper_bound(knots.begin(), knots.end(), x) - knots.begin();
    const auto i = static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(after - 1, 0, static_cast<std::ptrdiff_t>(knots.size()) - 2));
    return {i, std::clamp((x - knots[i]) / (knots[i + 1] - knots[i]), 0.0, 1.0)};
}

} // namespace

PlaneTable::PlaneTable(const std::string& file, const std::string& column) {
    const CsvTable table = read_finite_csv(file);
    const auto x = table.values("x_m"), y = table.values("y_m"), value = table.values(column);
    x_ = sorted(x);
    y_ = sorted(y);
    require(!x.empty() && x_.size() * y_.size() == x.size(), fmt::format("{}: its {} rows are no full grid of {} x {} places", file, x.size(), x_.size(), y_.size()),
            "give a value for every x at every y, once");
    value_.assign(x.size(), 0.0);
    std::vector<char> given(x.size(), 0);
    for (std::size_t k = 0; k < x.size(); ++k) {
        const auto i = static_cast<std::size_t>(std::lower_bound(x_.begin(), x_.end(), x[k]) - x_.begin());
        const auto j = static_cast<std::size_t>(std::lower_bound(y_.begin(), y_.end(), y[k]) - y_.begin());
        if (given[i + j * x_.size()]) throw table.fault(k, fmt::format("the place ({:g}, {:g}) m is given twice", x[k], y[k]), "give a value for every x at every y, once");
        given[i + j * x_.size()] = 1;
        value_[i + j * x_.size()] = value[k];
    }
}

double PlaneTable::at(const Vector& x) const {
    const auto [i, u] = place_in(x_, x[0]);
    const auto [j, v] = place_in(y_, x[1]);
    const std::size_t right = x_.size() > 1 ? 1 : 0, up = y_.size() > 1 ? x_.size() : 0, k = i + j * x_.size();
    return (1 - v) * ((1 - u) * value_[k] + u * value_[k + right]) + v * ((1 - u) * value_[k + up] + u * value_[k + up + right]);
}

std::vector<double> initial_temperatures(const std::vector<BodySpec>& bodies, const Points& points) {
    std::map<std::string, PlaneTable> tables;
    for (const BodySpec& body : bodies)
        if (!body.temperature_file.empty()) tables.try_emplace(body.temperature_file, body.temperature_file, "temperature_C");
    std::vector<double> temperature(points.count());
    for (std::size_t p = 0; p < points.count(); ++p) {
        const BodySpec& body = bodies[static_cast<std::size_t>(points.body[p])];
        temperature[p] = body.temperature_file.empty() ? body.temperature.value_or(0.0) : tables.at(body.temperature_file).at(points.position[p]);
    }
    return temperature;
}

// A box takes of a point what of its square lies within.
std::vector<double> source_factors(const HeatSourceSpec& source, const std::vector<BodySpec>& bodies, const std::vector<double>& half_size, const Points& points) {
    std::vector<double> factor(points.count(), 1.0);
    if (!source.shape_file.empty()) {
        const PlaneTable shape(source.shape_file, "factor");
        for (std::size_t p = 0; p < points.count(); ++p) factor[p] = shape.at(points.position[p]);
    }
    for (std::size_t p = 0; p < points.count(); ++p) {
        const Vector& x = points.position[p];
        const auto body = static_cast<std::size_t>(points.body[p]);
        if (!source.body.empty() && bodies[body].name != source.body) factor[p] = 0.0;
        if (source.box.empty()) continue;
        const Vector low = source.box[0].cwiseMin(source.box[1]), high = source.box[0].cwiseMax(source.box[1]);
        const double l = half_size[body];
        for (int a = 0; a < 2; ++a) factor[p] *= std::clamp((std::min(x[a] + l, high[a]) - std::max(x[a] - l, low[a])) / (2.0 * l), 0.0, 1.0);
    }
    return factor;
}

} // namespace talik::driver
