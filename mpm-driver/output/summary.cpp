#include "mpm-driver/output/summary.hpp"

#include <fmt/format.h>

#include <algorithm>

#include <nlohmann/json.hpp>

#include "common/base/progress.hpp"
#include "common/base/version.hpp"
#include "common/io/text_file.hpp"

namespace talik::driver {
namespace {

using Json = nlohmann::ordered_json;

bool any_stage(const Scene& scene, auto&& holds) {
    for (const StageSpec& stage : scene.stages)
        if (holds(stage)) return true;
    return false;
}

// Temperatures may rightly leave the range of the initial and held ones.
bool scene_has_power(const HeatSpec& heat) {
    return !heat.sources.empty() || std::any_of(heat.boundaries.begin(), heat.boundaries.end(), [](const HeatBoundarySpec& b) { return b.kind == "flux"; });
}

Json self_help(const SelfHelp& help) {
    Json json;
    for (std::size_t k = 0; k < static_cast<std::size_t>(Help::count); ++k) {
        const HelpKind& kind = kind_of(static_cast<Help>(k));
        const SelfHelp::Record& r = help.record(static_cast<Help>(k));
        Json row = {{"count", static_cast<std::int64_t>(r.count)}, {"meaning", kind.meaning}};
        const auto moment = [](double time, double step, double point, double x, double y) {
            Json m = {{"time_s", time}, {"step", static_cast<std::int64_t>(step)}};
            if (point >= 0.0) m["point"] = static_cast<std::int64_t>(point), m["position_m"] = {x, y};
            return m;
        };
        if (r.count > 0.0) {
            row["first"] = moment(r.first_time, r.first_step, r.first_point, r.first_x, r.first_y);
            row["last"] = moment(r.last_time, r.last_step, r.last_point, r.last_x, r.last_y);
            row["largest_amount"] = r.most;
        }
        json[kind.name] = row;
    }
    return json;
}

} // namespace

Effects effects_of(const Scene& scene) {
    Effects effects;
    const auto say = [&](const std::string& name, bool on, const std::string& why_on, const std::string& why_off) {
        (on ? effects.on : effects.off).push_back(name + ": " + (on ? why_on : why_off));
    };
    bool wall_friction = false;
    for (const WallSpec& wall : scene.walls) wall_friction |= wall.friction > 0.0;
    say("mechanics", scene.mechanics(), "bodies have a law", "no body has a law: heat alone, at rest");
    say("RVEs", scene.rve.has_value(), "[rve] is in the scene", "no [rve] in the scene: no farm is started");
    say("elastic law", scene.elastic.has_value(), "[elastic] is in the scene", "no [elastic] in the scene");
    say("bonds", scene.rve && scene.rve->parameters.bond, "[rve.bond] is in the scene", "no [rve.bond] in the scene");
    say("local damping of discs", scene.rve && scene.rve->parameters.damping > 0.0, "rve.damping > 0", "rve.damping is 0, or no RVEs");
    say("fluctuation stress", scene.rve && scene.rve->parameters.fluctuation_stress, "rve.fluctuation_stress is true", "rve.fluctuation_stress is false");
    say("confining pressure", scene.confining_pressure != 0.0, "confining_pressure is set", "confining_pressure is 0");
    say("volume strain by cells", scene.domain.volume_strain == "cell", "domain.volume_strain is \"cell\"", "domain.volume_strain is \"point\"");
    say("gravity", any_stage(scene, [](const StageSpec& s) { return s.gravity.squaredNorm() > 0.0; }), "a stage sets it", "no stage sets it");
    say("moving walls", any_stage(scene, [](const StageSpec& s) { return !s.moves.empty(); }), "a stage moves one", "no stage moves one");
    say("wall friction", wall_friction, "a wall has friction", "no wall has friction");
    say("damping of points and grid", any_stage(scene, [](const StageSpec& s) { return s.particle_damping > 0.0 || s.grid_damping > 0.0; }), "a stage sets it", "no stage sets it");
    const bool freezes = scene.heat && std::any_of(scene.heat->materials.begin(), scene.heat->materials.end(), [](const ThermalMaterialSpec& m) { return m.curve != "none"; });
    say("heat", scene.heat.has_value(), scene.heat ? fmt::format("[heat] is in the scene ({} form)", scene.heat->formulation) : "", "no [heat] in the scene");
    say("phase change", freezes, "a material has a freezing curve", "no material has a freezing curve");
    say("strain of phase change", scene.phase_change_strain.has_value(), "[phase_change_strain] is in the scene", "no [phase_change_strain] in the scene");
    say("heat runs on a clock of its own", scene.heat && scene.heat->time_scale != 1.0, scene.heat ? fmt::format("heat.time_scale is {:g}", scene.heat->time_scale) : "", "heat.time_scale is 1, or no heat");
    return effects;
}

std::string bottleneck(const RunFacts& facts) {
    if (!facts.farm_times) return {};
    const bool farm = facts.farm_times->waiting < facts.driver_times.waiting;
    const exchange::LockstepTimes& busy = farm ? *facts.farm_times : facts.driver_times;
    return std::string(farm ? "farm: " : "driver: ") + (busy.computing >= busy.copying ? "computing" : "copying");
}

void write_summary(const std::filesystem::path& path, const Simulation& simulation, const RunFacts& facts) {
    const Scene& scene = simulation.scene();
    const Ledger& ledger = simulation.ledger();
    const Effects effects = effects_of(scene);
    Json json;
    json["title"] = scene.title;
    json["scene"] = scene.file;
    json["scene_hash"] = scene.hash;
    json["version"] = version();
    json["build"] = build_facts("mpm-driver");
    json["farm"] = facts.farm;
    json["seed"] = scene.seed;
    json["effects"] = {{"on", effects.on}, {"off", effects.off}};
    json["schedule"] = simulation.schedule().table_of_contents();
    json["steps"] = simulation.steps_done();
    json["time_end"] = simulation.time();
    json["points"] = simulation.points().count();
    json["rves"] = facts.rves;
    for (const PackingFact& packing : facts.packings) {
        Json row = {{"seed", packing.seed}, {"void_ratio", packing.void_ratio}};
        if (packing.vertical_stress > 0.0) {
            row["vertical_stress_Pa"] = packing.vertical_stress;
            row["K0"] = packing.lateral_stress / packing.vertical_stress;
        } else {
            row["pressure_Pa"] = packing.pressure;
        }
        json["packings"].push_back(row);
    }
    json["rve_evaluations"] = {{"asked", facts.evaluations_asked}, {"done", facts.evaluations_done}, {"avoided", Json::object()}};
    json["rve_split_steps"] = facts.split_steps;
    json["self_help"] = self_help(simulation.self_help());
    json["dem_time_step_s"] = facts.dem_time_step;
    json["mean_time_step_s"] = simulation.steps_done() > 0 ? simulation.time() / static_cast<double>(simulation.steps_done()) : 0.0;
    // Time that the RVEs lived through over that of the driver: 1, since sub-steps add up to their macro step.
    json["clock_ratio"] = facts.rves > 0 && simulation.time() > 0.0 ? facts.dem_time / simulation.time() : 1.0;
    json["rves_without_contacts"] = facts.rves_without_contacts;
    json["confining_pressure_Pa"] = scene.confining_pressure;
    for (const Wall& wall : simulation.walls()) json["walls"].push_back({{"name", wall.name()}, {"side", wall.spec().side}});
    json["wall_seconds"]["total"] = facts.wall_seconds;
    for (const auto& [stage, seconds] : facts.stage_seconds) json["wall_seconds"][stage] = seconds;
    json["cpu_seconds"] = facts.cpu_seconds;
    if (facts.farms > 0) json["farms"] = {{"count", facts.farms}, {"replaced", facts.farms_replaced}, {"seconds_lost", facts.seconds_lost}, {"times_rves_moved", facts.rves_moved}};
    json["waiting_seconds"] = {{"driver", facts.waiting_driver}, {"farm", facts.waiting_farm ? Json(*facts.waiting_farm) : Json()}};
    const auto times = [](const exchange::LockstepTimes& t) { return Json{{"computing", t.computing}, {"copying", t.copying}, {"waiting", t.waiting}}; };
    if (!facts.farm.empty()) {
        json["lockstep_seconds"] = {{"driver", times(facts.driver_times)}, {"farm", facts.farm_times ? times(*facts.farm_times) : Json()}};
        json["bottleneck"] = bottleneck(facts);
    }
    if (facts.recording_seconds) json["recording_seconds"] = {{"driver", *facts.recording_seconds}, {"compression_cpu", facts.recording_packing_seconds}};
    json["balance"] = {{"mass", ledger.mass_error()}, {"momentum", ledger.momentum_error()}, {"energy", ledger.energy_error()}, {"heat", simulation.heat() ? Json(simulation.heat()->balance_error(simulation.points())) : Json()}, {"numerical_loss", ledger.numerical_loss()}};
    json["energy_J"] = {{"input", ledger.input_work()}, {"work_of_walls", ledger.wall_work}, {"work_of_pressure", ledger.pressure_work}, {"work_of_gravity", ledger.gravity_work}, {"kinetic", ledger.kinetic}, {"internal_work", ledger.internal_work},
                        {"stored", ledger.law_stored}, {"dissipated_in_material", ledger.law_dissipation}, {"pic", ledger.pic},
                        {"transfer", ledger.transfer}, {"strain_transfer", ledger.strain_transfer}, {"wall_impact", ledger.wall_impact}, {"grid_damping", ledger.grid_damping},
                        {"particle_damping", ledger.particle_damping}, {"wall_friction", ledger.wall_friction}};
    if (scene.phase_change_strain) json["energy_J"]["phase_change"] = ledger.phase_change;
    if (const HeatSolver* heat = simulation.heat()) {
        const Points& points = simulation.points();
        const HeatLimit limit = heat->limit(simulation.grid(), points);
        Json by_cause;
        for (std::size_t i = 0; i < heat->entries().size(); ++i) by_cause[heat->entries()[i]] = heat->books().heat(i);
        json["heat"] = {{"formulation", scene.heat->formulation}, {"steps", heat->steps()}, {"time_scale", scene.heat->time_scale},
                        {"largest_step_s", limit.step}, {"automatic_step_s", limit.automatic}, {"content_J", heat->content(points)}, {"entered_J", heat->books().entered()},
                        {"entered_by_cause_J", by_cause}, {"temperature_overshoot_K", heat->books().overshoot()},
                        {"temperature_overshoot_of_span", heat->span() > 0.0 && !scene_has_power(*scene.heat) ? Json(heat->books().overshoot() / heat->span()) : Json(nullptr)}};
    }
    json["warnings"] = facts.warnings;
    json["exit"] = facts.exit;
    if (!facts.cause.empty()) json["cause"] = facts.cause;
    write_file_atomically(path, json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

std::string summary_table(const Simulation& simulation, const RunFacts& facts) {
    const Ledger& ledger = simulation.ledger();
    std::string text;
    const auto row = [&](const std::string& name, const std::string& value) { text += fmt::format("  {:<28}{}\n", name, value); };
    row("simulated", fmt::format("{:.6g} s in {} steps", simulation.time(), simulation.steps_done()));
    row("points, RVEs", fmt::format("{}, {}", simulation.points().count(), facts.rves));
    if (facts.rves > 0) row("RVE evaluations", fmt::format("{} ({} with extra sub-steps)", facts.evaluations_done, facts.split_steps));
    row("wall time", fmt::format("{} ({:.1f} s)", readable_duration(facts.wall_seconds), facts.wall_seconds));
    if (facts.rves > 0) row("waiting", fmt::format("driver {:.1f} s, farm {}", facts.waiting_driver, facts.waiting_farm ? fmt::format("{:.1f} s", *facts.waiting_farm) : "unknown"));
    if (const std::string which = bottleneck(facts); !which.empty()) row("bottleneck", which);
    if (const HeatSolver* heat = simulation.heat()) {
        row("heat", fmt::format("{:.4g} J entered in {:.0f} steps, balance error {:.1e}; temperatures out of range by at most {:.2g} K{}",
                                heat->books().entered(), heat->steps(), heat->balance_error(simulation.points()), heat->books().overshoot(),
                                scene_has_power(*simulation.scene().heat) ? ", which sources and fluxes may cause"
                                : heat->span() > 0.0                      ? fmt::format(" ({:.2g} % of the span)", 100.0 * heat->books().overshoot() / heat->span())
                                                                          : ""));
    }
    if (simulation.mechanics()) row("balance errors", fmt::format("mass {:.1e}, momentum {:.1e}, energy {:.1e}; numerical loss {:.1e} of the input work", ledger.mass_error(), ledger.momentum_error(), ledger.energy_error(), ledger.numerical_loss()));
    std::string helped;
    for (std::size_t k = 0; k < static_cast<std::size_t>(Help::count); ++k)
        if (const double count = simulation.self_help().record(static_cast<Help>(k)).count; count > 0.0) helped += fmt::format("{}{} {:.0f}", helped.empty() ? "" : ", ", kind_of(static_cast<Help>(k)).name, count);
    if (!helped.empty()) row("helped itself", helped + " (summary.json: self_help)");
    for (const auto& warning : facts.warnings) row("warning", warning);
    return text;
}

} // namespace talik::driver
