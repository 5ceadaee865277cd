#include "mpm-driver/app/explain.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <cmath>

#include "common/physics/clock.hpp"
#include "mpm-driver/app/laws.hpp"
#include "mpm-driver/app/packings.hpp"
#include "mpm-driver/app/scene_schema.hpp"
#include "mpm-driver/app/scene_tables.hpp"
#include "mpm-driver/constitutive/elastic.hpp"
#include "mpm-driver/heat/heat_solver.hpp"
#include "mpm-driver/mechanics/step_limit.hpp"
#include "mpm-driver/output/summary.hpp"
#include "mpm-driver/points/overburden.hpp"
#include "mpm-driver/points/seed.hpp"

namespace talik::driver {
namespace {

void row(const std::string& name, const std::string& value) { fmt::print("  {:<26}{}\n", name, value); }

std::string bytes_text(double bytes) {
    if (bytes >= 1e9) return fmt::format("{:.1f} GB", bytes / 1e9);
    return fmt::format("{:.1f} MB", bytes / 1e6);
}

// What the packings say of the RVEs made from them.
struct RveFacts {
    std::int64_t rves = 0;
    double discs = 0.0, contacts = 0.0;                 // per RVE, mean
    double stiffness = 0.0, stable_step = 0.0;          // largest P-wave modulus, Pa; least 2/omega_max, s
};

RveFacts rve_facts(const std::vector<Packing>& packings, std::int64_t rves) {
    RveFacts facts;
    facts.rves = rves;
    facts.stable_step = packings.empty() ? 0.0 : packings.front().stable_step;
    for (const Packing& packing : packings) {
        facts.discs += packing.disc_count() / static_cast<double>(packings.size());
        facts.contacts += static_cast<double>(packing.contacts.size()) / static_cast<double>(packings.size());
        facts.stiffness = std::max(facts.stiffness, packing.stiffness);
        facts.stable_step = std::min(facts.stable_step, packing.stable_step);
    }
    return facts;
}

// Doubles and integers of one RVE in the farm: about 24 columns per disc, and 12 per candidate contact, of which there
// are about 1.6 for every contact (two contact lists are kept while one is rebuilt).
double rve_bytes(const RveFacts& facts) { return 8.0 * (24.0 * facts.discs + 2.0 * 12.0 * 1.6 * facts.contacts); }

void explain_effects(const Scene& scene) {
    const Effects effects = effects_of(scene);
    for (const auto& effect : effects.on) row("on", effect);
    for (const auto& effect : effects.off) row("off", effect);
}

// Limit and clock of heat, beside those of the mechanics. step: the mechanical one, s; 0 where nothing moves.
void explain_heat(const Scene& scene, const Grid& grid, Points& points, const std::vector<double>& half_size, double step) {
    Supports supports(grid, points.count());
    supports.update(grid, points, half_size);
    const HeatSolver heat(scene, grid, supports, half_size, points);
    const HeatLimit limit = heat.limit(grid, points);
    row("heat limit (43)", heat.describe(limit, grid));
    if (step <= 0.0) {
        double duration = 0.0;
        for (const StageSpec& stage : scene.stages) duration += stage.duration;
        const double taken = scene.step.fixed.value_or(limit.automatic);
        row("heat step", fmt::format("{:.3g} s{}: about {:.3g} steps", taken, taken > limit.step ? ": BEYOND THE LIMIT, the run will be refused" : "", std::ceil(duration / taken)));
    } else if (limit.automatic < step) {
        row("heat step", fmt::format("{:.0f} sub-steps within each mechanical step", std::ceil(step / limit.automatic)));
    } else {
        row("heat step", fmt::format("at most once in {:.0f} mechanical steps; more often where ice would change by more than {:g} (ice_step)", std::max(1.0, std::floor(limit.automatic / step)), scene.heat->ice_step));
    }
    for (const std::string& warning : heat.warnings()) row("warning", warning);
}

void explain_steps(const Scene& scene, const Grid& grid, Points& points, const std::vector<double>& half_size, const RveFacts& facts) {
    if (!scene.mechanics()) return explain_heat(scene, grid, points, half_size, 0.0);
    const StepLimit limit = mechanical_step_limit(grid, points, half_size);
    if (!std::isfinite(limit.step) && !scene.step.fixed) {
        row("time steps", "not known before the start: these packings do not tell their stiffness (those of `rve-farm pack` do)");
        return;
    }
    row("mechanical limit (42)", std::isfinite(limit.step) ? describe(limit, scene.domain.cell) : "not known before the start: these packings do not tell their stiffness");
    const double step = scene.step.fixed.value_or(scene.step.safety * std::min(limit.step, limit.surface_step));
    row("mechanical step", scene.step.fixed ? fmt::format("{:.3g} s, fixed by the scene{}", step, step > limit.step ? ": BEYOND THE LIMIT, the run will be refused" : "")
                                            : fmt::format("{:.3g} s now: safety {:.3g} times the smaller of that and the limit of free surfaces", step, scene.step.safety));
    double duration = 0.0;
    for (const StageSpec& stage : scene.stages) duration += stage.duration;
    const double steps = std::ceil(duration / step);
    if (scene.heat) explain_heat(scene, grid, points, half_size, step);
    row("simulated time", fmt::format("{:.4g} s in {} stage(s), about {:.3g} mechanical steps", duration, scene.stages.size(), steps));
    if (!scene.rve) return;
    const RveParameters& p = scene.rve->parameters;
    const int substeps = substeps_of(p, step);
    const double dem_limit = facts.stable_step / shortening_by_damping(p.damping), dem_step = step / substeps; // s
    if (dem_limit > 0.0) row("DEM limit", fmt::format("{:.3g} s = 2/(omega_max sqrt(1 + alpha)), of the stiffest packing's contacts", dem_limit));
    row("DEM sub-step", fmt::format("{:.3g} s: {} per mechanical step{}", dem_step, substeps, dem_limit > 0.0 && p.time_step > dem_limit ? "; rve.time_step IS BEYOND THE LIMIT, the run will be refused" : ""));
    const double work = static_cast<double>(facts.rves) * steps * substeps;
    // Compressed to this part in cases/thaw-slope and cases/biaxial; plus some 400 bytes per step of HDF5's own.
    constexpr double packed = 0.62;
    const double numbers = static_cast<double>(facts.rves) * exchanged_components(p.bond && scene.heat);
    row("recording (--record)", "about " + bytes_text(steps * (8.0 * numbers * packed + 400.0)));
    row("RVE sub-steps", fmt::format("{:.3g} ({} RVEs x {:.3g} steps x {})", work, facts.rves, steps, substeps));
}

} // namespace

int explain(const std::string& scene_file, const std::vector<std::string>& set, int threads) {
    Scene scene = read_scene(scene_file, set);
    std::vector<Packing> packings;
    complete_k0_range(scene);
    if (scene.rve) packings = obtain_packings(*scene.rve, threads, false);
    for (BodySpec& body : scene.bodies)
        if (body.law == "rve" && !body.density) body.density = bulk_density(packings, scene.rve->parameters.grain_density);

    const Grid grid(scene.domain.origin, scene.domain.size, scene.domain.cell, scene.domain.thickness, scene.mechanics());
    Points points = seed_points(scene.bodies, grid, scene.mechanics());
    std::vector<double> half_size;
    for (const BodySpec& body : scene.bodies) half_size.push_back(point_half_size(body, grid.cell()));
    std::int64_t rves = 0;
    for (int body : points.body) rves += scene.bodies[static_cast<std::size_t>(body)].law == "rve";
    const RveFacts facts = rve_facts(packings, rves);
    for (std::size_t p = 0; points.mechanical && p < points.count(); ++p) {
        const bool rve = scene.bodies[static_cast<std::size_t>(points.body[p])].law == "rve";
        points.p_wave_modulus[p] = rve ? facts.stiffness : ElasticLaw(*scene.elastic).p_wave_modulus();
    }

    std::vector<std::string> warnings = seeding_warnings(scene);
    if (scene.rve)
        for (const std::string& warning : packing_warnings(scene, packings)) warnings.push_back(warning);

    fmt::print("{} ({}, hash {})\n", scene.title, scene.file, scene.hash);
    explain_effects(scene);
    row("points", fmt::format("{} on {} x {} cells of {:.4g} m", points.count(), std::lround(scene.domain.size.x() / scene.domain.cell),
                              std::lround(scene.domain.size.y() / scene.domain.cell), scene.domain.cell));
    row("RVEs", fmt::format("{}", rves));
    if (rves > 0) {
        row("discs", fmt::format("{:.0f} per RVE, {:.0f} in all; {:.0f} contacts per RVE; {} packing(s)", facts.discs, facts.discs * static_cast<double>(rves), facts.contacts, packings.size()));
        row("memory of the farm", "about " + bytes_text(static_cast<double>(rves) * rve_bytes(facts)));
    }
    row("memory of the driver", "about " + bytes_text(((points.mechanical ? 400.0 : 200.0) + (scene.heat ? 90.0 : 0.0)) * static_cast<double>(points.count()) +
                                                          ((points.mechanical ? 100.0 : 0.0) + (scene.heat ? 80.0 + 40.0 * static_cast<double>(scene.heat->materials.size()) : 0.0)) * grid.node_count()));
    explain_steps(scene, grid, points, half_size, facts);
    for (const std::string& warning : warnings) row("warning", warning);
    row("threads", fmt::format("{}", threads > 0 ? threads : omp_get_max_threads()));
    return 0;
}

} // namespace talik::driver
