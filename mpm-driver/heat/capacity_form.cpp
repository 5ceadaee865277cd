// The paper's form: temperatures on the points, equivalent heat capacity (A2) at the nodes' old temperature, increments to the
// points by Eq. (36), the remapped temperature of Eq. (37) for ice and output only. Kept so that its cost can be shown: a
// step that jumps over the freezing interval loses or makes latent heat.
#include "mpm-driver/grid/parallel.hpp"
#include "mpm-driver/heat/heat_solver.hpp"

namespace talik::driver {

void HeatSolver::temperatures_to_nodes(const Supports& supports, const Points& points) {
    each(nodes_, [&](std::size_t node) {
        double sum = 0.0; // T_I = sum phi_Ip V_p T_p / W_I, Eq. (18), degrees C
        supports.each_point_of(node, [&](std::uint32_t p, double phi, const Vector&) { sum += phi * points.initial_volume[p] * points.temperature[p]; });
        state_[node] = {volume_[node] > 0.0 ? sum / volume_[node] : 0.0, 0.0};
    });
}

// C_I = W_I C(T_I), Eqs. (26), (A2), J/K: in the place of the nodes' enthalpy.
void HeatSolver::nodal_capacities() {
    each(nodes_, [&](std::size_t node) {
        double capacity = 0.0;
        for (std::size_t m = 0; m < materials_.size(); ++m)
            if (share_[at(m, node)] > 0.0) capacity += volume_[node] * share_[at(m, node)] * materials_[m].capacity_at(state_[node].temperature);
        enthalpy_[node] = capacity;
    });
}

void HeatSolver::advance_temperatures(double dt) {
    each(nodes_, [&](std::size_t node) {
        const double rise = dt * rate_[node]; // K, Eq. (29)
        state_[node].temperature += rise;
        change_[node] += rise;
    });
}

void HeatSolver::temperatures_from_nodes(const Supports& supports, Points& points) {
    each(points.count(), [&](std::size_t p) {
        const std::size_t m = material_of_body_[static_cast<std::size_t>(points.body[p])];
        double rise = 0.0, heat = 0.0;
        supports.each_node_of(p, [&](std::size_t node, double phi, const Vector&) {
            if (!(phi > 0.0)) return;
            rise += phi * change_[node];                   // K
            heat += phi * material_enthalpy_[at(m, node)]; // J/m^3
        });
        points.temperature[p] += rise;                        // Eq. (36)
        points.enthalpy[p] = points.initial_volume[p] * heat; // J: what the nodes' temperatures mean, to see what is lost
    });
}

} // namespace talik::driver
