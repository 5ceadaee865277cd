#pragma once
// A rigid, flat wall along an axis, whose face may move and stand between node rows.
//
// On every line of nodes normal to it, the wall asks that the velocity interpolated at its face be its own,
//     (1-s) v_j + s v_{j+1} = V,
// s the face's fraction between the rows j (outside) and j+1 (inside). These weights are the linear hats at the face, and
// points that tile the body up to the face load the two rows in just this ratio, so a uniform stress is in equilibrium
// with the wall wherever it stands. The condition is imposed by the correction of least momentum (Gauss's principle):
// the multiplier is the wall's impulse, and a field linear in the normal direction that satisfies it is left alone.
// The velocity mapped from the points, v^n, is held to the condition too, where the wall held the material in the step
// before: lumped masses map the wall's rows to the mean velocity of the points around, which is not the wall's, and what
// the wall corrected of it each step would push the points as if it were a force. Such a correction is no impulse on the
// points, but for the PIC fraction, which takes up the mapped velocity.
//
// Rows further out carry little mass (points that overlap the face under compression); they are held on the same line
// through the face, so that linear fields stay untouched there too. Where row j+1 lies closer than half a cell beneath the
// face, row j+2 is on the line as well: the slope would otherwise be left to row j alone, which then gives way to the
// overlapping points until they have no stress, and the reaction would jump as the face passes the row.
// All this is one mass-weighted projection of the line's nodal velocities on {V + a d_k}, d_k the distances from the face.
#include <cmath>
#include <limits>
#include <vector>

#include "mpm-driver/app/scene.hpp"
#include "mpm-driver/boundary/wall_motion.hpp"
#include "mpm-driver/grid/grid.hpp"
#include "mpm-driver/points/state_column.hpp"

namespace talik::driver {

// What a wall did in one step. Work and dissipation are of the step.
struct WallReaction {
    Vector force = Vector::Zero(); // total force of the wall on the body, N, the part of the confining pressure included
    double contact_area = 0.0;     // m^2: mean cross-section of the material beneath the face
    Vector impulse = Vector::Zero(); // of the constraint alone (without the confining pressure), N s
    double work = 0.0;             // of the constraint at the wall's velocity, J
    double pic_work = 0.0;         // of it, what came through the PIC fraction, J
    double friction_dissipation = 0.0; // J
};

class Wall {
public:
    Wall(const WallSpec& spec, const Grid& grid);

    const std::string& name() const { return spec_.name; }
    const WallSpec& spec() const { return spec_; }
    double position() const { return motion_.position(); } // of the face, m
    double velocity() const { return std::isnan(velocity_) ? 0.0 : velocity_; }          // along its axis in the present step, m/s
    int axis() const { return axis_; }                     // of the normal
    const WallReaction& reaction() const { return reaction_; }

    void start_moving() { motion_.start(); }
    void stop() { motion_.stop(); }

    // The calls of one step, in this order (boundary/walls.hpp); those in the middle are repeated where walls meet.
    void start_step(const Grid& grid, double dt, double confining_pressure, double pic);
    void hold_mapped_normal(Grid& grid);
    void hold_mapped_tangential(Grid& grid);
    void remember_slip(const Grid& grid);
    void constrain_normal(Grid& grid);
    void constrain_tangential(Grid& grid);
    void finish_step(const Grid& grid);

    bool has_tangential() const { return spec_.kind == "fixed" || spec_.friction > 0.0; }
    bool shares_rows_with(const Wall& other) const; // of nodes: both would correct the same velocities
    std::vector<StateColumn> state();

private:
    // One line of nodes normal to the wall.
    struct Line {
        int first_node = 0;              // of the line's rows, at row 0 of the axis
        double normal_impulse = 0.0;     // on the body, along the inward normal, N s
        double tangential_impulse = 0.0; // on the body, along the wall, N s
        double held_work = 0.0, held_normal = 0.0, held_tangential = 0.0; // what holding the mapped velocity took, N s
        double face_speed_before = 0.0;  // tangential velocity of the grid at the face before the step, m/s
        double area = 0.0;               // of contact, m^2
    };
    // The rows of a line's projection, counted from row j: two further out, and inward to the first that lies half a
    // cell or more beneath the face.
    static constexpr double without_limit = 1e300; // N s; a number, since it travels as a column of the state
    static constexpr int rows_outside = 2;
    int innermost_row() const { return fraction_ <= 0.5 ? 1 : 2; }

    void locate_face(const Grid& grid);
    double held_speed(double face_speed) const;
    bool touches(const Line& line) const;
    double tangential_limit(const Line& line) const;
    void measure_line(const Grid& grid, Line& line) const;
    template <class Visit> void each_row(const Line& line, Visit&& visit) const;
    double face_speed(const std::vector<Vector>& velocity, const Grid& grid, const Line& line, int component) const;
    struct Projection { double impulse, slope; }; // what it takes, N s; the line's slope, m/s per cell
    Projection project(const Grid& grid, const std::vector<Vector>& velocity, const Line& line, int component, double target) const;
    void correct(std::vector<Vector>& velocity, const Line& line, int component, double target, double slope, double part) const;

    WallSpec spec_;
    WallMotion motion_;
    int axis_, tangent_;    // of the normal, and along the wall
    int inward_;            // +1 where the material lies on the side of larger coordinates
    int stride_, axis_nodes_; // from row to row, and rows, along the axis
    double velocity_ = std::numeric_limits<double>::quiet_NaN(); // of the present step; not a number before the first, m/s
    double held_velocity_ = 0.0;                                  // of the step before, m/s
    double dt_ = 0.0, pressure_ = 0.0, pic_ = 0.0;
    int outer_row_ = 0;     // row j
    double fraction_ = 0.0; // s in [0, 1): from row j towards the material
    std::vector<Line> lines_;
    std::vector<double> touching_, sticking_; // by line, as the last step left it: 0 or 1; the limit of its tangential impulse where it stuck, N s, else 0
    WallReaction reaction_;
};

} // namespace talik::driver
