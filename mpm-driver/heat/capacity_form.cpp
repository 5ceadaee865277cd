// The paper's form: temperatures on the points, equivalent heat capacity (A2), remapped temperature (36), (37). Kept so that
// its cost can be shown; a step that jumps over the freezing interval loses or makes latent heat.
#include "mpm-driver/grid/parallel.hpp"
#include "mpm-driver/heat/heat_solver.hpp"

namespace talik::driver {

void HeatSolver::temperatures_to_nodes(const Supports& supports, const Points& points) {
    each(nodes_, [&](std::size_t node) {
        double capacity = 0.0, heat = 0.0; // C_I = sum phi_Ip V_p C(T_p), Eq. (26), J/K; T_I = sum phi_Ip V_p C T_p / C_I, Eq. (18)
        supports.each_point_of(node, [&](std::uint32_t p, double phi, const Vector&) {
            const double part = phi * points.initial_volume[p] * material_of(points, p).capacity_at(remapped_[p]);
            capacity += part;
            heat += part * points.temperature[p];
        });
        enthalpy_[node] = capacity;
        state_[node] = {capacity > 0.0 ? heat / capacity : 0.0, 0.0};
    });
}

void HeatSolver::temperatures_from_nodes(const Supports& supports, Points& points, double dt) {
    each(points.count(), [&](std::size_t p) {
        double rise = 0.0, remapped = 0.0;
        supports.each_node_of(p, [&](std::size_t node, double phi, const Vector&) {
            rise += phi * dt * rate_[node];                                    // K
            remapped += phi * (state_[node].temperature + dt * rate_[node]);
        });
        points.temperature[p] += rise; // Eq. (36)
        remapped_[p] = remapped;       // Eq. (37): for capacity and ice, never the state
        points.enthalpy[p] = points.initial_volume[p] * material_of(points, p).enthalpy({points.temperature[p], 0.0}); // J, to see what is lost
    });
}

} // namespace talik::driver
