// Simulation: its stages, from what a stage switches on to what ends it.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "common/base/error.hpp"
#include "mpm-driver/mechanics/simulation.hpp"

namespace talik::driver {

const StageSpec& Simulation::present_stage() const {
    ensure(!finished());
    return scene_.stages[static_cast<std::size_t>(stage())];
}

void Simulation::enter_stage() {
    clock_.stage_start = clock_.time;
    clock_.internal_work_at_stage_start = ledger_.internal_work;
    if (finished()) return;
    const StageSpec& stage = present_stage();
    for (Wall& wall : walls_) {
        const bool moves = std::find(stage.moves.begin(), stage.moves.end(), wall.name()) != stage.moves.end();
        moves ? wall.start_moving() : wall.stop();
    }
    for (const std::string& name : stage.moves)
        require(std::any_of(walls_.begin(), walls_.end(), [&](const Wall& wall) { return wall.name() == name; }),
                "stage '" + stage.name + "' moves the wall '" + name + "', which the scene does not have", "name one of its walls");
    for (const std::string& effect : stage.activates) {
        bool known = false;
        for (auto& [name, law] : laws_) known = law->activate(effect, points_of(stage.activates_in)) || known;
        require(known, "stage '" + stage.name + "' activates '" + effect + "', which none of the scene's laws has",
                "take it out, or add the effect to the law");
    }
}

// Of the bodies named; of all where none is.
std::vector<std::uint32_t> Simulation::points_of(const std::vector<std::string>& bodies) const {
    std::vector<std::uint32_t> ids;
    for (std::size_t p = 0; p < points_.count(); ++p)
        if (bodies.empty() || std::find(bodies.begin(), bodies.end(), scene_.bodies[static_cast<std::size_t>(points_.body[p])].name) != bodies.end())
            ids.push_back(static_cast<std::uint32_t>(p));
    return ids;
}

// Of the present stage: grown smoothly (3 s^2 - 2 s^3, no jump of the force's rate) from that at the end of the stage before.
Vector Simulation::gravity_at(double time) const {
    const StageSpec& stage = present_stage();
    const double part = stage.gravity_ramp > 0.0 ? std::clamp((time - clock_.stage_start) / stage.gravity_ramp, 0.0, 1.0) : 1.0;
    const Vector before(clock_.gravity_x, clock_.gravity_y);
    return before + part * part * (3.0 - 2.0 * part) * (stage.gravity - before);
}

// At rest: kinetic energy below a part of the internal work of the stage so far, for ten steps in a row, so that the
// moment in which a swinging body turns back is not taken for rest; and not while gravity still grows.
bool Simulation::is_at_rest() {
    const StageSpec& stage = present_stage();
    const double work = std::abs(ledger_.internal_work - clock_.internal_work_at_stage_start); // J
    const bool ramped = clock_.time >= clock_.stage_start + stage.gravity_ramp;
    const bool slow = stage.energy_ratio && ramped && work > 0.0 && ledger_.kinetic < *stage.energy_ratio * work;
    clock_.steps_at_rest = slow ? clock_.steps_at_rest + 1.0 : 0.0;
    return clock_.steps_at_rest >= steps_of_rest;
}

void Simulation::leave_stage_when_done() {
    const StageSpec& stage = present_stage();
    const double remaining = clock_.stage_start + stage.duration - clock_.time;
    const double rounding = scene_.step.fixed ? clock_rounding * *scene_.step.fixed : 1e-9 * stage.duration;
    const bool at_rest = is_at_rest();
    if (remaining > rounding && !at_rest) return;
    if (stage.energy_ratio && !at_rest)
        unrest_[static_cast<std::size_t>(this->stage())] = ledger_.kinetic / std::max(std::abs(ledger_.internal_work - clock_.internal_work_at_stage_start), 1e-300);
    const Vector gravity = gravity_at(clock_.time);
    clock_.gravity_x = gravity[0], clock_.gravity_y = gravity[1];
    clock_.steps_at_rest = 0.0;
    clock_.stage += 1.0;
    enter_stage();
}

std::vector<std::string> Simulation::warnings() const {
    std::vector<std::string> out;
    if (clock_.unsafe_steps > 0.0)
        out.push_back(fmt::format("{:.0f} of {} steps were beyond the one that is stable wherever points lie in their cells: without damping, free surfaces may vibrate; step.fixed = \"auto\" heeds them",
                                  clock_.unsafe_steps, steps_done()));
    for (std::size_t k = 0; k < unrest_.size(); ++k)
        if (unrest_[k] > 0.0)
            out.push_back(fmt::format("stage \"{}\" ended at its latest time before it came to rest: kinetic energy is {:.2g} of its internal work, asked for were {:.2g}",
                                      scene_.stages[k].name, unrest_[k], *scene_.stages[k].energy_ratio));
    return out;
}

double Simulation::end_time() const {
    double end = clock_.stage_start;
    for (std::size_t k = static_cast<std::size_t>(stage()); k < scene_.stages.size(); ++k) end += scene_.stages[k].duration;
    return end;
}

} // namespace talik::driver
