#include "mpm-driver/boundary/wall.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "common/base/error.hpp"

namespace talik::driver {
namespace {

int axis_of(const WallSpec& spec) {
    const bool known = spec.side == "left" || spec.side == "right" || spec.side == "bottom" || spec.side == "top";
    require(known, "wall '" + spec.name + "': side is '" + spec.side + "'", "use left, right, bottom or top");
    return spec.side == "left" || spec.side == "right" ? 0 : 1;
}

} // namespace

Wall::Wall(const WallSpec& spec, const Grid& grid)
    : spec_(spec), motion_(spec.position, spec.velocity, spec.ramp), axis_(axis_of(spec)), tangent_(1 - axis_),
      inward_(spec.side == "left" || spec.side == "bottom" ? 1 : -1), stride_(grid.stride(axis_)),
      axis_nodes_(grid.nodes(axis_)), lines_(static_cast<std::size_t>(grid.nodes(tangent_))), touching_(lines_.size(), 0.0),
      sticking_(lines_.size(), spec.kind == "fixed" && !spec.separates ? without_limit : 0.0) {
    require(spec.kind == "roller" || spec.kind == "fixed", "wall '" + spec.name + "': kind is '" + spec.kind + "'",
            "use roller or fixed");
    require(spec.friction >= 0.0, "wall '" + spec.name + "': friction is negative", "give a coefficient of 0 or more");
    for (std::size_t k = 0; k < lines_.size(); ++k) lines_[k].first_node = static_cast<int>(k) * grid.stride(tangent_);
    locate_face(grid);
}

// Row j at or behind the face and the fraction s, (1-s) v_j + s v_{j+1} being the velocity at the face.
void Wall::locate_face(const Grid& grid) {
    const double face = grid.cells_from_first_node(axis_, position());
    outer_row_ = static_cast<int>(inward_ > 0 ? std::floor(face) : std::ceil(face));
    fraction_ = inward_ * (face - outer_row_);
    if (fraction_ > 1.0 - 1e-12) { // a face that lies on the next row but for rounding lies on it
        outer_row_ += inward_;
        fraction_ = 0.0;
    }
    if (face < 1.0 - 1e-9 || face > axis_nodes_ - 2 + 1e-9) // the domain without its ring of ghosts
        fail(ExitCode::bad_input, fmt::format("wall '{}' at {:.6g} m stands outside the domain", name(), position()),
             "enlarge the domain, or let the wall move less");
}

bool Wall::shares_rows_with(const Wall& other) const {
    const auto reaches = [](const Wall& wall) { // the row furthest out and the one furthest in, in order
        const int out = wall.outer_row_ - wall.inward_ * rows_outside, in = wall.outer_row_ + wall.inward_ * wall.innermost_row();
        return std::pair(std::min(out, in), std::max(out, in));
    };
    const auto [first, last] = reaches(*this);
    const auto [others_first, others_last] = reaches(other);
    return axis_ == other.axis_ && first <= others_last && others_first <= last;
}

// visit(node, distance): distance from the face in cells, positive inside.
template <class Visit>
void Wall::each_row(const Line& line, Visit&& visit) const {
    for (int k = -rows_outside; k <= innermost_row(); ++k) {
        const int row = outer_row_ + inward_ * k;
        if (row < 0 || row >= axis_nodes_) continue;
        const int node = line.first_node + row * stride_;
        visit(static_cast<std::size_t>(node), k - fraction_);
    }
}

// Velocity at the face, (1-s) v_j + s v_{j+1}; where the material reaches one row only, that row's. m/s
double Wall::face_speed(const std::vector<Vector>& velocity, const Grid& grid, const Line& line, int component) const {
    const std::size_t outer = static_cast<std::size_t>(line.first_node + outer_row_ * stride_);
    const std::size_t inner = static_cast<std::size_t>(static_cast<int>(outer) + inward_ * stride_);
    if (grid.mass[outer] <= 0.0) return velocity[inner][component];
    return (1.0 - fraction_) * velocity[outer][component] + fraction_ * velocity[inner][component];
}

void Wall::start_step(const Grid& grid, double dt, double confining_pressure, double pic) {
    locate_face(grid); // where the points are: at the start of the step
    held_velocity_ = velocity_; // v^n belongs to the wall's velocity of the last step: the points then gain its acceleration
    velocity_ = motion_.advance(dt);
    dt_ = dt;
    pressure_ = confining_pressure;
    pic_ = pic;
    for (Line& line : lines_) {
        line.normal_impulse = line.tangential_impulse = line.held_normal = line.held_tangential = line.held_work = 0.0;
        measure_line(grid, line);
    }
}

// Area of contact of a line: what a unit pressure pushes on the nodes near the face along the normal. With nodal weights
// that are 1 near the face and fall to 0 between 1.5 and 2.5 cells beneath it, this is (divergence theorem) the mean
// cross-section of the material in that layer: smooth as the face moves, and, at rest under -p I, force / p exactly. m^2
// Where the material ends before, its far face would push the other way: then it is the largest cross-section between two rows,
// the same as soon as the material fills the cells from one row to the next somewhere (always from two cells of depth on).
void Wall::measure_line(const Grid& grid, Line& line) const {
    constexpr double begin = 1.5, end = begin + 1.0; // of the layer, in cells beneath the face
    constexpr int rows_of_a_thin_body = 5;
    double section = 0.0, largest = 0.0, filled = 0.0, in_layer = 0.0; // m^2; section: between a row and the next
    for (int k = -rows_outside; k <= rows_of_a_thin_body; ++k) {
        const int row = outer_row_ + inward_ * k;
        if (row < 0 || row >= axis_nodes_) continue;
        const double push = inward_ * grid.unit_pressure_force[line.first_node + row * stride_][axis_];
        in_layer += std::clamp(end - (k - fraction_), 0.0, 1.0) * push;
        section += push;
        largest = std::max(largest, section);
        filled += std::max(section, 0.0);
    }
    line.area = filled < end * largest ? largest : in_layer; // filled / largest: depth of the material in cells
}

// The mass-weighted projection of the line's velocities on the linear fields {V + a d_k} through the face:
// a = sum m_k d_k (v_k - V) / sum m_k d_k^2; it takes the impulse sum m_k (V + a d_k - v_k), N s.
Wall::Projection Wall::project(const Grid& grid, const std::vector<Vector>& velocity, const Line& line, int component,
                               double target) const {
    double moment = 0.0, inertia = 0.0, impulse = 0.0;
    each_row(line, [&](std::size_t node, double d) {
        moment += grid.mass[node] * d * (velocity[node][component] - target);
        inertia += grid.mass[node] * d * d;
    });
    const double slope = inertia > 0.0 ? moment / inertia : 0.0;
    each_row(line, [&](std::size_t node, double d) {
        impulse += grid.mass[node] * (target + slope * d - velocity[node][component]);
    });
    return {impulse, slope};
}

// Takes the given part of the way to the projection. Nodes without mass follow: nothing reads them.
void Wall::correct(std::vector<Vector>& velocity, const Line& line, int component, double target, double slope, double part) const {
    each_row(line, [&](std::size_t node, double d) {
        velocity[node][component] += part * (target + slope * d - velocity[node][component]);
    });
}

// The wall's velocity in the step before, which the mapped v^n belongs to. Before the first step it either stood or moved as
// it does now: whichever is nearer to the material's. m/s
double Wall::held_speed(double face_speed) const {
    if (!std::isnan(held_velocity_)) return held_velocity_;
    return std::abs(face_speed) < std::abs(face_speed - velocity_) ? 0.0 : velocity_;
}

void Wall::hold_mapped_normal(Grid& grid) {
    for (std::size_t k = 0; k < lines_.size(); ++k) {
        if (spec_.separates && touching_[k] == 0.0) continue;
        const double target = held_speed(face_speed(grid.velocity_before, grid, lines_[k], axis_));
        const Projection to = project(grid, grid.velocity_before, lines_[k], axis_, target);
        correct(grid.velocity_before, lines_[k], axis_, target, to.slope, 1.0);
        lines_[k].held_normal += inward_ * to.impulse;
        lines_[k].held_work += target * to.impulse;
    }
}

void Wall::hold_mapped_tangential(Grid& grid) {
    for (std::size_t k = 0; k < lines_.size(); ++k) {
        if (sticking_[k] == 0.0) continue;
        const Projection to = project(grid, grid.velocity_before, lines_[k], tangent_, 0.0);
        const double through_pic = pic_ * std::abs(to.impulse); // pushes the body as friction does: within the last step's limit
        const double part = through_pic > sticking_[k] ? sticking_[k] / through_pic : 1.0;
        correct(grid.velocity_before, lines_[k], tangent_, 0.0, to.slope, part);
        lines_[k].held_tangential += part * to.impulse;
    }
}

void Wall::remember_slip(const Grid& grid) {
    if (has_tangential())
        for (Line& line : lines_) line.face_speed_before = face_speed(grid.velocity_before, grid, line, tangent_);
}

void Wall::constrain_normal(Grid& grid) {
    for (Line& line : lines_) {
        const Projection to = project(grid, grid.velocity, line, axis_, velocity_);
        const double missing = inward_ * to.impulse;
        double part = 1.0;
        if (spec_.separates) { // the total force may only push: lambda/dt + p A >= 0
            const double least = -pressure_ * std::max(line.area, 0.0) * dt_;
            const double allowed = std::max(line.normal_impulse + missing, least) - line.normal_impulse;
            part = missing != 0.0 ? std::clamp(allowed / missing, -1.0, 1.0) : 0.0;
        }
        correct(grid.velocity, line, axis_, velocity_, to.slope, part);
        line.normal_impulse += part * missing;
    }
}

// What a line may take along the wall, N s: all of it where it is fixed and touches; Coulomb's limit mu N dt of a roller, N the total
// push on the body, what the PIC fraction takes of holding the mapped velocity included.
double Wall::tangential_limit(const Line& line) const {
    if (spec_.kind == "fixed") return touches(line) ? without_limit : 0.0;
    return spec_.friction * std::max(line.normal_impulse + pic_ * line.held_normal + pressure_ * line.area * dt_, 0.0);
}

// Sticking along the wall, as far as the limit lets it.
void Wall::constrain_tangential(Grid& grid) {
    for (Line& line : lines_) {
        const Projection to = project(grid, grid.velocity, line, tangent_, 0.0);
        const double limit = tangential_limit(line), total = line.tangential_impulse + pic_ * line.held_tangential;
        const double allowed = limit == without_limit ? to.impulse : std::clamp(total + to.impulse, -limit, limit) - total;
        const double part = to.impulse != 0.0 ? std::clamp(allowed / to.impulse, -1.0, 1.0) : 0.0;
        correct(grid.velocity, line, tangent_, 0.0, to.slope, part);
        line.tangential_impulse += part * to.impulse;
    }
}

// A line that has let go is a free surface: the confining pressure acts there by itself.
bool Wall::touches(const Line& line) const {
    return !spec_.separates || line.normal_impulse + pressure_ * line.area * dt_ > 0.0;
}

void Wall::finish_step(const Grid& grid) {
    double normal = 0.0, tangential = 0.0, held_normal = 0.0, held_tangential = 0.0, held_work = 0.0, area = 0.0, friction = 0.0;
    for (std::size_t k = 0; k < lines_.size(); ++k) {
        const Line& line = lines_[k];
        normal += line.normal_impulse;
        tangential += line.tangential_impulse;
        held_normal += line.held_normal;
        held_tangential += line.held_tangential;
        held_work += line.held_work;
        touching_[k] = touches(line) ? 1.0 : 0.0;
        area += touching_[k] * line.area;
        if (!has_tangential()) continue;
        const double limit = tangential_limit(line);
        sticking_[k] = std::abs(line.tangential_impulse + pic_ * line.held_tangential) < limit ? limit : 0.0;
        if (spec_.kind == "fixed") continue;
        // -impulse times the mean slip velocity over the step, J
        friction -= line.tangential_impulse * 0.5 * (line.face_speed_before + face_speed(grid.velocity, grid, line, tangent_));
    }
    reaction_.impulse[axis_] = inward_ * (normal + pic_ * held_normal);
    reaction_.impulse[tangent_] = tangential + pic_ * held_tangential;
    reaction_.contact_area = area;
    reaction_.force = reaction_.impulse / dt_;
    reaction_.force[axis_] += inward_ * pressure_ * area;
    reaction_.work = reaction_.impulse[axis_] * velocity_;
    reaction_.pic_work = pic_ * held_work;
    reaction_.friction_dissipation = friction;
}

std::vector<StateColumn> Wall::state() {
    const std::string prefix = "walls/" + name() + "/";
    return {{prefix + "motion", "SI", "position m, time since it began to move s, moving", {"position", "elapsed", "moving"}, motion_.state().data(), 1},
            {prefix + "velocity", "m/s", "velocity along the axis", {""}, &velocity_, 1},
            {prefix + "force", "N", "force on the body", {"x", "y"}, reaction_.force.data(), 1},
            {prefix + "contact_area", "m2", "area of contact", {""}, &reaction_.contact_area, 1},
            {prefix + "touching", "-", "whether a line of nodes was held in the last step", {""}, touching_.data(), touching_.size()},
            {prefix + "sticking", "N s", "what a line of nodes that stuck in the last step could take", {""}, sticking_.data(), sticking_.size()}};
}

} // namespace talik::driver
