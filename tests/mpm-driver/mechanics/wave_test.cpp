#include <cmath>

#include "tests/mpm-driver/mechanics/small_scenes.hpp"
#include "tests/support/catch.hpp"

using namespace talik;
using namespace talik::driver;
using namespace talik::driver::tests;

namespace {

struct WaveError { double displacement, stress; }; // root mean square, relative to the amplitude

// The first standing P-wave of a bar of 1 m between fixed ends, v = V cos(w t) sin(k x), after 0.7 of its period.
WaveError standing_wave_error(int cells) {
    constexpr double pi = 3.14159265358979323846;
    const double h = 1.0 / cells, k = pi, speed = std::sqrt(p_wave / 2000.0), omega = k * speed, amplitude = 1e-5; // V, m/s
    Scene scene = elastic_scene(box({0, 0}, {1, 2 * h}), {-h, -h}, {1 + 2 * h, 4 * h}, h);
    scene.walls = {wall("left", 0), wall("right", 1), wall("bottom", 0), wall("top", 2 * h)};
    const double end = 0.7 * 2 * pi / omega;
    const int steps = 10 * cells; // dt c / h = 0.14
    scene.step.fixed = end / steps;
    auto simulation = start(scene);
    Points& points = simulation->points();
    for (std::size_t p = 0; p < points.count(); ++p) points.velocity[p] = {amplitude * std::sin(k * points.position[p][0]), 0.0};
    take_steps(*simulation, steps);
    // Two things are so by construction and no error of the solution. Eq. (35) moves points by the mean of the mapped
    // velocities before and after a step, which leapfrog places at its start: positions lag by dt/2 (v - v_0). And a point
    // whose extent lies in one cell gets the strain of that cell, not of its own place in it.
    const double lag = 0.5 * end / steps * amplitude * (std::cos(omega * end) - 1.0); // m
    double displacement = 0.0, stress = 0.0;
    for (std::size_t p = 0; p < points.count(); ++p) {
        const double x = points.initial_position[p][0], left = std::floor(x / h) * h;
        const double exact = (amplitude / omega * std::sin(omega * end) - lag) * std::sin(k * x);
        const double exact_stress = p_wave * amplitude / omega * std::sin(omega * end) * (std::sin(k * (left + h)) - std::sin(k * left)) / h;
        displacement += std::pow((points.displacement(p)[0] - exact) / (amplitude / omega), 2);
        stress += std::pow((points.stress[p][0] - exact_stress) / (p_wave * k * amplitude / omega), 2);
    }
    const auto n = static_cast<double>(points.count());
    return {std::sqrt(displacement / n), std::sqrt(stress / n)};
}

} // namespace

TEST_CASE("an elastic standing wave converges to d'Alembert's solution with second order", "[eq22][eq30][eq34][eq35]") {
    // Small displacements on points that tile the bar: linear hats averaged over the points, lumped mass and central time
    // differences (velocities advanced before positions and strains) are each of second order, the step being cut with h.
    const WaveError coarse = standing_wave_error(10), middle = standing_wave_error(20), fine = standing_wave_error(40);
    const auto order = [](double a, double b) { return std::log2(a / b); };
    WARN("standing wave, 10, 20, 40 cells: displacement error " << coarse.displacement << ", " << middle.displacement << ", " << fine.displacement
         << ": orders " << order(coarse.displacement, middle.displacement) << ", " << order(middle.displacement, fine.displacement)
         << "; stress error " << coarse.stress << ", " << middle.stress << ", " << fine.stress << ": orders "
         << order(coarse.stress, middle.stress) << ", " << order(middle.stress, fine.stress));
    CHECK(order(middle.displacement, fine.displacement) > 1.8);
    CHECK(order(middle.stress, fine.stress) > 1.8);
    CHECK(fine.displacement < 0.01);
}
