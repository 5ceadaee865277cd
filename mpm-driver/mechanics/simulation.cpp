#include "mpm-driver/mechanics/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "common/base/error.hpp"
#include "mpm-driver/grid/parallel.hpp"
#include "mpm-driver/boundary/walls.hpp"
#include "mpm-driver/mechanics/transfer.hpp"
#include "mpm-driver/points/seed.hpp"
#include "mpm-driver/points/soundness.hpp"

namespace talik::driver {

Simulation::Simulation(const Scene& scene, Laws laws)
    : scene_(scene), laws_(std::move(laws)),
      grid_(scene.domain.origin, scene.domain.size, scene.domain.cell, scene.domain.thickness, scene.mechanics()),
      points_(seed_points(scene.bodies, grid_, scene.mechanics())), supports_(grid_, points_.count()) {
    require(!scene_.stages.empty(), "the scene has no stage", "add a [[stage]] with a duration");
    for (const BodySpec& body : scene_.bodies) half_size_.push_back(point_half_size(body, grid_.cell()));
    for (const WallSpec& wall : scene_.walls) walls_.emplace_back(wall, grid_);
    if (scene_.domain.volume_strain == "cell") cell_means_.emplace(grid_, points_.count());
    supports_.update(grid_, points_, half_size_);
    if (scene_.heat) heat_ = std::make_unique<HeatSolver>(scene_, grid_, supports_, half_size_, points_);
    if (scene_.phase_change_strain) phase_change_strain_.emplace(scene_, points_);
    if (mechanics()) begin_laws();
    unrest_.assign(scene_.stages.size(), 0.0);
    ledger_.open(points_);
    build_schedule();
    enter_stage();
}

// The table of contents of a step.
void Simulation::build_schedule() {
    if (mechanics()) schedule_.add("shape functions", [this] { supports_.update(grid_, points_, half_size_); });
    if (heat_) schedule_.add("heat", [this] { advance_heat(); });
    if (!mechanics()) return;
    schedule_.add("points to grid", [this] { points_to_grid(points_, supports_, grid_); });
    if (cell_means_) schedule_.add("points in cells", [this] { cell_means_->locate(grid_, points_); });
    schedule_.add("nodal forces", [this] {
        nodal_forces(points_, cell_means_ ? cell_means_->acting_stress(points_) : points_.stress, supports_, scene_.confining_pressure,
                     gravity_, grid_);
    });
    schedule_.add("hold at walls", [this] {
        if (!prescribed_) hold_mapped_velocity(walls_, grid_, dt_, scene_.confining_pressure, present_stage().pic);
    });
    schedule_.add("advance grid", [this] { advance_grid(grid_, dt_); });
    schedule_.add("walls", [this] { constrain_grid(); });
    schedule_.add("check of numbers", [this] { if (safeguards_) check_numbers(); });
    schedule_.add("strain increments", [this] { strain_increments(grid_, supports_, dt_, points_); });
    if (cell_means_) schedule_.add("volume strain of cells", [this] { cell_means_->average_volume_strain(points_); });
    if (phase_change_strain_) schedule_.add("strain of phase change", [this] { phase_change_strain_->subtract(points_); });
    schedule_.add("ask laws", [this] { submit_to_laws(); });
    schedule_.add("grid to points", [this] { move_points(); });
    schedule_.add("wait for laws", [this] { collect_from_laws(); });
    schedule_.add("deformation", [this] { update_deformation(points_, steps_done() + 1, time(), [this] { return hint_of_step(); }); });
    schedule_.add("ledger", [this] { book_step(); });
}

void Simulation::begin_laws() {
    std::vector<std::string> names;
    for (auto& [name, law] : laws_) {
        law_points_.push_back({law.get(), {}});
        names.push_back(name);
    }
    for (std::size_t p = 0; p < points_.count(); ++p) {
        const BodySpec& body = scene_.bodies[points_.body[p]];
        const auto found = std::find(names.begin(), names.end(), body.law);
        require(found != names.end(), "body '" + body.name + "' asks for the law '" + body.law + "', which the scene does not describe",
                "describe it, or use another law");
        points_.law[p] = static_cast<int>(found - names.begin());
        points_.stress[p] = body.stress;
        law_points_[points_.law[p]].ids.push_back(static_cast<std::uint32_t>(p));
    }
    for (LawPoints& group : law_points_) group.law->begin(group.ids, points_, answer_columns());
    points_.initial_p_wave_modulus = points_.p_wave_modulus;
}

LawAnswer Simulation::answer_columns() {
    return {points_.stress.data(), points_.p_wave_modulus.data(), points_.energy.data()};
}

StepLimit Simulation::stable_step() const {
    if (mechanics()) return mechanical_step_limit(grid_, points_, half_size_);
    StepLimit limit;
    limit.step = limit.surface_step = std::numeric_limits<double>::infinity();
    return limit;
}

std::string Simulation::describe_limits() const {
    std::string text = mechanics() ? describe(stable_step(), grid_.cell()) : "";
    if (heat_) text += (text.empty() ? "heat " : "; heat ") + heat_->describe(heat_->limit(grid_, points_), grid_);
    return text;
}

double Simulation::next_step() const {
    const double remaining = clock_.stage_start + present_stage().duration - clock_.time;
    if (scene_.step.fixed) return remaining < (1.0 - clock_rounding) * *scene_.step.fixed ? remaining : *scene_.step.fixed;
    const StepLimit limit = stable_step();
    const double step = mechanics() ? scene_.step.safety * std::min(limit.step, limit.surface_step) : heat_->limit(grid_, points_).automatic;
    return step > remaining * (1.0 - 1e-9) ? remaining : step;
}

void Simulation::check_step(double dt) {
    if (!safeguards_) return;
    if (!mechanics()) return refuse_beyond(heat_->limit(grid_, points_), dt); // with mechanics, heat takes sub-steps of its own
    const StepLimit limit = stable_step();
    if (std::isnan(limit.step) || std::isnan(dt)) name_what_is_no_number();
    if (clock_.first_limit == 0.0) clock_.first_limit = limit.step;
    if (scene_.step.fixed && dt > limit.safe_step) clock_.unsafe_steps += 1.0;
    if (!scene_.step.fixed && limit.step < 0.5 * clock_.first_limit) note(Help::smaller_step, clock_.first_limit / limit.step, limit.point);
    refuse_beyond(limit, dt);
}

void Simulation::check_next_step() {
    if (finished() || !safeguards_) return;
    if (mechanics()) refuse_beyond(stable_step(), next_step());
    else refuse_beyond(heat_->limit(grid_, points_), next_step());
}

std::string Simulation::at_this_step() const {
    return steps_done() == 0 ? "" : fmt::format(", in step {} at t = {:.6g} s", steps_done() + 1, time());
}

// A step too large is bad input where it is the first.
void Simulation::refuse_beyond(const HeatLimit& limit, double dt) const {
    if (dt <= limit.step * (1.0 + 1e-9)) return;
    fail(steps_done() == 0 ? ExitCode::bad_input : ExitCode::failed, fmt::format("the step of {:.4g} s is beyond the largest stable one of heat, {}{}", dt, heat_->describe(limit, grid_), at_this_step()),
         fmt::format("use step.fixed = \"auto\", or at most {:.3g} s", limit.automatic));
}

void Simulation::refuse_beyond(const StepLimit& limit, double dt) {
    if (std::isnan(limit.step) || std::isnan(dt)) name_what_is_no_number();
    if (dt <= limit.step) return;
    fail(steps_done() == 0 ? ExitCode::bad_input : ExitCode::failed,
         fmt::format("the step of {:.4g} s is beyond the largest stable one, {}{}", dt, describe(limit, grid_.cell()), at_this_step()),
         fmt::format("use step.fixed = \"auto\", or at most {:.3g} s", 0.5 * std::min(limit.step, limit.surface_step)));
}

void Simulation::step(double dt) {
    check_step(dt);
    if (steps_done() == 0) ledger_.open(points_); // with what the caller may have set since
    dt_ = dt;
    gravity_ = gravity_at(clock_.time + 0.5 * dt);
    schedule_.run();
    clock_.time += dt;
    clock_.step += 1.0;
    leave_stage_when_done();
}

// Heat goes on by sub-steps of its own where its limit is below the mechanical step; where it is above, once in as many
// steps as fit into it and leave the ice without leaps, at the end of a stage, and before a heater is switched.
void Simulation::advance_heat() {
    clock_.pending_heat += dt_;
    if (!mechanics()) {
        heat_->advance(grid_, supports_, points_, clock_.pending_heat, 1, false);
    } else {
        const double allowed = heat_->limit(grid_, points_).automatic;
        const double remaining = clock_.stage_start + present_stage().duration - clock_.time - dt_;
        const bool switches = clock_.time + 2.0 * dt_ > heat_->next_switch(); // within the next step
        const bool may_end = clock_.steps_at_rest + 1.0 >= steps_of_rest;     // the stage, by coming to rest
        if (clock_.pending_heat + dt_ <= std::min(allowed, heat_->interval_of_ice()) && remaining > 0.5 * dt_ && !switches && !may_end) return;
        const double wanted = std::ceil(clock_.pending_heat / allowed * (1.0 - 1e-9));
        require(wanted <= 1e5, fmt::format("a mechanical step of {:.3g} s would need {:.3g} sub-steps of heat", clock_.pending_heat, wanted), "give a smaller heat.time_scale, a coarser domain.cell or a smaller step");
        const int substeps = std::max(1, static_cast<int>(wanted));
        heat_->advance(grid_, supports_, points_, clock_.pending_heat, substeps, true);
        if (substeps > 1) note(Help::heat_sub_steps, substeps);
        if (heat_->enthalpy_cut() > 0.0) note(Help::cut_enthalpy, heat_->enthalpy_cut());
        if (substeps == 1 && heat_->interval_of_ice() < allowed) note(Help::shorter_heat_steps, 1.0);
    }
    clock_.pending_heat = 0.0;
}

void Simulation::restored() {
    if (phase_change_strain_) phase_change_strain_->update_volumes(points_);
    if (mechanics()) return; // nodes are gathered anew in every step; what heat has published is a column of the state
    supports_.update(grid_, points_, half_size_);
    heat_->restored(grid_, supports_, points_);
}

void Simulation::constrain_grid() {
    if (!prescribed_) return constrain(walls_, grid_);
    for (int node = 0; node < grid_.node_count(); ++node)
        grid_.velocity[static_cast<std::size_t>(node)] = (*prescribed_)(grid_.node_position(node));
}

void Simulation::submit_to_laws() {
    point_work_ = 0.5 * stress_power(points_); // with the stress and volume at the start of the step
    law_work_ = 0.5 * law_power();
    const auto number = static_cast<std::uint64_t>(steps_done()) + 1;
    const auto& increments = phase_change_strain_ ? phase_change_strain_->increments() : points_.displacement_gradient_increment;
    const auto& volumes = phase_change_strain_ ? phase_change_strain_->volumes() : points_.volume;
    for (LawPoints& group : law_points_)
        group.law->submit({number, dt_, group.ids, increments.data(), volumes.data(), points_.initial_volume.data(),
                            points_.ice_saturation.empty() ? nullptr : points_.ice_saturation.data()},
                          answer_columns());
}

// Of what the laws are asked for; 0 where that is what the points strain by.
double Simulation::law_power() const {
    return phase_change_strain_ ? stress_power(points_, phase_change_strain_->increments(), phase_change_strain_->volumes()) : 0.0;
}

void Simulation::move_points() {
    const StageSpec& stage = present_stage();
    point_books_ = grid_to_points(grid_, supports_, {stage.pic, stage.particle_damping, stage.grid_damping}, dt_, points_);
    for (std::size_t p = 0; p < points_.count(); ++p) {
        const Vector& x = points_.position[p];
        if (!x.allFinite()) name_what_is_no_number();
        if (!grid_.inside_domain(x))
            fail(ExitCode::failed,
                 fmt::format("point {} of body '{}' leaves the domain at ({:.4g}, {:.4g}) m in step {} at t = {:.6g} s, with velocity ({:.3g}, {:.3g}) m/s",
                             p, scene_.bodies[points_.body[p]].name, x[0], x[1], steps_done() + 1, time(), points_.velocity[p][0],
                             points_.velocity[p][1]),
                 "enlarge the domain, add a wall, or look for an instability in the fields before it" + hint_of_step());
    }
}

void Simulation::note(Help help, double amount, std::optional<std::uint32_t> point) {
    self_help_.note(help, {clock_.time, steps_done() + 1}, amount, point, point ? points_.position[*point] : Vector::Zero());
}

// A fixed step that may be the cause.
std::string Simulation::hint_of_step() const {
    if (clock_.unsafe_steps == 0.0) return "";
    return fmt::format("; {:.0f} steps were longer than the {:.3g} s that is stable wherever points lie: step.fixed = \"auto\" heeds free surfaces", clock_.unsafe_steps, stable_step().safe_step);
}

// After the grid has been advanced and before a point is touched: what is no number in a point's state has reached its nodes.
void Simulation::check_numbers() {
    const auto sum = ordered_sums<1>(grid_.mass.size(), [&](std::size_t node, std::array<double, 1>& numbers) {
        numbers[0] += poison(grid_.mass[node] + grid_.velocity[node][0]) + poison(grid_.velocity[node][1] + grid_.force[node][0] + grid_.force[node][1]);
    })[0];
    if (sum != 0.0) name_what_is_no_number();
}

void Simulation::name_what_is_no_number() {
    const std::string when = fmt::format("in step {} at t = {:.6g} s", steps_done() + 1, time());
    const std::string remedy = "restart from the last checkpoint; look at what was set there, and at the fields before it" + hint_of_step();
    if (const auto fault = first_not_finite(points_.state())) {
        const Vector& x = points_.position[fault->row];
        fail(ExitCode::failed, fmt::format("point {} of body '{}' at ({:.4g}, {:.4g}) m: its {} {}", fault->row, scene_.bodies[points_.body[fault->row]].name, x[0], x[1], fault->words(), when), remedy);
    }
    for (int node = 0; node < grid_.node_count(); ++node) {
        const auto n = static_cast<std::size_t>(node);
        const Vector x = grid_.node_position(node);
        const char* field = !std::isfinite(grid_.mass[n]) ? "mass" : !grid_.force[n].allFinite() ? "force" : !grid_.velocity[n].allFinite() ? "velocity" : nullptr;
        if (field) fail(ExitCode::failed, fmt::format("node {} at ({:.4g}, {:.4g}) m: its {} is no number {}", node, x[0], x[1], field, when), remedy);
    }
    fail(ExitCode::failed, "a number that is none " + when, remedy);
}

void Simulation::collect_from_laws() {
    for (LawPoints& group : law_points_) {
        group.law->collect();
        for (const LawEvent& event : group.law->events()) note(event.help, event.amount, event.point);
    }
}

void Simulation::book_step() {
    point_work_ += 0.5 * stress_power(points_); // and with those at its end: trapezoidal, as the grid's sum over steps is
    if (phase_change_strain_) {
        phase_change_strain_->update_volumes(points_);
        law_work_ += 0.5 * law_power();
        ledger_.phase_change += point_work_ - law_work_;
    }
    ledger_.book_grid(grid_, dt_, scene_.confining_pressure, gravity_, walls_, prescribed_.has_value());
    ledger_.book_points(points_, point_books_, point_work_);
    if (poison(ledger_.kinetic + point_work_ + ledger_.law_energy) != 0.0) name_what_is_no_number();
}

std::vector<StateColumn> Simulation::state() {
    std::vector<StateColumn> columns = points_.state();
    const auto append = [&](std::vector<StateColumn> more) { columns.insert(columns.end(), more.begin(), more.end()); };
    for (Wall& wall : walls_) append(wall.state());
    append(ledger_.state());
    append({{"stages", "-", "kinetic energy over internal work of the stages that ended before they came to rest; 0 = none", {""}, unrest_.data(), unrest_.size()}});
    if (heat_) append(heat_->state());
    if (phase_change_strain_) append(phase_change_strain_->state());
    append(self_help_.state());
    append({{"clock", "SI", "time s, steps, stage, start of the stage s, internal work J and gravity m/s2 at that start, steps at rest, heat yet to come s, first limit of the step s, fixed steps beyond the safe one",
             {"time", "step", "stage", "stage_start", "internal_work_at_stage_start", "gravity_x", "gravity_y", "steps_at_rest", "pending_heat", "first_limit", "unsafe_steps"}, &clock_.time, 1}});
    return columns;
}

} // namespace talik::driver
