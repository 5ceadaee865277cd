#include "mpm-driver/points/overburden.hpp"

#include <algorithm>
#include <limits>

#include "common/base/error.hpp"
#include "mpm-driver/points/seed.hpp"

namespace talik::driver {
namespace {

double density_of(const BodySpec& body, const Scene& scene) { // kg/m^3
    if (body.density || !scene.rve) return body.density.value_or(0.0);
    return scene.rve->parameters.grain_density / (1.0 + scene.rve->packing.void_ratio);
}

// How much of the vertical line above x lies inside the outline, m: even-odd over the edges it crosses.
double ground_above(const std::vector<Vector>& outline, const Vector& x) {
    std::vector<double> crossings; // heights, m
    for (std::size_t i = 0; i < outline.size(); ++i) {
        const Vector &a = outline[i], &b = outline[(i + 1) % outline.size()];
        if ((a[0] > x[0]) == (b[0] > x[0])) continue; // half-open: a corner on the line counts once
        crossings.push_back(a[1] + (x[0] - a[0]) / (b[0] - a[0]) * (b[1] - a[1]));
    }
    std::sort(crossings.begin(), crossings.end());
    double length = 0.0;
    for (std::size_t k = 0; k + 1 < crossings.size(); k += 2) length += std::max(0.0, crossings[k + 1] - std::max(crossings[k], x[1]));
    return length;
}

} // namespace

Overburden::Overburden(const Scene& scene) : gravity_(scene.stages.empty() ? 0.0 : -scene.stages.front().gravity[1]), pressure_(scene.confining_pressure) {
    for (const BodySpec& body : scene.bodies) ground_.push_back({body.polygon, density_of(body, scene)});
}

double Overburden::operator()(const Vector& x) const {
    double stress = pressure_;
    for (const Ground& ground : ground_) stress += ground.density * gravity_ * ground_above(ground.outline, x);
    return stress;
}

void complete_k0_range(Scene& scene) {
    if (!scene.rve || !scene.rve->packing.k0 || scene.rve->packing.k0->stress_min) return;
    const Overburden overburden(scene);
    std::vector<BodySpec> bodies = scene.bodies;
    for (BodySpec& body : bodies) body.density = density_of(body, scene);
    const Grid grid(scene.domain.origin, scene.domain.size, scene.domain.cell, scene.domain.thickness);
    const Points points = seed_points(bodies, grid);
    double least = std::numeric_limits<double>::infinity(), most = 0.0;
    for (std::size_t p = 0; p < points.count(); ++p) {
        if (bodies[static_cast<std::size_t>(points.body[p])].law != "rve") continue;
        const double stress = overburden(points.position[p]);
        least = std::min(least, stress);
        most = std::max(most, stress);
    }
    K0Spec& k0 = *scene.rve->packing.k0;
    k0.stress_min = std::max(least, scene.rve->packing.pressure);
    k0.stress_max = std::max(most, *k0.stress_min);
    require(most > scene.rve->packing.pressure,
            "rve.packing.k0: the ground above the deepest point weighs " + std::to_string(most) + " Pa, no more than the packing's pressure",
            "prepare the packing at a lower pressure, give k0 its stress_min and stress_max, or the first stage its gravity");
}

} // namespace talik::driver
