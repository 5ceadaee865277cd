// What the heat solver says of itself: step limit, balances, warnings, the columns of its state.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "mpm-driver/grid/parallel.hpp"
#include "mpm-driver/heat/heat_solver.hpp"

namespace talik::driver {

HeatLimit HeatSolver::limit(const Grid& grid, const Points& points) const {
    HeatLimit limit;
    limit.step = 1e300;
    const double h = grid.cell();
    double ramp = 1e300; // K, the narrowest freezing interval
    for (const std::size_t m : material_of_body_) {
        const ThermalMaterial& material = materials_[m];
        const double step = material.largest_step(h) / spec_.time_scale; // s
        if (material.curve().most() > 0.0) ramp = std::min(ramp, material.curve().corners().front() - material.curve().corners().back());
        if (step < limit.step) limit = {step, 0.0, material.least_capacity(), material.most_conductivity() * material.largest_anisotropy(), 0.0};
    }
    if (!points.deformation.empty()) { // opened ground holds less heat per volume
        double most = 1.0;
        for (std::size_t p = 0; p < points.count(); ++p) most = std::max(most, points.volume[p] / points.initial_volume[p]);
        limit.step /= most;
    }
    limit.automatic = 2.0 / spec_.stability * limit.step * point_size_factor_;
    // Capacity form: a node's temperature changes by at most 2 span dt / (dt at b = 2), which must stay within the ramp.
    if (!enthalpy_form_ && ramp < 1e300) limit.ramp_step = limit.step * ramp / (2.0 * std::max(span(), ramp));
    return limit;
}

std::string HeatSolver::describe(const HeatLimit& limit, const Grid& grid) const {
    std::string text = fmt::format("{:.4g} s at b = 2, {:.4g} s at b = {:g} (Eq. 43: sensible heat capacity {:.4g} J/(m^3 K), conductivity {:.4g} W/(m K), cell {:.4g} m)",
                                   limit.step, limit.automatic, spec_.stability, limit.capacity, limit.conductivity, grid.cell());
    if (limit.ramp_step > 0.0) text += fmt::format("; beyond {:.3g} s the capacity form jumps over its freezing interval", limit.ramp_step);
    return text;
}

double HeatSolver::content(const Points& points) const {
    return ordered_sums<1>(points.count(), [&](std::size_t p, std::array<double, 1>& sum) { sum[0] += points.enthalpy[p]; })[0];
}

double HeatSolver::balance_error(const Points& points) const {
    const double scale = content_scale_ + books_.moved();
    return scale > 0.0 ? std::abs(content(points) - books_.initial() - books_.entered()) / scale : 0.0;
}

// Part of the state: between two steps of heat the points move on, and nodes mapped anew would have other temperatures.
void HeatSolver::note_extremes() {
    clock_.coldest = 1e300, clock_.warmest = -1e300;
    for (std::size_t node = 0; node < nodes_; ++node) {
        if (!(volume_[node] > 0.0)) continue;
        clock_.coldest = std::min(clock_.coldest, temperature_[node]);
        clock_.warmest = std::max(clock_.warmest, temperature_[node]);
    }
}

double HeatSolver::water_volume(const Points& points) const {
    return ordered_sums<1>(points.count(), [&](std::size_t p, std::array<double, 1>& sum) {
        const ThermalMaterial& material = material_of(points, p);
        const double ice = points.ice_fraction[p] * points.volume[p] / points.initial_volume[p];
        sum[0] += points.initial_volume[p] * material.water_volume(material.ice_volume(1.0) > 0.0 ? ice / material.ice_volume(1.0) : 0.0);
    })[0];
}

double HeatSolver::ice_volume(const Points& points) const {
    return ordered_sums<1>(points.count(), [&](std::size_t p, std::array<double, 1>& sum) { sum[0] += points.ice_fraction[p] * points.volume[p]; })[0];
}

std::vector<std::string> HeatSolver::warnings() const {
    std::vector<std::string> out;
    for (const ThermalMaterial& material : materials_)
        if (!material.warning().empty()) out.push_back(material.warning());
    if (spec_.time_scale != 1.0)
        out.push_back(fmt::format("heat runs {:g} times faster than the scene's clock: conductivities, fluxes, sources and the times of their tables are scaled together", spec_.time_scale));
    for (const HeaterSpec& heater : spec_.heaters)
        if (heater.begins && *heater.begins >= scene_duration_)
            out.push_back(fmt::format("the heater \"{}\" stays off: it begins at {:g} s by the scene's clock, and the scene ends at {:g} s", heater.name, *heater.begins, scene_duration_));
    const bool power = !sources_.empty() || std::any_of(spec_.boundaries.begin(), spec_.boundaries.end(), [](const HeatBoundarySpec& side) { return side.kind == "flux"; });
    if (!power && span() > 0.0 && books_.overshoot() > 0.01 * span()) // only at the end of a run
        out.push_back(fmt::format("temperatures have left the range of initial and held ones by {:.2g} K, {:.2g} % of the span: a smaller step of heat, more points in a cell or a finer grid tell what it is", books_.overshoot(), 100.0 * books_.overshoot() / span()));
    if (!enthalpy_form_) out.push_back("heat in the capacity form: energy is not conserved where steps jump over the freezing interval (balance.heat)");
    return out;
}

std::vector<StateColumn> HeatSolver::state() {
    std::vector<StateColumn> columns = books_.state();
    if (enthalpy_form_) columns.push_back({"heat/node_enthalpy", "J/m3", "of nodes whose points rest", {""}, enthalpy_.data(), enthalpy_.size()});
    if (!enthalpy_form_) columns.push_back({"heat/node_state", "C", "temperature of nodes whose points rest", {"temperature", "frozen"}, &state_.front().temperature, state_.size()});
    columns.push_back({"heat/clock", "SI", "time s, steps, largest rate of ice saturation 1/s, least and most temperature of the nodes C", {"time", "steps", "ice_rate", "coldest", "warmest"}, &clock_.time, 1});
    return columns;
}

} // namespace talik::driver
