#include "mpm-driver/points/self_help.hpp"

#include <algorithm>

namespace talik::driver {

const HelpKind& kind_of(Help help) {
    static const std::array<HelpKind, static_cast<std::size_t>(Help::count)> kinds = {{
        {"extra_sub_steps", "an RVE took more sub-steps than asked for, since the strain was large or its contacts had stiffened; amount: 1"},
        {"retaken_chunks", "an RVE took a chunk of sub-steps again, shorter or on a neighbour list made earlier; amount: chunks in a step"},
        {"lost_contacts", "an RVE that carried a force lost its last contact and answers zero; amount: 1"},
        {"smaller_step", "the limit of the mechanical step was below half of that at the start, and \"auto\" followed; amount: limit at the start over that now"},
        {"heat_sub_steps", "heat took sub-steps within a mechanical step; amount: how many"},
        {"shorter_heat_steps", "heat went on earlier than its limit, so that ice changes by heat.ice_step at most; amount: 1"},
        {"cut_enthalpy", "enthalpies of moving points were cut to the range of their nodes', and given back around; amount: J"},
    }};
    return kinds[static_cast<std::size_t>(help)];
}

void SelfHelp::note(Help help, const Moment& when, double amount, std::optional<std::uint32_t> point, const Vector& where) {
    Record& r = records_[static_cast<std::size_t>(help)];
    const double id = point ? static_cast<double>(*point) : -1.0, step = static_cast<double>(when.step);
    if (r.count == 0.0) r.first_time = when.time, r.first_step = step, r.first_point = id, r.first_x = where[0], r.first_y = where[1];
    r.last_time = when.time, r.last_step = step, r.last_point = id, r.last_x = where[0], r.last_y = where[1];
    r.count += 1.0;
    r.most = std::max(r.most, amount);
}

std::vector<StateColumn> SelfHelp::state() {
    std::vector<StateColumn> columns;
    for (std::size_t k = 0; k < records_.size(); ++k)
        columns.push_back({std::string("self_help/") + kind_of(static_cast<Help>(k)).name, "SI", kind_of(static_cast<Help>(k)).meaning,
                           {"count", "most", "first_time", "first_step", "first_point", "first_x", "first_y", "last_time", "last_step", "last_point", "last_x", "last_y"},
                           &records_[k].count, 1});
    return columns;
}

} // namespace talik::driver
