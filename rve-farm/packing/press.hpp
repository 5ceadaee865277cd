#pragma once
// One RVE under a press: all three stress components are held at an isotropic pressure, or the vertical one without
// lateral strain, whatever the discs do. Used to prepare packings.
#include "common/packing/packing_spec.hpp"
#include "rve-farm/backend/farm.hpp"
#include "rve-farm/element/servo.hpp"

namespace talik::farm {

// What "at rest under the pressure" means.
struct Equilibrium {
    double stress_error = 1e-3;    // of each component, over the pressure; half of what is promised
    double unbalanced_force = 1e-4; // mean force on a disc / mean contact force
    int lasting = 10;              // macro steps in a row
};

// Thrown where the steps allowed are spent: what was reached by then.
struct StepsSpent {
    double void_ratio, stress_error, unbalanced_force; // stress error over the pressure
};

class Press {
public:
    // Preparation has a step and a damping of its own, so that a packing does not depend on those of the run it is for.
    // steps_left: macro steps allowed, shared by all presses of one search; null = no limit.
    Press(const RveSpec& spec, const Packing& start, double friction, long* steps_left = nullptr);

    // Macro steps of the mere compaction from one void ratio to another: the less the pressure the more, since it goes as slowly
    // as the discs are pressed.
    static double steps_of_compaction(const RveSpec& spec, double from, double to);

    void step();                              // one macro step
    bool settle(const Equilibrium& wanted);   // false: not within a strain of some hundred per cent
    // From now on: vertical stress held, lateral strain 0. The shear stress is held at 0, which by symmetry it is in level
    // ground; a small packing would else show that of its own few contacts. vertical_stress: Pa, compression positive.
    void compress_laterally_held(double vertical_stress);
    void set_friction(double friction) { farm_.set_friction(friction); }

    const Answer& state() const { return state_; }
    Packing at_rest(double pressure, std::uint64_t seed); // stops the discs; the packing as it stands

private:
    double pressure_;  // Pa: that of the held stresses, which errors are measured by
    double sub_step_;  // s
    long* steps_left_;
    Farm farm_;
    Servo servo_;
    Answer state_;
};

} // namespace talik::farm
