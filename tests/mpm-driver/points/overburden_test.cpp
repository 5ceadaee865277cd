#include "mpm-driver/points/overburden.hpp"

#include "mpm-driver/constitutive/packing_choice.hpp"
#include "tests/mpm-driver/mechanics/small_scenes.hpp"
#include "tests/support/catch.hpp"

using namespace talik;
using namespace talik::driver;
using namespace talik::driver::tests;

namespace {

// A slope of 45 degrees, 2 m high, 4 m wide at its foot, 2000 kg/m^3.
Scene slope() {
    BodySpec body = box({0, 0}, {1, 1});
    body.law = "rve";
    body.polygon = {{0, 0}, {4, 0}, {2, 2}, {0, 2}};
    Scene scene = elastic_scene(body, {0, 0}, {4, 3});
    scene.stages[0].gravity = {0.0, -10.0};
    scene.rve = RveSpec();
    scene.rve->packing.pressure = 1e3;
    scene.rve->packing.void_ratio = 0.2;
    return scene;
}

} // namespace

TEST_CASE("the overburden of a point is the weight of the ground straight above it", "[k0]") {
    const Overburden overburden(slope());
    CHECK(overburden({1.0, 1.5}) == Approx(2000.0 * 10.0 * 0.5)); // under the crest
    CHECK(overburden({3.0, 0.25}) == Approx(2000.0 * 10.0 * 0.75)); // under the face, which stands at y = 1 there
    CHECK(overburden({3.0, 1.5}) == 0.0);                         // above the face
    CHECK(overburden({1.0, 2.5}) == 0.0);                         // above the crest
}

TEST_CASE("bodies on top of one another weigh together, air under an overhang does not, and pressure comes on top", "[k0]") {
    Scene scene = slope();
    scene.bodies[0].polygon = {{0, 0}, {4, 0}, {4, 1}, {1, 1}, {1, 1.5}, {4, 1.5}, {4, 2}, {0, 2}}; // a slit from x = 1, y in [1, 1.5]
    BodySpec load = box({0, 2}, {4, 2.5});
    load.density = 1000.0;
    scene.bodies.push_back(load);
    scene.confining_pressure = 5e3;
    const Overburden overburden(scene);
    CHECK(overburden({2.0, 0.5}) == Approx(5e3 + 10.0 * (2000.0 * (0.5 + 0.5) + 1000.0 * 0.5)));
}

TEST_CASE("a K0 path without stresses of its own reaches from the shallowest to the deepest point, not below the packing's pressure", "[k0]") {
    Scene scene = slope(); // cells of 0.1 m with 2 x 2 points: a column's lowest is 25 mm above the base
    scene.rve->packing.k0 = K0Spec{};
    complete_k0_range(scene);
    CHECK(*scene.rve->packing.k0->stress_max == Approx(2000.0 * 10.0 * 1.975));
    CHECK(*scene.rve->packing.k0->stress_min == 1e3); // the shallowest stands at 500 Pa or less
    scene.rve->packing.k0 = K0Spec{4, "linear", 2e3, 9e3}; // what the scene says stays
    complete_k0_range(scene);
    CHECK(*scene.rve->packing.k0->stress_max == 9e3);
}

TEST_CASE("bodies of RVEs without a density weigh what their discs do at the void ratio aimed at", "[k0]") {
    Scene scene = slope();
    scene.bodies[0].density.reset();
    CHECK(Overburden(scene)({1.0, 1.0}) == Approx(2650.0 / 1.2 * 10.0));
}

TEST_CASE("each RVE gets, of the path dealt to it, the snapshot nearest to its depth's stress", "[k0]") {
    std::vector<Packing> packings(6);
    for (std::size_t k = 0; k < 6; ++k) {
        packings[k].seed = 1 + k / 3;
        packings[k].vertical_stress = 1e3 * static_cast<double>(1 + k % 3); // 1, 2, 3 kPa of two seeds
    }
    CHECK(k0_levels(packings) == 3);
    const std::vector<double> depths = {0.0, 1.4e3, 1.6e3, 2.4e3, 2.6e3, 9e3};
    const std::vector<int> dealt = deal_packings_by_depth(packings, depths, 7), paths = deal_packings(6, 2, 7);
    const std::vector<int> levels = {0, 0, 1, 1, 2, 2};
    for (std::size_t i = 0; i < 6; ++i) CHECK(dealt[i] == 3 * paths[i] + levels[i]);
    CHECK(k0_levels(std::vector<Packing>(4)) == 1); // isotropic ones are no path
}
