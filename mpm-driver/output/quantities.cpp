#include "mpm-driver/output/quantities.hpp"

#include <algorithm>
#include <cmath>

#include "mpm-driver/points/kinematics.hpp"

namespace talik::driver {
namespace {

struct Means {
    double volume = 0.0;
    Stress stress = Stress::Zero();
    Matrix strain = Matrix::Zero();
};

// Volume averages over all points.
Means mean_state(const Points& points) {
    Means means;
    for (std::size_t p = 0; p < points.count(); ++p) {
        means.volume += points.volume[p];
        means.stress += points.volume[p] * points.stress[p];
        means.strain += points.volume[p] * logarithmic_strain(points.deformation[p]);
    }
    means.stress /= means.volume;
    means.strain /= means.volume;
    return means;
}

template <class Value>
FieldColumn column(const Points& points, std::string name, std::string unit, int components, Value&& value) {
    FieldColumn out{std::move(name), std::move(unit), components, {}};
    out.data.reserve(points.count() * static_cast<std::size_t>(components));
    for (std::size_t p = 0; p < points.count(); ++p) value(p, out.data);
    return out;
}

} // namespace

// Of a scene with heat: extremes, water and ice, what has entered by cause, how well it closes.
static void add_heat(const Simulation& simulation, std::vector<HistoryValue>& out) {
    const HeatSolver& heat = *simulation.heat();
    const Points& points = simulation.points();
    const auto [coldest, warmest] = heat.extremes();
    out.insert(out.end(), {{"temperature_min_C", coldest}, {"temperature_max_C", warmest}, {"water_m3", heat.water_volume(points)},
                           {"ice_m3", heat.ice_volume(points)}, {"heat_J", heat.content(points)}, {"heat_entered_J", heat.books().entered()}});
    for (std::size_t i = 0; i < heat.entries().size(); ++i) out.push_back({heat.entries()[i] + "_heat_J", heat.books().heat(i)});
    out.insert(out.end(), {{"temperature_overshoot_K", heat.books().overshoot()}, {"balance_heat", heat.balance_error(points)}});
}

std::vector<HistoryValue> history_values(const Simulation& simulation) {
    if (!simulation.mechanics()) {
        std::vector<HistoryValue> out = {{"stage", static_cast<double>(simulation.stage())}};
        add_heat(simulation, out);
        return out;
    }
    const Points& points = simulation.points();
    const Ledger& ledger = simulation.ledger();
    const Means means = mean_state(points);
    double fastest = 0.0;
    for (const Vector& v : points.velocity) fastest = std::max(fastest, v.norm());

    std::vector<HistoryValue> out = {{"stage", static_cast<double>(simulation.stage())}};
    const double known = simulation.steps_done() > 0 ? 1.0 : std::nan(""); // walls push from the first step on
    for (const Wall& wall : simulation.walls()) {
        out.push_back({wall.name() + "_position_m", wall.position()});
        out.push_back({wall.name() + "_force_x_N", known * wall.reaction().force.x()});
        out.push_back({wall.name() + "_force_y_N", known * wall.reaction().force.y()});
        out.push_back({wall.name() + "_contact_area_m2", known * wall.reaction().contact_area});
    }
    const std::vector<HistoryValue> rest = {
        {"volume_m3", means.volume},
        {"mean_stress_xx_Pa", means.stress[0]},
        {"mean_stress_yy_Pa", means.stress[1]},
        {"mean_stress_xy_Pa", means.stress[2]},
        {"mean_strain_xx", means.strain(0, 0)},
        {"mean_strain_yy", means.strain(1, 1)},
        {"mean_strain_xy", means.strain(0, 1)},
        {"largest_speed_m_per_s", fastest},
        {"energy_kinetic_J", ledger.kinetic},
        {"energy_work_of_walls_J", ledger.wall_work},
        {"energy_work_of_pressure_J", ledger.pressure_work},
        {"energy_work_of_gravity_J", ledger.gravity_work},
        {"energy_internal_work_J", ledger.internal_work},
        {"energy_stored_J", ledger.law_stored},
        {"energy_dissipated_in_material_J", ledger.law_dissipation},
        {"energy_wall_friction_J", ledger.wall_friction},
        {"energy_wall_impact_J", ledger.wall_impact},
        {"energy_transfer_J", ledger.transfer},
        {"energy_strain_transfer_J", ledger.strain_transfer},
        {"energy_pic_J", ledger.pic},
        {"energy_grid_damping_J", ledger.grid_damping},
        {"energy_particle_damping_J", ledger.particle_damping},
        {"balance_mass", ledger.mass_error()},
        {"balance_momentum", ledger.momentum_error()},
        {"balance_energy", ledger.energy_error()},
        {"numerical_loss", ledger.numerical_loss()},
    };
    out.insert(out.end(), rest.begin(), rest.end());
    if (simulation.scene().phase_change_strain) out.push_back({"energy_phase_change_J", ledger.phase_change});
    if (simulation.heat()) add_heat(simulation, out);
    return out;
}

std::vector<FieldColumn> field_columns(const Simulation& simulation) {
    const Points& points = simulation.points();
    using Data = std::vector<double>;
    std::vector<FieldColumn> out;
    out.push_back(column(points, "position", "m", 2, [&](std::size_t p, Data& d) { d.insert(d.end(), {points.position[p].x(), points.position[p].y()}); }));
    if (simulation.mechanics()) {
        out.push_back(column(points, "displacement", "m", 3, [&](std::size_t p, Data& d) { const Vector u = points.displacement(p); d.insert(d.end(), {u.x(), u.y(), 0.0}); }));
        out.push_back(column(points, "velocity", "m/s", 3, [&](std::size_t p, Data& d) { d.insert(d.end(), {points.velocity[p].x(), points.velocity[p].y(), 0.0}); }));
        out.push_back(column(points, "stress", "Pa, xx yy xy, tension positive", 3, [&](std::size_t p, Data& d) { const Stress& s = points.stress[p]; d.insert(d.end(), {s[0], s[1], s[2]}); }));
        out.push_back(column(points, "strain", "-, logarithmic, xx yy xy, tension positive", 3, [&](std::size_t p, Data& d) { const Matrix e = logarithmic_strain(points.deformation[p]); d.insert(d.end(), {e(0, 0), e(1, 1), e(0, 1)}); }));
        out.push_back(column(points, "deformation_gradient", "-, xx xy yx yy", 4, [&](std::size_t p, Data& d) { const Matrix& f = points.deformation[p]; d.insert(d.end(), {f(0, 0), f(0, 1), f(1, 0), f(1, 1)}); }));
        out.push_back(column(points, "equivalent_strain", "-", 1, [&](std::size_t p, Data& d) { d.push_back(equivalent_strain(points.deformation[p])); }));
    }
    out.push_back(column(points, "volume", "m3", 1, [&](std::size_t p, Data& d) { d.push_back(points.volume[p]); }));
    out.push_back(column(points, "density", "kg/m3", 1, [&](std::size_t p, Data& d) { d.push_back(points.density(p)); }));
    out.push_back(column(points, "body", "-", 1, [&](std::size_t p, Data& d) { d.push_back(points.body[p]); }));
    if (simulation.heat()) {
        const auto scalar = [&](const char* name, const char* unit, const std::vector<double>& values) { out.push_back({name, unit, 1, values}); };
        scalar("temperature", "C", points.temperature);
        scalar("ice_saturation", "-", points.ice_saturation);
        scalar("ice_fraction", "-, of the volume", points.ice_fraction);
    }
    for (const auto& [name, law] : simulation.laws())
        for (const StateColumn& c : law->columns())
            out.push_back({c.name, c.unit, static_cast<int>(c.components.size()), {c.data, c.data + c.size()}});
    return out;
}

} // namespace talik::driver
