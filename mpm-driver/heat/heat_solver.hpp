#pragma once
// Heat with phase change on the grid, points and shapes of the mechanics. Eqs. (1)-(4), (9), (10), (16)-(21), (26), (27), (29).
//
// Enthalpy form (default). Points carry joules. A step:
//   nodes from points    H_I = sum phi_Ip E_p / W_I,  W_I = sum phi_Ip V_p^0;  temperature and ice by exact inversion of H_I
//   heat flow            q_p = -A grad Theta, Theta the integral of the conductivity over temperature
//   nodal power          Q_I = sum V_p grad phi_Ip . q_p + sources + fluxes
//   nodes                H_I += dt Q_I / W_I
//   points from nodes    E_p += V_p^0 sum phi_Ip (change of H_I): what nodes receive, points receive, to rounding
// In a scene of heat alone, and within the sub-steps of a mechanical step, nodes keep their H_I. Mapped from the points in every
// step it is smeared over the neighbours: a front between warm and cold ground then lags by a part of a cell.
// Held nodes have their temperature for the gradient; the rate of their enthalpy is their free neighbours', within what the held
// temperature and these allow, and the difference to Q_I is the heat of the wall, which is booked.
//
// Capacity form (the paper's). Points carry temperature; the nodes' capacity is C(T) = rho c + latent, Eq. (A2), at their
// old temperature. The remapped temperature of Eq. (37) is output, never the state.
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mpm-driver/app/scene.hpp"
#include "mpm-driver/grid/grid.hpp"
#include "mpm-driver/heat/heat_books.hpp"
#include "mpm-driver/heat/held_nodes.hpp"
#include "mpm-driver/heat/thermal_material.hpp"
#include "mpm-driver/mechanics/supports.hpp"
#include "mpm-driver/points/points.hpp"

namespace talik::driver {

// The largest stable step, Eq. (43): dt <= C h^2 / (b k), C the sensible capacity, k the largest conductivity.
struct HeatLimit {
    double step = 0.0;      // s, at b = 2: a larger one is refused
    double automatic = 0.0; // s, at the scene's b
    double capacity = 0.0, conductivity = 0.0; // that set it, J/(m^3 K), W/(m K)
    double ramp_step = 0.0; // s, of the capacity form: beyond it a step jumps over the freezing interval; 0 = none
};

// Materials that may meet at a node.
constexpr std::size_t most_materials = 8;

class HeatSolver {
public:
    // Gives the points their first enthalpy. The supports must be up to date.
    HeatSolver(const Scene& scene, const Grid& grid, const Supports& supports, const std::vector<double>& half_size, Points& points);

    // On by dt, in equal sub-steps. moved: points may have moved since the last call.
    void advance(const Grid& grid, const Supports& supports, Points& points, double dt, int substeps, bool moved);
    void restored(const Grid& grid, const Supports& supports, Points& points); // after state() was filled, of points at rest

    HeatLimit limit(const Grid& grid, const Points& points) const;
    double enthalpy_cut() const { return cut_; }        // J, of moving points by their neighbours' range, in the last advance()
    double interval_of_ice() const;                     // s, within which no point's ice changes by more than heat.ice_step
    double next_switch() const { return held_.next_switch(clock_.time); } // s, of the scene
    std::string describe(const HeatLimit& limit, const Grid& grid) const;

    double time() const { return clock_.time; }         // s, of the scene
    double steps() const { return clock_.steps; }       // sub-steps taken
    const std::vector<ThermalMaterial>& materials() const { return materials_; }
    const ThermalMaterial& material_of(const Points& points, std::size_t p) const { return materials_[material_of_body_[static_cast<std::size_t>(points.body[p])]]; }
    const HeatBooks& books() const { return books_; }
    const std::vector<std::string>& entries() const { return entries_; } // names of the books' entries

    double content(const Points& points) const;          // J, sum of the points' enthalpy
    double balance_error(const Points& points) const;    // relative to the heat held at the start and moved since
    std::pair<double, double> extremes() const { return {clock_.coldest, clock_.warmest}; } // of the nodes, held ones included, degrees C
    double water_volume(const Points& points) const;     // m^3
    double ice_volume(const Points& points) const;       // m^3
    double span() const { return highest_ - lowest_; }   // K, of initial and held temperatures
    std::vector<std::string> warnings() const;

    // Starts anew from these temperatures of the points.
    void set_temperature(const Grid& grid, const Supports& supports, Points& points, const std::vector<double>& temperature);

