#include "mpm-driver/heat/held_nodes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace talik::driver {

HeldNodes::HeldNodes(const HeatSpec& spec, const Grid& grid)
    : sides_(spec.boundaries), heaters_(spec.heaters), on_(spec.heaters.size(), 0), mark_(static_cast<std::size_t>(grid.node_count()), -1) {
    const auto add = [&](const std::string& name, const TimeValueSpec& value, bool temperature) {
        names_.push_back(name);
        values_.emplace_back(value, "\"" + name + "\"");
        if (!temperature) return;
        least_ = std::min(least_, values_.back().least());
        most_ = std::max(most_, values_.back().most());
    };
    for (const HeatBoundarySpec& side : sides_) add(side.name, side.value, side.kind == "temperature");
    for (const HeaterSpec& heater : heaters_) add(heater.name, heater.value, true);
    held_.reserve(mark_.size()); // nothing is allocated within a step
    fluxes_.reserve(mark_.size());
}

bool HeldNodes::switched_on(const HeaterSpec& heater, double time) const {
    return (!heater.begins || time >= *heater.begins) && (!heater.ends || time < *heater.ends);
}

double HeldNodes::next_switch(double time) const {
    double next = std::numeric_limits<double>::infinity();
    for (const HeaterSpec& heater : heaters_)
        for (const auto& change : {heater.begins, heater.ends})
            if (change && *change > time) next = std::min(next, *change);
    return next;
}

bool HeldNodes::switched_since(double time) const {
    for (std::size_t i = 0; i < heaters_.size(); ++i)
        if (switched_on(heaters_[i], time) != (on_[i] != 0)) return true;
    return false;
}

void HeldNodes::update(const Grid& grid, const std::vector<double>& volume, double time, bool moved) {
    bool same = fresh_ && !moved;
    for (std::size_t i = 0; i < heaters_.size(); ++i) {
        const char on = switched_on(heaters_[i], time);
        same = same && on == on_[i];
        on_[i] = on;
    }
    if (same) return;
    fresh_ = true;
    std::fill(mark_.begin(), mark_.end(), -1);
    held_.clear();
    fluxes_.clear();
    for (std::size_t i = 0; i < sides_.size(); ++i) {
        const int entry = static_cast<int>(i);
        each_of_side(grid, volume, sides_[i], [&](int node) { mark_[static_cast<std::size_t>(node)] = entry; },
                     [&](int node, double width) { fluxes_.push_back({node, entry, width * grid.cell() * grid.thickness()}); });
    }
    for (std::size_t i = 0; i < heaters_.size(); ++i)
        if (on_[i]) hold_region(grid, volume, heaters_[i], static_cast<int>(sides_.size() + i));
    for (std::size_t node = 0; node < mark_.size(); ++node)
        if (mark_[node] >= 0) held_.push_back({static_cast<int>(node), mark_[node]});
}

// Line of nodes by line of nodes, from outside inwards. A node on the surface of a full line has half of a whole node's
// volume; within half a cell of it, between 1/8 and 7/8. Ground may be thinner than a cell: its first node is then the nearest.
template <class Hold, class Enter>
void HeldNodes::each_of_side(const Grid& grid, const std::vector<double>& volume, const HeatBoundarySpec& side, Hold&& hold, Enter&& enter) const {
    const int axis = side.side == "left" || side.side == "right" ? 0 : 1, along = 1 - axis;
    const bool from_below = side.side == "left" || side.side == "bottom";
    const int depth = grid.nodes(axis), lines = grid.nodes(along);
    const double h = grid.cell(), slack = 1e-9 * h, whole = h * h * grid.thickness();
    for (int line = 0; line < lines; ++line) {
        const auto node_at = [&](int k) {
            const int inward = from_below ? k : depth - 1 - k;
            return axis == 0 ? grid.node(inward, line) : grid.node(line, inward);
        };
        const double x = grid.node_position(node_at(0))[along];
        const double low = side.from.value_or(-1e300), high = side.to.value_or(1e300);
        double most = 0.0, all = 0.0, beside = 0.0; // m^3: of the line's fullest node, of the line, of the fuller line beside it
        for (int k = 0; k < depth; ++k) most = std::max(most, volume[static_cast<std::size_t>(node_at(k))]), all += volume[static_cast<std::size_t>(node_at(k))];
        if (most <= 0.0) continue;
        for (int other : {line - 1, line + 1}) {
            if (other < 0 || other >= lines) continue;
            double sum = 0.0;
            for (int k = 0; k < depth; ++k) sum += volume[static_cast<std::size_t>(axis == 0 ? grid.node(k, other) : grid.node(other, k))];
            beside = std::max(beside, sum);
        }
        if (side.kind == "flux") {
            const double overlap = std::min(x + 0.5 * h, high) - std::max(x - 0.5 * h, low);
            if (overlap <= slack) continue;
            // How much of the line's cell is ground, across: a whole node where it is two cells deep, as full as the next line where it is thinner.
            const double ground = std::max(most / whole, all / std::max(all, beside));
            const double width = std::min({overlap / h, ground, 1.0}); // of a cell
            for (int k = 0; k < depth; ++k) {
                const int node = node_at(k);
                if (volume[static_cast<std::size_t>(node)] < most / 8.0) continue;
                enter(node, width);
                break;
            }
            continue;
        }
        if (x < low - slack || x > high + slack) continue;
        bool found = false;
        for (int k = 0; k < depth; ++k) {
            const double here = volume[static_cast<std::size_t>(node_at(k))];
            if (here <= 0.0) continue;
            if (found && here >= 0.875 * most * (1.0 - 1e-9)) break;
            hold(node_at(k));
            found = true;
            if (here >= 0.125 * most) break; // the nearest to the surface
        }
    }
}

bool HeldNodes::in_region(const Grid& grid, const HeaterSpec& heater, int node) const {
    const Vector x = grid.node_position(node);
    const double slack = 1e-9 * grid.cell();
    if (!heater.box.empty()) {
        const Vector low = heater.box[0].cwiseMin(heater.box[1]), high = heater.box[0].cwiseMax(heater.box[1]);
        return ((x - low).array() >= -slack).all() && ((high - x).array() >= -slack).all();
    }
    const Vector a = heater.line[0], d = heater.line[1] - a;
    const double t = std::clamp((x - a).dot(d) / std::max(d.squaredNorm(), 1e-300), 0.0, 1.0);
    return ((x - a - t * d).cwiseAbs().array() <= 0.5 * grid.cell() + slack).all(); // within half a cell of the line
}

void HeldNodes::hold_region(const Grid& grid, const std::vector<double>& volume, const HeaterSpec& heater, int entry) {
    for (int node = 0; node < grid.node_count(); ++node)
        if (volume[static_cast<std::size_t>(node)] > 0.0 && in_region(grid, heater, node)) mark_[static_cast<std::size_t>(node)] = entry;
}

std::string HeldNodes::idle_side(const Grid& grid, const std::vector<double>& volume) const {
    for (const HeatBoundarySpec& side : sides_) {
        bool any = false;
        each_of_side(grid, volume, side, [&](int) { any = true; }, [&](int, double) { any = true; });
        if (!any) return side.name;
    }
    return "";
}

std::string HeldNodes::idle_heater(const Grid& grid, const std::vector<double>& volume) const {
    for (const HeaterSpec& heater : heaters_) {
        bool any = false;
        for (int node = 0; node < grid.node_count() && !any; ++node) any = volume[static_cast<std::size_t>(node)] > 0.0 && in_region(grid, heater, node);
        if (!any) return heater.name;
    }
    return "";
}

} // namespace talik::driver
