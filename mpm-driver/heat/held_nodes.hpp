#pragma once
// Where heat enters from outside: nodes held at a temperature (sides of the material, heaters), and nodes that take the
// flux of a side. Sides are looked for anew whenever points have moved, so they follow the surface; the node nearest to
// the surface is held, and any that lie further out.
#include <string>
#include <vector>

#include "mpm-driver/app/heat_scene.hpp"
#include "mpm-driver/grid/grid.hpp"
#include "mpm-driver/heat/time_value.hpp"

namespace talik::driver {

class HeldNodes {
public:
    HeldNodes(const HeatSpec& spec, const Grid& grid);

    struct Held { int node; int entry; };                 // entry: index into names()
    struct Flux { int node; int entry; double area; };    // m^2

    // volume: of the material at each node, m^3; time: s, of the scene. moved: whether the material may have.
    void update(const Grid& grid, const std::vector<double>& volume, double time, bool moved);

    double next_switch(double time) const;  // s, of the scene: when a heater next goes on or off; infinite where none does
    bool switched_since(double time) const; // whether one is on or off at this time that the lists have otherwise

    const std::vector<Held>& held() const { return held_; }
    const std::vector<Flux>& fluxes() const { return fluxes_; }
    bool is_held(std::size_t node) const { return mark_[node] >= 0; }
    int entry_of(std::size_t held_node) const { return mark_[held_node]; }
    bool is_heater(int entry) const { return entry >= static_cast<int>(sides_.size()); }
    const std::vector<std::string>& names() const { return names_; }
    const TimeValue& value(int entry) const { return values_[static_cast<std::size_t>(entry)]; }
    // Least and most temperature that is ever held; empty range (least > most) where none is.
    double least() const { return least_; }
    double most() const { return most_; }
    // Heaters and sides without a node of the ground, by name: the first; empty = all have some.
    std::string idle_heater(const Grid& grid, const std::vector<double>& volume) const;
    std::string idle_side(const Grid& grid, const std::vector<double>& volume) const;

private:
    bool switched_on(const HeaterSpec& heater, double time) const;
    // Each node of a side: hold(node), or flux(node, share of a cell's width).
    template <class Hold, class Enter>
    void each_of_side(const Grid& grid, const std::vector<double>& volume, const HeatBoundarySpec& side, Hold&& hold, Enter&& enter) const;
    void hold_region(const Grid& grid, const std::vector<double>& volume, const HeaterSpec& heater, int entry);
    bool in_region(const Grid& grid, const HeaterSpec& heater, int node) const;

    std::vector<HeatBoundarySpec> sides_;
    std::vector<HeaterSpec> heaters_;
    std::vector<std::string> names_;
    std::vector<TimeValue> values_;
    std::vector<char> on_;      // heaters, as the lists below have them
    std::vector<int> mark_;     // entry that holds a node; -1 = free
    std::vector<Held> held_;
    std::vector<Flux> fluxes_;
    double least_ = 1e300, most_ = -1e300;
    bool fresh_ = false;
};

} // namespace talik::driver
