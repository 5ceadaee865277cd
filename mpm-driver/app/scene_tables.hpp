#pragma once
// The tables of keys of a scene, one function for each struct of scene.hpp.
#include "common/scene/schema.hpp"
#include "mpm-driver/app/exchange_spec.hpp"
#include "mpm-driver/app/scene.hpp"

namespace talik::driver {

scene::Table<DomainSpec> domain_table();
scene::Table<BodySpec> body_table();
scene::Table<ElasticSpec> elastic_table();
scene::Table<HeatSpec> heat_table();
scene::Table<PhaseChangeStrainSpec> phase_change_strain_table();
scene::Table<WallSpec> wall_table();
scene::Table<StageSpec> stage_table();
scene::Table<StepSpec> step_table();
scene::Table<OutputSpec> output_table();
scene::Table<ExchangeSpec> exchange_table();

// Rules that look at more than one table.
void check_whole_scene(const Scene& scene, const scene::Place& at);
void check_heat(const Scene& scene, const scene::Place& at);

// Paths inside a scene are meant relative to it; `faults` gains those of files that do not exist.
void resolve_heat_files(Scene& scene, const scene::Value& document, scene::Faults& faults);

// Bulk density of a mixture, kg/m^3: (1 - n) rho_g + n S rho_f.
double mixture_density(const ThermalMaterialSpec& material);

// Of bodies whose points stand for more or less ground than their outlines enclose, by 1 % and more.
std::vector<std::string> seeding_warnings(const Scene& scene);

// What (34) does not bear: a damping alpha with alpha dt >= 1. For a step the scene fixes it is a fault of the scene; for an
// automatic one it shows at the first step.
struct DampingFault {
    std::string key, problem, remedy;
};
std::vector<DampingFault> damping_faults(const StageSpec& stage, double step);

} // namespace talik::driver
