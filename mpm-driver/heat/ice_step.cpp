// How long a step of heat may be where bonds wait for its ice: RVEs see the ice of their points leap once per step of heat,
// so what those leaps may be is limited (heat.ice_step). It is foreseen from the rates of the step before.
#include <algorithm>
#include <cmath>

#include "mpm-driver/heat/heat_solver.hpp"

namespace talik::driver {

// Of the step just taken: the most that the ice saturation of a free node can change by per second is what the node
// receives, were it all latent, |dH_I/dt| / (L rho_s theta_s): an upper bound on both sides of the freezing interval, so a
// front that arrives within the next step is foreseen too. A point's ice is a mean of its nodes' and changes by no more.
// Not known once a heater was switched: the next step is then as short as it can be.
void HeatSolver::note_ice_rate(const Points& points) {
    if (!points.mechanical) return;
    clock_.ice_rate = std::numeric_limits<double>::infinity();
    if (held_.switched_since(clock_.time)) return;
    double fastest = 0.0; // 1/s
    for (std::size_t node = 0; node < nodes_; ++node) {
        if (!(volume_[node] > 0.0) || held_.is_held(node)) continue;
        double latent = 0.0; // J/m^3
        for (std::size_t m = 0; m < materials_.size(); ++m) latent += share_[at(m, node)] * materials_[m].latent();
        const double rate = enthalpy_form_ ? rate_[node] : rate_[node] * enthalpy_[node] / volume_[node]; // W/m^3
        if (latent > 0.0) fastest = std::max(fastest, std::abs(rate) / latent);
    }
    clock_.ice_rate = fastest;
}

double HeatSolver::interval_of_ice() const {
    return clock_.ice_rate > 0.0 ? spec_.ice_step / clock_.ice_rate : std::numeric_limits<double>::infinity();
}

} // namespace talik::driver
