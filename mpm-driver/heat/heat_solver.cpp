#include "mpm-driver/heat/heat_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "common/base/error.hpp"
#include "mpm-driver/grid/parallel.hpp"
#include "mpm-driver/heat/initial_field.hpp"
#include "mpm-driver/points/kinematics.hpp"
#include "mpm-driver/points/soundness.hpp"

namespace talik::driver {
namespace {

constexpr double absolute_zero = -273.15; // degrees C

std::vector<ThermalMaterial> made_materials(const HeatSpec& spec) {
    std::vector<ThermalMaterial> materials;
    for (const ThermalMaterialSpec& material : spec.materials) materials.emplace_back(material);
    return materials;
}

} // namespace

HeatSolver::HeatSolver(const Scene& scene, const Grid& grid, const Supports& supports, const std::vector<double>& half_size, Points& points)
    : spec_(*scene.heat), enthalpy_form_(spec_.formulation == "enthalpy"), materials_(made_materials(spec_)), held_(spec_, grid), entries_(held_.names()),
      expansion_(scene.phase_change_strain ? scene.phase_change_strain->expansion : 0.0), nodes_(static_cast<std::size_t>(grid.node_count())) {
    for (const BodySpec& body : scene.bodies) {
        const auto found = std::find_if(materials_.begin(), materials_.end(), [&](const ThermalMaterial& m) { return m.name() == body.material; });
        require(found != materials_.end(), "body '" + body.name + "' has no thermal material", "give it one of the [[heat.material]]s");
        material_of_body_.push_back(static_cast<std::size_t>(found - materials_.begin()));
        frozen_at_start_.push_back(body.frozen ? 1.0 : 0.0);
    }
    const std::size_t n = points.count(), m = materials_.size();
    for (auto* column : {&volume_, &enthalpy_, &temperature_, &power_, &rate_}) column->assign(nodes_, 0.0);
    for (auto* column : {&share_, &material_enthalpy_, &potential_, &frozen_, &change_}) column->assign(m * nodes_, 0.0);
    state_.assign(nodes_, {});
    later_.reserve(nodes_);
    small_.reserve(nodes_);
    merged_.assign(nodes_, 0.0);
    if (enthalpy_form_ && points.mechanical) {
        excess_.assign(n, 0.0);
    }
    ensure(m <= most_materials);
    flow_.assign(n, Vector::Zero());
    for (auto* column : {&points.enthalpy, &points.temperature, &points.ice_saturation, &points.ice_fraction}) column->assign(n, 0.0);

    for (const HeatSourceSpec& source : spec_.sources) {
        sources_.push_back({TimeValue(source.value, "\"" + source.name + "\""), source_factors(source, scene.bodies, half_size, points)});
        entries_.push_back(source.name);
    }
    source_.assign(n, 0.0);
    for (std::size_t b = 0; b < half_size.size(); ++b) point_size_factor_ = std::min(point_size_factor_, 4.0 * half_size[b] / grid.cell());
    set_temperature(grid, supports, points, initial_temperatures(scene.bodies, points));
    refuse_what_is_idle(grid, points);
    for (const StageSpec& stage : scene.stages) scene_duration_ += stage.duration;
}

// What would heat nothing is a mistake of the scene.
void HeatSolver::refuse_what_is_idle(const Grid& grid, const Points& points) const {
    const std::string heater = held_.idle_heater(grid, volume_), side = held_.idle_side(grid, volume_);
    require(heater.empty(), "the heater '" + heater + "' holds no node of the ground: it lies outside, or between the nodes", "put it where a body is; make a box at least a cell wide");
    require(side.empty(), "the boundary '" + side + "' touches no node of the ground", "mend its `from` and `to`: at least a cell, where a body has that side");
    for (std::size_t i = 0; i < sources_.size(); ++i) {
        const bool any = std::any_of(sources_[i].factor.begin(), sources_[i].factor.end(), [](double factor) { return factor != 0.0; });
        require(any || points.count() == 0, "the source '" + spec_.sources[i].name + "' touches no ground", "mend its `box`, `body` or `shape_file`");
    }
}

void HeatSolver::set_temperature(const Grid& grid, const Supports& supports, Points& points, const std::vector<double>& temperature) {
    lowest_ = std::min(held_.least(), *std::min_element(temperature.begin(), temperature.end()));
    highest_ = std::max(held_.most(), *std::max_element(temperature.begin(), temperature.end()));
    for (std::size_t p = 0; p < points.count(); ++p) {
        points.temperature[p] = temperature[p];
        points.enthalpy[p] = points.initial_volume[p] * material_of(points, p).enthalpy({temperature[p], frozen_at_start_[static_cast<std::size_t>(points.body[p])]}); // J
    }
    clock_ = {};
    books_.open(entries_.size(), content(points));
    double size = 0.0; // the scale of the balance: also what a cooling or warming by the whole span would move
    for (std::size_t p = 0; p < points.count(); ++p) {
        const double frozen = frozen_at_start_[static_cast<std::size_t>(points.body[p])];
        const ThermalMaterial& material = material_of(points, p);
        size += std::abs(points.enthalpy[p]) + points.initial_volume[p] * std::abs(material.enthalpy({highest_, frozen}) - material.enthalpy({lowest_, frozen}));
    }
    content_scale_ = size;
    nodes_from_points(supports, points);
    show(grid, supports, points);
}

void HeatSolver::restored(const Grid& grid, const Supports& supports, Points& points) {
    show(grid, supports, points);
}

void HeatSolver::show(const Grid& grid, const Supports& supports, Points& points) {
    invert_nodes();
    held_.update(grid, volume_, clock_.time, true);
    hold_temperatures(clock_.time, clock_.time);
    std::fill(change_.begin(), change_.end(), 0.0);
    points_from_nodes(supports, points);
    note_extremes();
}

void HeatSolver::advance(const Grid& grid, const Supports& supports, Points& points, double dt, int substeps, bool moved) {
    cut_ = 0.0;
    if (moved) moved_nodes_from_points(supports, points);
    held_.update(grid, volume_, clock_.time, moved);
    small_nodes_changed_ = true; // a heater may have been switched
    std::fill(change_.begin(), change_.end(), 0.0);
    for (int k = 0; k < substeps; ++k) substep(grid, supports, points, dt / substeps);
    if (!enthalpy_form_) temperatures_from_nodes(supports, points);
    note_ice_rate(points);
    hold_temperatures(clock_.time, clock_.time);
    points_from_nodes(supports, points);
    note_extremes();
}

void HeatSolver::substep(const Grid& grid, const Supports& supports, Points& points, double dt) {
    const double begin = clock_.time, end = begin + dt;
    held_.update(grid, volume_, begin, false);
    if (small_nodes_changed_) find_small_nodes(grid);
    small_nodes_changed_ = false;
    hold_temperatures(begin, end);
    heat_flow(supports, points);
    source_power(points, begin, end);
    nodal_power(supports, begin, end);
    if (!enthalpy_form_) nodal_capacities();
    rates(grid, dt);
    if (enthalpy_form_) {
        advance_nodes(dt);
    } else {
        advance_temperatures(dt);
    }
    clock_.time = end;
    clock_.steps += 1.0;
    invert_nodes();
    watch_range(points);
}

void HeatSolver::nodes_from_points(const Supports& supports, const Points& points) {
    const std::size_t count = materials_.size();
    each(nodes_, [&](std::size_t node) {
        double heat = 0.0, volume = 0.0; // J, m^3
        double parts[most_materials] = {};
        supports.each_point_of(node, [&](std::uint32_t p, double phi, const Vector&) {
            const double part = phi * points.initial_volume[p]; // m^3
            heat += phi * points.enthalpy[p];                    // J
            volume += part;
            if (count > 1) parts[material_of_body_[static_cast<std::size_t>(points.body[p])]] += part;
        });
        volume_[node] = volume;
        enthalpy_[node] = volume > 0.0 ? heat / volume : 0.0; // H_I, Eq. (18) for enthalpy, J/m^3
        if (count == 1) share_[node] = volume > 0.0 ? 1.0 : 0.0;
        else for (std::size_t m = 0; m < count; ++m) share_[at(m, node)] = volume > 0.0 ? parts[m] / volume : 0.0;
    });
    if (!enthalpy_form_) temperatures_to_nodes(supports, points);
}

void HeatSolver::invert_nodes() {
    each(nodes_, [&](std::size_t node) {
        if (volume_[node] > 0.0) invert_node(node);
    });
}

void HeatSolver::invert_node(std::size_t node) {
    const std::size_t count = materials_.size();
    std::size_t present = 0;
    for (std::size_t m = 0; m < count; ++m) present += share_[at(m, node)] > 0.0;
    if (enthalpy_form_) state_[node] = state_at(node, enthalpy_[node]);
    temperature_[node] = state_[node].temperature;
    for (std::size_t m = 0; m < count; ++m) {
        if (!(share_[at(m, node)] > 0.0)) continue;
        frozen_[at(m, node)] = materials_[m].frozen_fraction(state_[node]);
        material_enthalpy_[at(m, node)] = present == 1 && enthalpy_form_ ? enthalpy_[node] : materials_[m].enthalpy(state_[node]);
        potential_[at(m, node)] = materials_[m].potential(temperature_[node]);
    }
}

// Mean over the step of what is held, so that a changing value enters exactly.
void HeatSolver::hold_temperatures(double begin, double end) {
    const double scale = spec_.time_scale;
    for (const HeldNodes::Held& held : held_.held()) {
        const auto node = static_cast<std::size_t>(held.node);
        temperature_[node] = held_.value(held.entry).mean(scale * begin, scale * end);
        for (std::size_t m = 0; m < materials_.size(); ++m)
            if (share_[at(m, node)] > 0.0) potential_[at(m, node)] = materials_[m].potential(temperature_[node]);
    }
}

void HeatSolver::heat_flow(const Supports& supports, const Points& points) {
    const bool deforms = !points.deformation.empty();
    each(points.count(), [&](std::size_t p) {
        const std::size_t m = material_of_body_[static_cast<std::size_t>(points.body[p])];
        const ThermalMaterial& material = materials_[m];
        Vector gradient = Vector::Zero(); // of Theta, W/m^2
        supports.each_node_of(p, [&](std::size_t node, double phi, const Vector& slope) {
            if (phi > 0.0) gradient += potential_[at(m, node)] * slope;
        });
        Matrix tensor = material.anisotropy();
        double ratio = 1.0; // of the conductivity opened or pressed to that of the initial volume
        if (deforms) {
            const double stretch = points.volume[p] / points.initial_volume[p];
            const double frozen = points.ice_fraction[p] * stretch / std::max(material.ice_volume(1.0), 1e-300);
            if (stretch > 1.0) ratio = material.conductivity(frozen, stretch, expansion_) / material.conductivity(frozen);
            if (material.spec().turns) {
                const Matrix turn = rotation(polar_angle(points.deformation[p]));
                tensor = turn * tensor * turn.transpose();
            }
        }
        flow_[p] = -spec_.time_scale * ratio * points.volume[p] * (tensor * gradient); // V_p q_p, Eq. (10), W m
    });
}

void HeatSolver::source_power(const Points& points, double begin, double end) {
    if (sources_.empty()) return;
    const double scale = spec_.time_scale, dt = end - begin;
    std::fill(source_.begin(), source_.end(), 0.0);
    for (std::size_t i = 0; i < sources_.size(); ++i) {
        const double value = sources_[i].value.mean(scale * begin, scale * end); // W/m^3
        const auto power = ordered_sums<1>(points.count(), [&](std::size_t p, std::array<double, 1>& sum) {
            const double here = scale * points.volume[p] * value * sources_[i].factor[p]; // W
            source_[p] += here;
            sum[0] += here;
        });
        books_.book(held_.names().size() + i, dt * power[0]);
    }
}

void HeatSolver::nodal_power(const Supports& supports, double begin, double end) {
    const bool sources = !sources_.empty();
    each(nodes_, [&](std::size_t node) {
        double power = 0.0; // Q_I = sum V_p q_p . grad phi_Ip + sum phi_Ip V_p s_p: Eqs. (20), (21), with the weak form's sign, W
        supports.each_point_of(node, [&](std::uint32_t p, double phi, const Vector& slope) {
            power += flow_[p].dot(slope);
            if (sources) power += phi * source_[p];
        });
        power_[node] = power;
    });
    for (const HeldNodes::Flux& flux : held_.fluxes()) {
        const double power = spec_.time_scale * flux.area * held_.value(flux.entry).mean(spec_.time_scale * begin, spec_.time_scale * end); // W
        power_[static_cast<std::size_t>(flux.node)] += power;
        books_.book(static_cast<std::size_t>(flux.entry), (end - begin) * power);
    }
}

// d H_I / dt = Q_I / W_I, Eq. (29); of held nodes the mean of their free neighbours', else the ground at a wall would keep
// its ice and the front lag behind; but never beyond what lies between the held temperature and the neighbours' state, else
// ground that is frozen already would freeze once more with its neighbour, and dry rock take the latent heat of wet ground. What
// lies within a heater has its temperature, where points rest (mapped anew from moving ones it would be heated in every step). The
// wall gives what that takes.
void HeatSolver::rates(const Grid& grid, double dt) {
    const std::vector<double>& weight = enthalpy_form_ ? volume_ : enthalpy_; // m^3, or J/K
    const int right = grid.stride(0), up = grid.stride(1);
    std::fill(merged_.begin(), merged_.end(), 0.0);
    for (const auto& [node, parent] : small_) {
        power_[parent] += power_[node];
        merged_[parent] += weight[node];
    }
    each(nodes_, [&](std::size_t node) { rate_[node] = volume_[node] > 0.0 ? power_[node] / (weight[node] + merged_[node]) : 0.0; });
    for (const auto& pair : small_) rate_[pair.first] = std::numeric_limits<double>::quiet_NaN(); // its parent's, below
    const auto set = [&](const HeldNodes::Held& held, double rate) {
        const auto node = static_cast<std::size_t>(held.node);
        rate_[node] = rate;
        books_.book(static_cast<std::size_t>(held.entry), dt * (rate * (weight[node] + merged_[node]) - power_[node]));
    };
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    for (const HeldNodes::Held& held : held_.held()) rate_[static_cast<std::size_t>(held.node)] = unknown;
    for (const HeldNodes::Held& held : held_.held()) {
        const double rate = rate_of_neighbours(held.node, right, up, dt, false);
        if (!std::isnan(rate)) set(held, rate);
    }
    for (const HeldNodes::Held& held : held_.held()) { // a second row, just outside the surface or within a heater
        const auto node = static_cast<std::size_t>(held.node);
        if (!std::isnan(rate_[node])) continue;
        double rate = held_.is_heater(held.entry) && excess_.empty() ? std::numeric_limits<double>::quiet_NaN() : rate_of_neighbours(held.node, right, up, dt, true);
        if (std::isnan(rate)) rate = (held_value(node) - value_of(node)) / dt;
        later_.push_back({held, rate}); // all of the second row see the first alone
    }
    for (const auto& [held, rate] : later_) set(held, rate);
    later_.clear();
    for (const auto& [node, parent] : small_) rate_[node] = rate_[parent];
}

// Nodes that the ground barely reaches, by o: their volume falls with o^2, what flows to them with o, and their rate would
// grow without bound. Each goes with the largest of its neighbours: one rate for both, from what both receive.
void HeatSolver::find_small_nodes(const Grid& grid) {
    const int right = grid.stride(0), up = grid.stride(1);
    constexpr double small = 0.1; // of the neighbour's volume: a surface within about a third of a cell beyond a node
    const auto largest = [&](std::size_t node) {
        std::size_t best = node;
        for (int offset : {-right, right, -up, up, -right - up, right - up, -right + up, right + up}) {
            const std::size_t other = node + static_cast<std::size_t>(offset); // wraps where it is outside
            if (other < nodes_ && volume_[other] > volume_[best]) best = other;
        }
        return best;
    };
    small_.clear();
    for (std::size_t node = 0; node < nodes_; ++node) {
        if (!(volume_[node] > 0.0) || held_.is_held(node)) continue;
        std::size_t parent = largest(node);
        if (volume_[node] >= small * volume_[parent]) continue;
        for (std::size_t next = largest(parent); volume_[parent] < small * volume_[next]; next = largest(parent)) parent = next;
        small_.emplace_back(node, parent);
    }
}

// Mean rate of the four neighbours, or else of the diagonal ones: those that are free, or (held) held ones that have a rate. What lies
// beyond the range between the held temperature and the neighbours' states at the end of the step is brought back to it; at heaters,
// through which ground may move, it goes no further.
double HeatSolver::rate_of_neighbours(int node, int right, int up, double dt, bool held) const {
    const auto here = static_cast<std::size_t>(node);
    double sum = 0.0, least = held_value(here), most = least;
    int count = 0;
    const auto look = [&](int offset) {
        const auto other = static_cast<std::size_t>(node + offset);
        if (other >= nodes_ || held_.is_held(other) != held || !(volume_[other] > 0.0) || std::isnan(rate_[other])) return;
        const double like = value_in_state_of(other, dt, here);
        least = std::min(least, like), most = std::max(most, like);
        sum += rate_[other];
        ++count;
    };
    for (int offset : {-right, right, -up, up}) look(offset);
    if (count == 0)
        for (int offset : {-right - up, right - up, -right + up, right + up}) look(offset);
    if (count == 0) return std::numeric_limits<double>::quiet_NaN();
    const double now = value_of(here), next = now + dt * sum / count;
    if (held_.is_heater(held_.entry_of(here))) least = std::min(least, now), most = std::max(most, now);
    return next >= least && next <= most ? sum / count : (std::clamp(next, least, most) - now) / dt;
}

// What rates are of: H_I, J/m^3; in the capacity form T_I, degrees C.
double HeatSolver::value_of(std::size_t node) const { return enthalpy_form_ ? enthalpy_[node] : state_[node].temperature; }

// Of a node at the temperature that it is held at.
double HeatSolver::held_value(std::size_t node) const { return enthalpy_form_ ? enthalpy_in(node, {temperature_[node], 0.0}) : temperature_[node]; }

// Of a node's ground in the state in which another is at the end of the step.
double HeatSolver::value_in_state_of(std::size_t other, double dt, std::size_t node) const {
    const double next = value_of(other) + dt * rate_[other];
    return enthalpy_form_ ? enthalpy_in(node, state_at(other, next)) : next;
}

double HeatSolver::enthalpy_in(std::size_t node, const ThermalState& state) const {
    double sum = 0.0;
    for (std::size_t m = 0; m < materials_.size(); ++m)
        if (share_[at(m, node)] > 0.0) sum += share_[at(m, node)] * materials_[m].enthalpy(state);
    return sum;
}

// The state of a node's ground with an enthalpy.
ThermalState HeatSolver::state_at(std::size_t node, double enthalpy) const {
    double shares[most_materials];
    std::size_t present = 0, only = 0;
    for (std::size_t m = 0; m < materials_.size(); ++m) {
        shares[m] = share_[at(m, node)];
        if (shares[m] > 0.0) ++present, only = m;
    }
    return present == 1 ? materials_[only].state_of(enthalpy) : state_of_mixture(materials_, shares, enthalpy);
}

// What each material at a node takes of the node's heat: all of it where it is alone; where several meet, so that they
// stay at one temperature (else wet ground that thaws would hand its latent heat to the dry rock beside it).
void HeatSolver::advance_nodes(double dt) {
    const std::size_t count = materials_.size();
    each(nodes_, [&](std::size_t node) {
        if (!(volume_[node] > 0.0)) return;
        const double rise = dt * rate_[node]; // J/m^3
        std::size_t present = 0;
        double shares[most_materials];
        for (std::size_t m = 0; m < count; ++m) {
            shares[m] = share_[at(m, node)];
            present += shares[m] > 0.0;
        }
        enthalpy_[node] += rise;
        if (present < 2) {
            for (std::size_t m = 0; m < count; ++m) change_[at(m, node)] += rise;
            return;
        }
        const ThermalState next = state_of_mixture(materials_, shares, enthalpy_[node]);
        double missing = rise;
        for (std::size_t m = 0; m < count; ++m) {
            if (!(shares[m] > 0.0)) continue;
            const double own = materials_[m].enthalpy(next) - material_enthalpy_[at(m, node)];
            change_[at(m, node)] += own;
            missing -= shares[m] * own;
        }
        for (std::size_t m = 0; m < count; ++m) change_[at(m, node)] += missing; // rounding
    });
}

// Nodes of points that may have moved: mapped anew, after the points were cut to their neighbours' range.
void HeatSolver::moved_nodes_from_points(const Supports& supports, Points& points) {
    nodes_from_points(supports, points);
    if (ordered_sums<1>(nodes_, [&](std::size_t node, std::array<double, 1>& sum) { sum[0] += poison(enthalpy_[node]); })[0] != 0.0) name_what_is_no_number(points);
    if (enthalpy_form_) {
        if (materials_.size() > 1) invert_nodes();
        if (limit_to_neighbours(supports, points)) nodes_from_points(supports, points);
    }
    invert_nodes();
}

// Points keep differences among each other that their nodes cannot see: once the ice of a node has melted, a point that
// was thawed before holds too much and its neighbour too little, in balance. When they move apart that would show as heat
// and cold. So a moving point's enthalpy is cut to the range of its nodes', and what is cut off goes to the nodes and back
// to all their points: nothing is lost, and a field that varies smoothly is not touched.
bool HeatSolver::limit_to_neighbours(const Supports& supports, Points& points) {
    const bool one = materials_.size() == 1;
    const std::vector<double>& node_enthalpy = one ? enthalpy_ : material_enthalpy_;
    const double cut = ordered_sums<1>(points.count(), [&](std::size_t p, std::array<double, 1>& sum) {
        const std::size_t m = one ? 0 : material_of_body_[static_cast<std::size_t>(points.body[p])];
        double least = 1e300, most = -1e300;
        supports.each_node_of(p, [&](std::size_t node, double phi, const Vector&) {
            if (!(phi > 0.0)) return;
            least = std::min(least, node_enthalpy[at(m, node)]);
            most = std::max(most, node_enthalpy[at(m, node)]);
        });
        const double volume = points.initial_volume[p], density = points.enthalpy[p] / volume;
        excess_[p] = volume * (density - std::clamp(density, least, most));
        sum[0] += std::abs(excess_[p]);
    })[0];
    if (!(cut > 0.0)) return false;
    cut_ = cut;
    each(nodes_, [&](std::size_t node) {
        double heat = 0.0;
        supports.each_point_of(node, [&](std::uint32_t p, double phi, const Vector&) { heat += phi * excess_[p]; });
        rate_[node] = volume_[node] > 0.0 ? heat / volume_[node] : 0.0; // J/m^3
    });
    each(points.count(), [&](std::size_t p) {
        double back = 0.0;
        supports.each_node_of(p, [&](std::size_t node, double phi, const Vector&) { back += phi * rate_[node]; });
        points.enthalpy[p] += points.initial_volume[p] * back - excess_[p];
    });
    return true;
}

void HeatSolver::watch_range(Points& points) {
    double worst = 0.0, numbers = 0.0; // K; 0, or none
    for (std::size_t node = 0; node < nodes_; ++node) {
        numbers += poison(enthalpy_[node] + temperature_[node]);
        if (volume_[node] > 0.0 && !held_.is_held(node))
            worst = std::max({worst, state_[node].temperature - highest_, lowest_ - state_[node].temperature});
    }
    if (numbers != 0.0) name_what_is_no_number(points);
    books_.see_temperature_outside(worst);
    if (lowest_ - worst < absolute_zero) refuse_unphysical();
}

// Before nonsense spreads: an unstable step shows itself here.
void HeatSolver::refuse_unphysical() const {
    for (std::size_t node = 0; node < nodes_; ++node)
        if (volume_[node] > 0.0 && state_[node].temperature < absolute_zero)
            fail(ExitCode::failed, fmt::format("heat at t = {:.6g} s: node {} is at {:.4g} C, below absolute zero: the step of heat is not stable there, or a flux takes more than there is", clock_.time, node, state_[node].temperature),
                 "take step.fixed = \"auto\" or a smaller one, heat.stability = 4, a smaller flux");
}

// What the nodes have received goes to the points, and what the nodes know of temperature and ice is shown on them.
void HeatSolver::points_from_nodes(const Supports& supports, Points& points) {
    const bool one = materials_.size() == 1;
    const auto numbers = ordered_sums<1>(points.count(), [&](std::size_t p, std::array<double, 1>& sum) {
        const std::size_t m = one ? 0 : material_of_body_[static_cast<std::size_t>(points.body[p])];
        double temperature = 0.0, frozen = 0.0, rise = 0.0; // degrees C, -, J/m^3
        supports.each_node_of(p, [&](std::size_t node, double phi, const Vector&) {
            if (!(phi > 0.0)) return;
            temperature += phi * temperature_[node];
            frozen += phi * frozen_[at(m, node)];
            rise += phi * change_[at(m, node)];
        });
        if (enthalpy_form_) {
            points.temperature[p] = temperature; // Eq. (37)
            points.enthalpy[p] += points.initial_volume[p] * rise;
        }
        points.ice_saturation[p] = materials_[m].ice_saturation(frozen);
        points.ice_fraction[p] = materials_[m].ice_volume(frozen) * points.initial_volume[p] / points.volume[p]; // theta_s, -
        sum[0] += poison(points.enthalpy[p] + points.ice_fraction[p]);
    });
    if (numbers[0] != 0.0) name_what_is_no_number(points);
}

void HeatSolver::name_what_is_no_number(Points& points) const {
    const std::string when = fmt::format("heat at t = {:.6g} s", clock_.time), remedy = "restart from the last checkpoint; look at what was set there";
    if (const auto fault = first_not_finite(points.state()))
        fail(ExitCode::failed, fmt::format("{}: point {} at ({:.4g}, {:.4g}) m: its {}", when, fault->row, points.position[fault->row][0], points.position[fault->row][1], fault->words()), remedy);
    for (std::size_t node = 0; node < nodes_; ++node)
        if (!std::isfinite(enthalpy_[node] + temperature_[node]))
            fail(ExitCode::failed, fmt::format("{}: node {}: its enthalpy is {} J/m3, its temperature {} C", when, node, enthalpy_[node], temperature_[node]), remedy);
    fail(ExitCode::failed, when + ": a number that is none", remedy);
}

} // namespace talik::driver
