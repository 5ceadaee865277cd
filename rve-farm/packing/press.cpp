#include "rve-farm/packing/press.hpp"

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "common/base/error.hpp"
#include "rve-farm/element/status_words.hpp"

namespace talik::farm {
namespace {

constexpr int sub_steps = 10;                   // of a macro step
constexpr double preparation_damping = 0.8;     // rest is what is wanted, not the way there
constexpr double inertial_number = 5e-4;        // of the compaction: quasi-static below about 1e-3
constexpr long most_macro_steps = 400000;

// pi r^2 t rho, kg
double disc_mass(const RveSpec& spec, double radius) {
    return std::numbers::pi * radius * radius * spec.parameters.thickness * spec.parameters.grain_density;
}

// A disc of a dense packing has a highest frequency of about 7 sqrt(k/m_min): the largest stable step is 0.21 of 2 sqrt(m/k)
// for the reference packing. Two thirds of that; a step found unstable is mended in step().
double sub_step_of(const RveSpec& spec) {
    const double stiffness = std::max(spec.parameters.contact.normal_stiffness, spec.parameters.contact.tangential_stiffness);
    return 0.14 * 2.0 * std::sqrt(disc_mass(spec, spec.packing.radius_min) / stiffness);
}

// Strain rate of the inertial number I = rate sqrt(m / (p t)), 1/s.
double compaction_rate(const RveSpec& spec) {
    const double mass = disc_mass(spec, 0.5 * (spec.packing.radius_min + spec.packing.radius_max));
    return inertial_number * std::sqrt(spec.packing.pressure * spec.parameters.thickness / mass);
}

RveParameters of_preparation(const RveSpec& spec, double friction, double sub_step) {
    RveParameters p = spec.parameters;
    p.bond.reset();
    p.fluctuation_stress = false;
    p.damping = preparation_damping;
    p.contact.friction = friction;
    p.time_step = sub_step;
    p.substeps = 0;
    return p;
}

FarmOptions one_thread() { // packings side by side take a thread each
    FarmOptions options;
    options.threads = 1;
    options.smaller_sub_steps = false; // it chooses them itself
    return options;
}

ServoTargets isotropic(double pressure) {
    return {ComponentTarget::stress(-pressure), ComponentTarget::stress(-pressure), ComponentTarget::stress(0.0)};
}

} // namespace

Press::Press(const RveSpec& spec, const Packing& start, double friction, long* steps_left)
    : pressure_(spec.packing.pressure), sub_step_(sub_step_of(spec)), steps_left_(steps_left),
      farm_(of_preparation(spec, friction, sub_step_), {start}, {0}, one_thread()),
      servo_(isotropic(pressure_), compaction_rate(spec)), state_(farm_.measure(0)) {}

double Press::steps_of_compaction(const RveSpec& spec, double from, double to) {
    return 0.5 * std::log((1.0 + from) / (1.0 + to)) / (compaction_rate(spec) * sub_steps * sub_step_of(spec)); // both directions shrink
}

void Press::compress_laterally_held(double vertical_stress) {
    pressure_ = vertical_stress;
    servo_.set_targets({ComponentTarget::rate(0.0), ComponentTarget::stress(-vertical_stress), ComponentTarget::stress(0.0)});
}

void Press::step() {
    if (steps_left_ && --*steps_left_ < 0) throw StepsSpent{state_.void_ratio, servo_.error(state_) / pressure_, state_.unbalanced_force};
    const std::uint32_t id = 0;
    const double increment = sub_steps * sub_step_;
    const auto strain = servo_.next(state_, increment);
    Answer answer;
    farm_.advance({&id, 1}, strain, {}, increment, sub_steps, {&answer, 1});
    if (answer.status == Status::unstable_step) { // the RVE is as it was: go on with a smaller step
        sub_step_ = 0.5 * answer.largest_stable_step;
        return;
    }
    if (answer.status != Status::ok)
        fail(ExitCode::failed, "preparing a packing failed: the assembly " + in_words(answer), "check sizes, stiffness and pressure");
    state_ = answer;
}

bool Press::settle(const Equilibrium& wanted) {
    int lasting = 0;
    for (long k = 0; k < most_macro_steps; ++k) {
        const bool at_rest = state_.contacts > 0 && servo_.error(state_) < wanted.stress_error * pressure_ && state_.unbalanced_force < wanted.unbalanced_force;
        lasting = at_rest ? lasting + 1 : 0;
        if (lasting >= wanted.lasting) return true;
        step();
    }
    return false;
}

Packing Press::at_rest(double pressure, std::uint64_t seed) {
    farm_.reset_velocities(0);
    Packing p = farm_.packing(0);
    p.velocity_x.clear(), p.velocity_y.clear(), p.spin.clear();
    p.pressure = pressure;
    p.seed = seed;
    p.stiffness = state_.stiffness;
    p.stable_step = farm_.largest_stable_step(0);
    return p;
}

} // namespace talik::farm
