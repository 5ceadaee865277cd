#include "mpm-driver/points/seed.hpp"
#include "tests/mpm-driver/fault_text.hpp"
#include "tests/mpm-driver/mechanics/small_scenes.hpp"
#include "tests/support/catch.hpp"

using namespace talik;
using namespace talik::driver;
using namespace talik::driver::tests;

TEST_CASE("a box is tiled by its points wherever it stands: their volumes add up to its own") {
    const Grid grid({0, 0}, {2, 2}, 0.1, 0.5);
    for (const int per_cell : {1, 4, 9, 16})
        for (const double shift : {0.0, 0.0137}) {
            const Points points = seed_points({box({0.3 + shift, 0.2}, {1.1 + shift, 0.7}, per_cell)}, grid);
            CHECK(points.count() == static_cast<std::size_t>(8 * 5 * per_cell));
            double volume = 0.0, mass = 0.0;
            Vector centre = Vector::Zero();
            for (std::size_t p = 0; p < points.count(); ++p) {
                volume += points.volume[p];
                mass += points.mass[p];
                centre += points.position[p] / static_cast<double>(points.count());
            }
            CHECK(volume == Approx(0.8 * 0.5 * 0.5).epsilon(1e-12)); // sums of up to 640 roundings
            CHECK(mass == Approx(2000.0 * 0.8 * 0.5 * 0.5).epsilon(1e-12));
            CHECK((centre - Vector(0.7 + shift, 0.45)).norm() < 1e-13);
        }
}

TEST_CASE("neighbouring polygons share no point and leave none out") {
    const Grid grid({0, 0}, {2, 2}, 0.1, 1.0);
    BodySpec left = box({0, 0}, {1, 1}), right = left;
    left.polygon = {{0.2, 0.2}, {1.2, 0.2}, {0.8, 1.2}, {0.2, 1.2}};
    right.polygon = {{1.2, 0.2}, {1.8, 0.2}, {1.8, 1.2}, {0.8, 1.2}};
    const std::size_t together = seed_points({left, right}, grid).count();
    CHECK(together == 16u * 10u * 4u);
    CHECK(seed_points({left}, grid).count() + seed_points({right}, grid).count() == together);
}

TEST_CASE("a body without points, density or room is refused by name") {
    const Grid grid({0, 0}, {1, 1}, 0.1, 1.0);
    BodySpec body = box({0.2, 0.2}, {0.21, 0.21});
    CHECK(says(fault_of([&] { seed_points({body}, grid); }), "'body' holds no point"));
    body = box({0.5, 0.5}, {1.5, 0.8});
    CHECK(says(fault_of([&] { seed_points({body}, grid); }), "outside the domain"));
    body.density.reset();
    CHECK(says(fault_of([&] { seed_points({body}, grid); }), "no density"));
    body = box({0.2, 0.2}, {0.5, 0.5}, 5);
    CHECK(says(fault_of([&] { seed_points({body}, grid); }), "points_per_cell is 5"));
}
