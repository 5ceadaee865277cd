#pragma once
// Scenes of heat for the tests, filled by hand.
#include <cmath>

#include "tests/mpm-driver/mechanics/small_scenes.hpp"

namespace talik::driver::tests {

// The paper's unit soil: L = rho = n = 1, k = 0.1, c as given, a sharp front at 0 C.
inline ThermalMaterialSpec unit_material(double heat_capacity = 0.1) {
    ThermalMaterialSpec m;
    m.name = "unit";
    m.porosity = 1.0;
    m.water_density = m.ice_density = 1.0;
    m.water_heat_capacity = m.ice_heat_capacity = heat_capacity;
    m.water_conductivity = m.ice_conductivity = 0.1;
    m.latent_heat = 1.0;
    return m;
}

// The soil of the paper's slope, n = 0.43, saturated.
inline ThermalMaterialSpec soil_material() {
    ThermalMaterialSpec m;
    m.name = "soil";
    m.porosity = 0.43;
    m.grain_heat_capacity = 900.0;
    m.grain_conductivity = 2.92;
    return m;
}

inline HeatBoundarySpec held_side(const std::string& side, double celsius) {
    HeatBoundarySpec boundary;
    boundary.name = side;
    boundary.side = side;
    boundary.value.constant = celsius;
    return boundary;
}

// One box of one material, at rest; heat alone.
inline Scene heat_scene(const ThermalMaterialSpec& material, const Vector& size, double cell, double celsius) {
    Scene scene;
    scene.domain.size = size;
    scene.domain.cell = cell;
    BodySpec body = box({0, 0}, size);
    body.law = "none";
    body.material = material.name;
    body.temperature = celsius;
    scene.bodies = {body};
    scene.heat.emplace();
    scene.heat->materials = {material};
    scene.stages.resize(1);
    scene.stages[0].name = "only";
    scene.stages[0].duration = 1e12;
    return scene;
}

inline std::unique_ptr<Simulation> start_heat(const Scene& scene, int threads = 1) {
    omp_set_num_threads(threads);
    Simulation::Laws laws;
    if (scene.elastic) laws["elastic"] = std::make_unique<ElasticLaw>(*scene.elastic);
    return std::make_unique<Simulation>(scene, std::move(laws));
}

inline double balance(const Simulation& simulation) { return simulation.heat()->balance_error(simulation.points()); }

// Makes the bodies of a heat scene move: very soft elastic ground, so that heat alone sets the pace; the caller prescribes.
inline void make_moving(Scene& scene, const Vector& room, double step) {
    for (BodySpec& body : scene.bodies) {
        body.law = "elastic";
        body.density = 2000.0;
    }
    scene.elastic = ElasticSpec{1e-9, 0.0};
    scene.domain.size += room;
    scene.step.fixed = step;
}

} // namespace talik::driver::tests
