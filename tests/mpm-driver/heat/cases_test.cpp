// Shipped thermal cases against their reference tables; tools/thermal-cases judges all of them, and more closely.
#include <algorithm>
#include <cmath>

#include "common/io/csv_table.hpp"
#include "mpm-driver/app/scene_schema.hpp"
#include "tests/mpm-driver/heat/small_heat.hpp"
#include "tests/support/catch.hpp"

using namespace talik;
using namespace talik::driver;
using namespace talik::driver::tests;

namespace {

const std::string cases = TALIK_SOURCE_DIR "/cases/";

double interpolated(const std::vector<double>& x, const std::vector<double>& y, double at) {
    const auto i = std::upper_bound(x.begin(), x.end(), at) - x.begin();
    const auto k = static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(i, 1, static_cast<std::ptrdiff_t>(x.size()) - 1));
    return y[k - 1] + (y[k] - y[k - 1]) * (at - x[k - 1]) / (x[k] - x[k - 1]);
}

} // namespace

TEST_CASE("a frozen inclusion thaws as in InterFrost's case without flow", "[eq41][inclusion]") {
    auto simulation = start_heat(read_scene(cases + "frozen-inclusion/arithmetic.toml"));
    const auto coldest = [&] { return simulation->heat()->extremes().first; };
    while (simulation->time() < 22860.0) simulation->step(simulation->next_step());
    CHECK(coldest() == Approx(-0.914).margin(0.04)); // bounds of the project at cells of 1/30 m
    while (coldest() < 0.0) simulation->step(simulation->next_step());
    CHECK(simulation->time() == Approx(140717.0).epsilon(0.04));
    CHECK(simulation->heat()->water_volume(simulation->points()) == Approx(1.11).epsilon(1e-3)); // m^3: n times the domain
    CHECK(balance(*simulation) < 1e-12);
    CHECK(simulation->heat()->books().overshoot() < 1e-9); // of a span of 10 K
}

TEST_CASE("a column of fine soil freezes as the reference does", "[eq4][eq40][column]") {
    const CsvTable table = read_csv(cases + "fine-soil/reference/fine_soil_front_L0.1.csv");
    auto simulation = start_heat(read_scene(cases + "fine-soil/fine-soil.toml"));
    while (simulation->time() < 3600.0) simulation->step(simulation->next_step());
    const Points& points = simulation->points();
    double front = 0.0; // m, isotherm of T0, in the lowest row of points
    for (std::size_t p = 1; p < points.count(); ++p)
        if (points.position[p][1] == points.position[0][1] && points.temperature[p] > 0.0) {
            const double a = points.temperature[p - 1], b = points.temperature[p];
            front = points.position[p - 1][0] - a * (points.position[p][0] - points.position[p - 1][0]) / (b - a);
            break;
        }
    CHECK(front == Approx(interpolated(table.values("t_s"), table.values("x_m"), simulation->time())).epsilon(0.01)); // the project's bound
    CHECK(balance(*simulation) < 1e-12);
}