    std::vector<StateColumn> state();

private:
    struct Source {
        TimeValue value;
        std::vector<double> factor; // by point: 0 where it does not act
    };
    void show(const Grid& grid, const Supports& supports, Points& points);
    void nodes_from_points(const Supports& supports, const Points& points);
    void moved_nodes_from_points(const Supports& supports, Points& points);
    void invert_nodes();
    void invert_node(std::size_t node);
    void hold_temperatures(double begin, double end);
    void heat_flow(const Supports& supports, const Points& points);
    void source_power(const Points& points, double begin, double end);
    void nodal_power(const Supports& supports, double begin, double end);
    void rates(const Grid& grid, double dt);
    void advance_nodes(double dt);
    void points_from_nodes(const Supports& supports, Points& points);
    bool limit_to_neighbours(const Supports& supports, Points& points); // whether anything was cut
    [[noreturn]] void name_what_is_no_number(Points& points) const;
    void watch_range(Points& points);
    void note_extremes();
    void note_ice_rate(const Points& points);
    double rate_of_neighbours(int node, int right, int up, double dt, bool held) const; // NaN where there is none
    double value_of(std::size_t node) const;
    double held_value(std::size_t node) const;
    double value_in_state_of(std::size_t other, double dt, std::size_t node) const;
    double enthalpy_in(std::size_t node, const ThermalState& state) const; // J/m^3
    ThermalState state_at(std::size_t node, double enthalpy) const;
    void refuse_what_is_idle(const Grid& grid, const Points& points) const;
    void refuse_unphysical() const;
    void find_small_nodes(const Grid& grid);
    void substep(const Grid& grid, const Supports& supports, Points& points, double dt);

    // The paper's form, in capacity_form.cpp.
    void temperatures_to_nodes(const Supports& supports, const Points& points);
    void nodal_capacities();
    void advance_temperatures(double dt);
    void temperatures_from_nodes(const Supports& supports, Points& points);

    std::size_t at(std::size_t material, std::size_t node) const { return material * nodes_ + node; }

    HeatSpec spec_;
    bool enthalpy_form_;
    std::vector<ThermalMaterial> materials_;
    std::vector<std::size_t> material_of_body_;
    std::vector<double> frozen_at_start_;      // by body: the share of a sharp front that is frozen, where it starts at T0
    HeldNodes held_;
    std::vector<Source> sources_;
    std::vector<std::string> entries_;
    HeatBooks books_;
    struct Clock {
        double time = 0.0, steps = 0.0;
        double ice_rate = std::numeric_limits<double>::infinity(); // 1/s, at most, by the last step; infinite = not known yet
        double coldest = 0.0, warmest = 0.0;                       // of the nodes after the last step, degrees C
    } clock_;
    double lowest_ = 1e300, highest_ = -1e300; // of initial and held temperatures, degrees C
    double scene_duration_ = 0.0;              // s, of all its stages
    double point_size_factor_ = 1.0;           // of the automatic step: min(1, 4 l_p / h)
    double content_scale_ = 0.0;               // sum of |E_p| at the start, J: the balance is relative to it and what has moved

    double expansion_;                         // of freezing water, where the scene has that effect, -

    // Nodes. Columns by material: `material * nodes + node`.
    std::size_t nodes_;
    std::vector<double> volume_;                 // W_I, m^3
    std::vector<double> share_;                  // of a material in W_I, -
    std::vector<double> enthalpy_;               // H_I, J/m^3 (capacity form: C_I, J/K)
    std::vector<ThermalState> state_;            // by inversion
    std::vector<double> temperature_;            // for the gradient, degrees C
    std::vector<double> material_enthalpy_, potential_, frozen_; // by material: J/m^3, W/m, -
    std::vector<double> power_;                  // Q_I, W
    std::vector<double> rate_;                   // of H_I, W/m^3 (capacity form: of T_I, K/s)
    std::vector<double> change_;                 // of H by material since the points were last brought up to date, J/m^3
    // Points.
    std::vector<Vector> flow_;                   // V_p q_p, W m
    std::vector<double> source_;                 // V_p s_p, W
    std::vector<double> excess_;                 // J, cut off by the neighbours' range
    std::vector<std::pair<HeldNodes::Held, double>> later_; // held nodes of a second row, and their rate
    std::vector<std::pair<std::size_t, std::size_t>> small_; // nodes that the ground barely reaches, and the neighbour they go with
    std::vector<double> merged_;                 // weight of the small nodes that go with a node
    bool small_nodes_changed_ = true;
    double cut_ = 0.0; // J
};

} // namespace talik::driver
