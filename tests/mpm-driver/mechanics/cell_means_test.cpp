#include <cmath>

#include "mpm-driver/mechanics/cell_means.hpp"
#include "mpm-driver/mechanics/transfer.hpp"
#include "mpm-driver/points/seed.hpp"
#include "tests/mpm-driver/mechanics/small_scenes.hpp"
#include "tests/support/catch.hpp"

using namespace talik;
using namespace talik::driver;
using namespace talik::driver::tests;

TEST_CASE("strains averaged over cells are the work conjugates of stresses averaged over cells", "[bbar]") {
    const Grid grid({0, 0}, {1, 1}, 0.1, 1.0);
    Points points = seed_points({box({0.13, 0.2}, {0.71, 0.8})}, grid);
    for (std::size_t p = 0; p < points.count(); ++p) { // anything uneven
        const double q = static_cast<double>(p);
        points.volume[p] *= 1.0 + 0.3 * std::sin(q);
        points.stress[p] = {1e5 * std::sin(2.1 * q), 1e5 * std::cos(1.3 * q), 1e5 * std::sin(0.7 * q)};
        points.displacement_gradient_increment[p] << std::sin(q), std::cos(3.1 * q), std::sin(1.9 * q), std::cos(0.4 * q);
    }
    CellMeans means(grid, points.count());
    means.locate(grid, points);
    Points felt = points;
    felt.stress = means.acting_stress(points);
    const double on_the_nodes = stress_power(felt); // averaged stress, the grid's strain
    means.average_volume_strain(points);
    const double in_the_points = stress_power(points); // own stress, averaged strain
    CHECK(on_the_nodes == Approx(in_the_points).epsilon(1e-12)); // rounding of a sum over 140 points
    CHECK(std::abs(on_the_nodes) > 1.0);
}

TEST_CASE("with volume strain by cells a uniform strain is left alone, and the energy ledger closes", "[bbar][ledger]") {
    Scene scene = elastic_scene(box({0.4, 0.3}, {0.8, 1.1}), {0, 0}, {1.2, 1.5});
    scene.bodies[0].stress = {-1e5, -1e5, 0.0};
    scene.confining_pressure = 1e5;
    scene.walls = {wall("bottom", 0.3), wall("top", 1.1, "roller", -0.05)};
    scene.walls[1].ramp = 0.1;
    scene.stages[0].moves = {"top"};
    scene.stages[0].duration = 0.4; // 2.2 % of strain
    scene.stages[0].pic = 0.02;
    auto plain = start(scene);
    scene.domain.volume_strain = "cell";
    auto averaged = start(scene);
    while (!plain->finished()) take_steps(*plain, 1);
    while (!averaged->finished()) take_steps(*averaged, 1);
    CHECK(averaged->ledger().energy_error() + averaged->ledger().numerical_loss() < 0.01); // the project's bound
    CHECK(averaged->ledger().momentum_error() < 1e-12);
    for (std::size_t p = 0; p < plain->points().count(); ++p) // one nearly uniform stress in both: vibrations differ a little
        CHECK((averaged->points().stress[p] - plain->points().stress[p]).norm() < 0.02 * 1e5);
}
