#pragma once
// Scenes for the tests of the driver, filled by hand.
#include <memory>
#include <string>

#include <omp.h>

#include "mpm-driver/constitutive/elastic.hpp"
#include "mpm-driver/mechanics/simulation.hpp"

namespace talik::driver::tests {

inline BodySpec box(const Vector& low, const Vector& high, int points_per_cell = 4) {
    BodySpec body;
    body.name = "body";
    body.polygon = {low, {high[0], low[1]}, high, {low[0], high[1]}};
    body.law = "elastic";
    body.points_per_cell = points_per_cell;
    body.density = 2000.0; // kg/m^3
    return body;
}

inline WallSpec wall(const std::string& side, double position, const std::string& kind = "roller", double velocity = 0.0) {
    WallSpec spec;
    spec.name = side;
    spec.side = side;
    spec.position = position;
    spec.kind = kind;
    spec.velocity = velocity;
    return spec;
}

// A body of soil: E = 10 MPa, nu = 0.2, 2000 kg/m^3 (P-wave 74.5 m/s), in a domain of cells of 0.1 m; one stage.
inline Scene elastic_scene(const BodySpec& body, const Vector& domain_origin, const Vector& domain_size, double cell = 0.1) {
    Scene scene;
    scene.domain.origin = domain_origin;
    scene.domain.size = domain_size;
    scene.domain.cell = cell;
    scene.elastic = ElasticSpec{1e7, 0.2};
    scene.bodies = {body};
    scene.stages.resize(1);
    scene.stages[0].name = "only";
    scene.stages[0].duration = 1e9;
    scene.step.fixed = 2e-4;
    return scene;
}

// Small scenes gain nothing from threads, and tests run side by side: one thread, unless a test is about threads.
inline std::unique_ptr<Simulation> start(const Scene& scene, int threads = 1) {
    omp_set_num_threads(threads);
    Simulation::Laws laws;
    laws["elastic"] = std::make_unique<ElasticLaw>(*scene.elastic);
    return std::make_unique<Simulation>(scene, std::move(laws));
}

inline void take_steps(Simulation& simulation, int count) {
    for (int k = 0; k < count; ++k) simulation.step(simulation.next_step());
}

inline double largest_stress(const Simulation& simulation) { // Pa
    double largest = 0.0;
    for (const Stress& s : simulation.points().stress) largest = std::max(largest, s.cwiseAbs().maxCoeff());
    return largest;
}

constexpr double young = 1e7, p_wave = 1e7 * 0.8 / (1.2 * 0.6); // Pa: E, and M = E (1 - nu) / ((1 + nu)(1 - 2 nu))

} // namespace talik::driver::tests
