#pragma once
// A run of the macro solver: owns grid, points, walls, laws, clock and ledger, and takes steps.
//
//     Simulation simulation(scene, std::move(laws));
//     while (!simulation.finished()) simulation.step(simulation.next_step());
//
// Restart: construct from the same scene, restore the laws' own files, then fill the columns of state().
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mpm-driver/app/scene.hpp"
#include "mpm-driver/boundary/prescribed_field.hpp"
#include "mpm-driver/boundary/wall.hpp"
#include "mpm-driver/constitutive/law.hpp"
#include "mpm-driver/grid/grid.hpp"
#include "mpm-driver/heat/heat_solver.hpp"
#include "mpm-driver/mechanics/cell_means.hpp"
#include "mpm-driver/mechanics/ledger.hpp"
#include "mpm-driver/mechanics/phase_change_strain.hpp"
#include "mpm-driver/mechanics/schedule.hpp"
#include "mpm-driver/mechanics/step_limit.hpp"
#include "mpm-driver/mechanics/supports.hpp"
#include "mpm-driver/mechanics/transfer.hpp"
#include "mpm-driver/points/points.hpp"
#include "mpm-driver/points/self_help.hpp"

namespace talik::driver {

class Simulation {
public:
    using Laws = std::map<std::string, std::unique_ptr<Law>>; // by the name the bodies use: "elastic", "rve"

    // The bodies' densities must be set (from the packing where the scene gives none).
    Simulation(const Scene& scene, Laws laws);
    Simulation(const Simulation&) = delete; // the schedule refers to this object
    Simulation& operator=(const Simulation&) = delete;

    bool finished() const { return stage() >= static_cast<int>(scene_.stages.size()); }
    double next_step() const;          // s: the fixed one, or safety times the limit; either is cut at the end of a stage
    StepLimit stable_step() const;     // Eq. (42), for the present state; without end where nothing moves
    std::string describe_limits() const;
    void step(double dt);              // refuses a dt beyond the limit
    void check_next_step();            // refuses as step() will, and changes nothing

    double time() const { return clock_.time; }                                       // s
    std::int64_t steps_done() const { return static_cast<std::int64_t>(clock_.step); }
    int stage() const { return static_cast<int>(clock_.stage); }                      // index into scene.stages
    double end_time() const;                                                          // s, at most

    const Scene& scene() const { return scene_; }
    const Grid& grid() const { return grid_; }
    const Points& points() const { return points_; }
    Points& points() { return points_; } // for initial conditions beyond what a scene says
    const std::vector<Wall>& walls() const { return walls_; }
    std::vector<std::string> warnings() const; // of steps beyond the safe one, and of stages that ended before they came to rest, also before a restart
    const SelfHelp& self_help() const { return self_help_; }
    void leave_out_safeguards(bool out = true) { safeguards_ = !out; } // tests, and the measurement of what they cost
    const Ledger& ledger() const { return ledger_; }
    bool mechanics() const { return points_.mechanical; } // else heat alone
    const HeatSolver* heat() const { return heat_.get(); } // null where the scene has none
    HeatSolver* heat() { return heat_.get(); }
    void set_temperature(const std::vector<double>& celsius) { heat_->set_temperature(grid_, supports_, points_, celsius); } // by point, before the first step
    void restored(); // after the columns of state() were filled
    const Schedule& schedule() const { return schedule_; }
    const Laws& laws() const { return laws_; }
    Law& law(const std::string& name) { return *laws_.at(name); }

    void prescribe(const PrescribedField& field) { prescribed_ = field; } // all nodes, from now on

    // Every double a bit-exact restart needs beside the scene and the laws' own state.
    std::vector<StateColumn> state();

private:
    static constexpr double steps_of_rest = 10.0; // in a row end a stage that waits for rest
    static constexpr double clock_rounding = 1e-4; // of a fixed step: what a clock of 1e6 steps may be off by; no step is cut for less

    struct Clock { // doubles only: it travels as a column of the state
        double time = 0.0, step = 0.0, stage = 0.0, stage_start = 0.0, internal_work_at_stage_start = 0.0;
        double gravity_x = 0.0, gravity_y = 0.0; // when the stage began, m/s^2: a ramp starts from it
        double steps_at_rest = 0.0;              // in a row, up to now
        double pending_heat = 0.0;               // s, that heat has yet to go on by
        double first_limit = 0.0, unsafe_steps = 0.0; // s, Eq. (42) at the first step; fixed steps beyond the safe one
    };
    struct LawPoints {
        Law* law;
        std::vector<std::uint32_t> ids;
    };

    void build_schedule();
    void advance_heat();
    void check_step(double dt);
    void refuse_beyond(const HeatLimit& limit, double dt) const;
    void refuse_beyond(const StepLimit& limit, double dt);
    std::string at_this_step() const; // ", in step 5 at t = 0.1 s"; nothing before the first
    void check_numbers();
    [[noreturn]] void name_what_is_no_number();
    void note(Help help, double amount, std::optional<std::uint32_t> point = {});
    std::string hint_of_step() const;
    void begin_laws();
    LawAnswer answer_columns();
    void enter_stage();
    bool is_at_rest();
    void leave_stage_when_done();
    std::vector<std::uint32_t> points_of(const std::vector<std::string>& bodies) const;
    const StageSpec& present_stage() const;
    Vector gravity_at(double time) const;

    void constrain_grid();
    void submit_to_laws();
    void move_points();
    void collect_from_laws();
    double law_power() const;
    void book_step();

    Scene scene_;
    Laws laws_;
    Grid grid_;
    Points points_;
    std::vector<double> half_size_; // l_p by body, m
    Supports supports_;
    std::unique_ptr<HeatSolver> heat_;
    std::optional<CellMeans> cell_means_; // where the scene asks for them
    std::optional<PhaseChangeStrain> phase_change_strain_; // likewise
    std::vector<Wall> walls_;
    std::vector<LawPoints> law_points_;
    std::optional<PrescribedField> prescribed_;
    Schedule schedule_;
    Ledger ledger_;
    Clock clock_;
    std::vector<double> unrest_; // by stage: kinetic energy over internal work where it ended before rest; 0 = at rest, or not asked

    SelfHelp self_help_;
    bool safeguards_ = true;

    // Of the present step.
    double dt_ = 0.0;         // s
    Vector gravity_ = Vector::Zero(); // m/s^2, at the middle of the step
    double point_work_ = 0.0; // J
    double law_work_ = 0.0;   // J, of it what the laws were asked for; only with phase_change_strain_
    PointUpdateBooks point_books_;
};

} // namespace talik::driver
