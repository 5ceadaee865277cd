#include "mpm-driver/heat/heat_solver.hpp"

#include <cmath>

#include "tests/mpm-driver/fault_text.hpp"
#include "tests/mpm-driver/heat/small_heat.hpp"
#include "tests/support/catch.hpp"

using namespace talik;
using namespace talik::driver;
using namespace talik::driver::tests;

namespace {

constexpr double pi = 3.14159265358979323846;

// Error of T = 2 + cos(pi x) cos(2 pi y) exp(-5 pi^2 t) on the unit box at t = 0.02, root mean square over the points.
double decay_error(int cells) {
    ThermalMaterialSpec spec = unit_material(1.0);
    spec.curve = "none";
    spec.water_conductivity = 1.0;
    auto simulation = start_heat(heat_scene(spec, {1, 1}, 1.0 / cells, 2.0));
    const auto exact = [](const Vector& x, double t) { return 2.0 + std::cos(pi * x[0]) * std::cos(2 * pi * x[1]) * std::exp(-5 * pi * pi * t); };
    std::vector<double> start;
    for (const Vector& x : simulation->points().position) start.push_back(exact(x, 0.0));
    simulation->set_temperature(start);
    const double end = 0.02;
    while (simulation->time() < end * (1 - 1e-9)) simulation->step(std::min(simulation->next_step(), end - simulation->time()));
    double sum = 0.0;
    const Points& points = simulation->points();
    for (std::size_t p = 0; p < points.count(); ++p) sum += std::pow(points.temperature[p] - exact(points.position[p], end), 2);
    return std::sqrt(sum / static_cast<double>(points.count()));
}

Scene freezing_square() {
    Scene scene = heat_scene(soil_material(), {0.4, 0.3}, 0.05, 3.0);
    scene.heat->boundaries = {held_side("left", -4.0), held_side("top", -2.0)};
    return scene;
}

} // namespace

TEST_CASE("a decaying cosine field is met with second order", "[eq20][eq21][eq27]") {
    // Bilinear shapes, lumped capacity, dt ~ h^2: each of second order.
    const double coarse = decay_error(10), middle = decay_error(20), fine = decay_error(40);
    WARN("cosine field, 10, 20, 40 cells: errors " << coarse << ", " << middle << ", " << fine << ": orders " << std::log2(coarse / middle) << ", " << std::log2(middle / fine));
    CHECK(std::log2(middle / fine) > 1.8);
    CHECK(fine < 2e-3); // of an amplitude of 1 at the start
}

TEST_CASE("fifty freeze-thaw cycles of a closed column follow the exact curve and end where they began", "[eq9][eq3]") {
    for (const std::string curve : {"ramp", "fine", "saturation"}) {
        ThermalMaterialSpec spec = soil_material();
        spec.curve = curve;
        spec.residual_temperature = curve == "ramp" ? -0.5 : 0.0;
        Scene scene = heat_scene(spec, {0.1, 1.0}, 0.1, 2.0);
        const double cycle = 40 * 86400.0, power = 250.0; // s, W/m^3: 1.4e8 J/m^3 of latent heat are passed in each half
        HeatSourceSpec source;
        source.name = "cycles";
        source.value.constant = 0.0;
        source.value.amplitude = power;
        source.value.period = cycle;
        source.value.shift = 0.5 * cycle; // cools first
        scene.heat->sources = {source};
        scene.step.fixed = cycle / 500.0;
        scene.heat->stability = 2.0;
        REQUIRE(*scene.step.fixed > 0.0);
        auto simulation = start_heat(scene);
        scene.step.fixed.reset();
        const HeatSolver& heat = *simulation->heat();
        const ThermalMaterial material(spec);
        const double limit = heat.limit(simulation->grid(), simulation->points()).step;
        const double step = cycle / std::ceil(cycle / limit), h0 = material.enthalpy({2.0, 0.0}), first = heat.content(simulation->points());
        double worst_t = 0.0, worst_ice = 0.0, coldest = 0.0;
        const auto steps_per_cycle = static_cast<int>(std::lround(cycle / step));
        for (int k = 1; k <= 50 * steps_per_cycle; ++k) {
            simulation->step(step);
            if (k % 7 != 0) continue;
            // Exact: H = H0 - P (cycle / 2 pi) (1 - cos(2 pi t / cycle))
            const ThermalState exact = material.state_of(h0 - power * cycle / (2 * pi) * (1.0 - std::cos(2 * pi * heat.time() / cycle)));
            const Points& points = simulation->points();
            for (std::size_t p = 0; p < points.count(); p += 9) {
                worst_t = std::max(worst_t, std::abs(points.temperature[p] - exact.temperature));
                worst_ice = std::max(worst_ice, std::abs(points.ice_fraction[p] - material.ice_volume(material.frozen_fraction(exact))));
            }
            coldest = std::min(coldest, exact.temperature);
        }
        WARN("50 cycles, " << curve << ": temperature off by " << worst_t << " K, ice by " << worst_ice << ", coldest " << coldest << " C");
        CHECK(worst_t < 1e-9);
        CHECK(worst_ice < 1e-9);
        CHECK(coldest < -1.0);
        CHECK(std::abs(heat.content(simulation->points()) / first - 1.0) < 1e-9);
        CHECK(balance(*simulation) < 1e-12);
    }
}

TEST_CASE("in anisotropic ground a warm spot spreads by twice the conductivity tensor over the capacity", "[eq10]") {
    ThermalMaterialSpec spec = unit_material(1.0);
    spec.curve = "none";
    spec.water_conductivity = 1.0;
    spec.anisotropy = {1.5, 0.6, 0.5};
    auto simulation = start_heat(heat_scene(spec, {4, 4}, 0.1, 0.0));
    std::vector<double> spot;
    for (const Vector& x : simulation->points().position) spot.push_back(std::exp(-(x - Vector(2, 2)).squaredNorm() / (2 * 0.09)));
    simulation->set_temperature(spot);
    const auto moments = [&] {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        double all = 0.0;
        const Points& points = simulation->points();
        for (std::size_t p = 0; p < points.count(); ++p) {
            const Vector d = points.position[p] - Vector(2, 2);
            all += points.enthalpy[p];
            sum += points.enthalpy[p] * Eigen::Vector3d(d[0] * d[0], d[1] * d[1], d[0] * d[1]);
        }
        return Eigen::Vector3d(sum / all);
    };
    const Eigen::Vector3d before = moments();
    while (simulation->time() < 0.1) simulation->step(simulation->next_step());
    const Eigen::Vector3d grown = (moments() - before) / (2.0 * simulation->time());
    // Exact for the moments of the infinite field; the box at 6 standard deviations cuts 1e-4 of them, and mapping to the
    // points adds a fixed (3/16) h^2 for what has moved.
    CHECK((grown - Eigen::Vector3d(1.5, 0.6, 0.5)).norm() < 0.02);
}

TEST_CASE("walls, corners, heaters and fluxes are booked to rounding, and held ground takes its temperature", "[eq21]") {
    Scene scene = freezing_square();
    HeaterSpec heater;
    heater.name = "heater";
    heater.box = {Vector(0.2, 0.1), Vector(0.25, 0.15)};
    heater.value.constant = 12.0;
    heater.begins = 1e5;
    heater.ends = 3e5;
    scene.heat->heaters = {heater};
    HeatBoundarySpec flux = held_side("right", 20.0);
    flux.kind = "flux";
    flux.from = 0.1;
    flux.to = 0.25;
    scene.heat->boundaries.push_back(flux);
    auto simulation = start_heat(scene);
    double warmest = 0.0;
    while (simulation->time() < 4e5) {
        simulation->step(simulation->next_step());
        warmest = std::max(warmest, *std::max_element(simulation->points().temperature.begin(), simulation->points().temperature.end()));
    }
    CHECK(balance(*simulation) < 1e-12);
    CHECK(warmest > 9.0); // at the points around the heater's nodes
    CHECK(warmest <= 12.0);
    const HeatBooks& books = simulation->heat()->books();
    CHECK(books.heat(2) == Approx(20.0 * 0.15 * simulation->time()).epsilon(1e-12)); // W/m^2 * m^2 * s
    CHECK(books.heat(3) > 0.0);
}

TEST_CASE("a heater is switched by the scene's clock, however fast heat's own runs", "[heat]") {
    for (const double scale : {1.0, 1000.0}) {
        Scene scene = heat_scene(soil_material(), {0.4, 0.3}, 0.05, 5.0);
        HeaterSpec heater;
        heater.name = "heater";
        heater.box = {Vector(0.2, 0.1), Vector(0.25, 0.15)};
        heater.value.constant = 12.0;
        heater.begins = 2000.0 / scale;
        scene.heat->heaters = {heater};
        scene.heat->time_scale = scale;
        scene.step.fixed = 100.0 / scale;
        auto simulation = start_heat(scene);
        for (int k = 0; k < 20; ++k) simulation->step(simulation->next_step()); // up to 2000 s of heat
        CAPTURE(scale);
        CHECK(simulation->heat()->books().heat(0) == 0.0);
        simulation->step(simulation->next_step());
        CHECK(simulation->heat()->books().heat(0) > 0.0);
    }
}

TEST_CASE("a heater that begins after the end of the scene is named in a warning", "[heat]") {
    Scene scene = freezing_square();
    HeaterSpec heater;
    heater.name = "late";
    heater.box = {Vector(0.2, 0.1), Vector(0.25, 0.15)};
    heater.value.constant = 12.0;
    heater.begins = 2e12; // the stage ends at 1e12 s
    scene.heat->heaters = {heater};
    const std::vector<std::string> warnings = start_heat(scene)->heat()->warnings();
    REQUIRE(warnings.size() == 1);
    CHECK(says(warnings[0], "the heater \"late\" stays off"));
}

TEST_CASE("dry rock beside wet ground that freezes stays in the range of temperatures", "[eq9]") {
    Scene scene = freezing_square();
    ThermalMaterialSpec rock = soil_material();
    rock.name = "rock";
    rock.porosity = 0.01;
    rock.curve = "none";
    scene.heat->materials.push_back(rock);
    scene.bodies[0].polygon = {{0, 0}, {0.2, 0}, {0.2, 0.3}, {0, 0.3}};
    BodySpec other = box({0.2, 0}, {0.4, 0.3});
    other.name = "rock";
    other.law = "none";
    other.material = "rock";
    other.temperature = 3.0;
    scene.bodies.push_back(other);
    auto simulation = start_heat(scene);
    while (simulation->time() < 2e6) simulation->step(simulation->next_step());
    CHECK(balance(*simulation) < 1e-12);
    CHECK(simulation->heat()->books().overshoot() < 1e-6); // of a span of 7 K
}

TEST_CASE("dry rock that is held between a heater and wet ground takes none of its latent heat", "[eq21][held]") {
    // A row of dry rock a cell thick on frozen wet ground, warmed at its face; then the heater goes off.
    for (const double sign : {1.0, -1.0}) { // thaw, and its mirror
        Scene scene = heat_scene(soil_material(), {0.1, 1.0}, 0.05, -1.0 * sign);
        ThermalMaterialSpec rock = soil_material();
        rock.name = "rock";
        rock.porosity = 0.02;
        rock.saturation = 0.0;
        rock.curve = "none";
        scene.heat->materials.push_back(rock);
        scene.bodies[0].polygon = {{0, 0.05}, {0.1, 0.05}, {0.1, 1.0}, {0, 1.0}};
        BodySpec crust = box({0, 0}, {0.1, 0.05});
        crust.name = "crust";
        crust.law = "none";
        crust.material = "rock";
        crust.temperature = -1.0 * sign;
        scene.bodies.push_back(crust);
        HeaterSpec heater;
        heater.name = "face";
        heater.line = {Vector(0.0, 0.0), Vector(0.1, 0.0)};
        heater.value.constant = 5.0 * sign;
        heater.ends = 5.0 * 86400.0;
        scene.heat->heaters = {heater};
        auto simulation = start_heat(scene);
        while (simulation->time() < 6.0 * 86400.0) simulation->step(simulation->next_step());
        CAPTURE(sign);
        CHECK(balance(*simulation) < 1e-12);
        CHECK(simulation->heat()->books().overshoot() < 1e-6); // K of 6; a held row that copies latent heat is off by 28 K
    }
}

TEST_CASE("ground within a heater has its temperature, also when the heater goes off", "[held]") {
    Scene scene = heat_scene(soil_material(), {1.0, 1.0}, 0.05, -2.0);
    HeaterSpec heater;
    heater.name = "box";
    heater.box = {Vector(0.4, 0.4), Vector(0.6, 0.6)};
    heater.value.constant = 20.0;
    heater.ends = 8.64e5;
    scene.heat->heaters = {heater};
    auto simulation = start_heat(scene);
    while (simulation->time() < 8.64e5) simulation->step(simulation->next_step());
    simulation->step(simulation->next_step());
    const Points& points = simulation->points();
    double least = 1e300;
    for (std::size_t p = 0; p < points.count(); ++p) // those whose nodes all lie deeper within than the rim
        if ((points.position[p] - Vector(0.5, 0.5)).cwiseAbs().maxCoeff() < 0.03) least = std::min(least, points.temperature[p]);
    CHECK(least > 0.9 * 20.0); // one step after it has gone off
    CHECK(balance(*simulation) < 1e-12);
}

TEST_CASE("a plate as thin as a cell feels the temperature and the flux of its side", "[held]") {
    for (const double thickness : {0.05, 0.075, 0.1, 0.2}) {
        for (const double offset : {0.0, 0.0125, 0.025}) {
            Scene scene = heat_scene(soil_material(), {1.0, 0.4}, 0.05, 5.0);
            scene.bodies[0].polygon = {{0, 0.1 + offset}, {1, 0.1 + offset}, {1, 0.1 + offset + thickness}, {0, 0.1 + offset + thickness}};
            HeatBoundarySpec top = held_side("top", 5.0);
            top.kind = "flux"; // 5 W/m2
            scene.heat->boundaries = {top};
            auto simulation = start_heat(scene);
            while (simulation->time() < 86400.0) simulation->step(simulation->next_step());
            CAPTURE(thickness, offset);
            CHECK(simulation->heat()->books().heat(0) == Approx(5.0 * 1.0 * simulation->time()).epsilon(1e-12)); // W/m^2 * m^2 * s
            scene.heat->boundaries = {held_side("top", 1.0)};
            simulation = start_heat(scene);
            while (simulation->time() < 30.0 * 86400.0) simulation->step(simulation->next_step());
            for (const double celsius : simulation->points().temperature) REQUIRE(celsius == Approx(1.0).margin(0.01));
        }
    }
}

TEST_CASE("a source gives its power to all that lies in its box, wherever the points are", "[sources]") {
    for (const double width : {0.01, 0.07, 0.3}) {
        Scene scene = heat_scene(soil_material(), {1.0, 0.5}, 0.05, 5.0);
        HeatSourceSpec source;
        source.name = "q";
        source.box = {Vector(0.505, 0.1), Vector(0.505 + width, 0.4)};
        source.value.constant = 100.0; // W/m^3
        scene.heat->sources = {source};
        auto simulation = start_heat(scene);
        for (int k = 0; k < 10; ++k) simulation->step(simulation->next_step());
        CAPTURE(width);
        CHECK(simulation->heat()->books().heat(0) == Approx(100.0 * width * 0.3 * simulation->time()).epsilon(1e-10));
    }
}

TEST_CASE("what heats nothing is refused by its name", "[heat]") {
    Scene scene = heat_scene(soil_material(), {1.0, 0.5}, 0.05, 5.0);
    HeatBoundarySpec between = held_side("top", 1.0);
    between.from = 0.51, between.to = 0.54;
    scene.heat->boundaries = {between};
    CHECK_THROWS_WITH(start_heat(scene), Catch::Contains("the boundary 'top' touches no node"));
    scene.heat->boundaries.clear();
    HeatSourceSpec source;
    source.name = "far";
    source.box = {Vector(5, 5), Vector(6, 6)};
    source.value.constant = 1.0;
    scene.heat->sources = {source};
    CHECK_THROWS_WITH(start_heat(scene), Catch::Contains("the source 'far' touches no ground"));
}

TEST_CASE("a step that is not stable stops the run below absolute zero, with node and time", "[eq43]") {
    ThermalMaterialSpec soil = soil_material();
    soil.curve = "none";
    Scene scene = heat_scene(soil, {1.0, 0.5}, 0.05, 5.0);
    scene.domain.size = {1.0, 0.7};
    scene.bodies[0].polygon = {{0.013, 0}, {1, 0.02}, {0.8, 0.55}, {0.5, 0.61}, {0.21, 0.47}}; // cut cells
    scene.heat->boundaries = {held_side("bottom", -4.0)};
    auto simulation = start_heat(scene);
    const double unstable = 0.999 * simulation->heat()->limit(simulation->grid(), simulation->points()).step;
    const auto run = [&] { for (int k = 0; k < 3000; ++k) simulation->step(unstable); };
    CHECK_THROWS_WITH(run(), Catch::Contains("below absolute zero"));
}

TEST_CASE("heat alone has no column of mechanics, mechanics alone none of heat", "[effects]") {
    auto alone = start_heat(freezing_square());
    CHECK(alone->points().velocity.capacity() == 0);
    CHECK(alone->points().stress.capacity() == 0);
    CHECK(alone->points().deformation.capacity() == 0);
    CHECK(alone->grid().mass.capacity() == 0);
    CHECK(alone->laws().empty());
    CHECK(alone->schedule().table_of_contents() == std::vector<std::string>{"heat"});
    auto mechanics = start(elastic_scene(box({0, 0}, {0.4, 0.4}), {0, 0}, {1, 1}));
    CHECK(mechanics->heat() == nullptr);
    CHECK(mechanics->points().enthalpy.capacity() == 0);
    for (const std::string& row : mechanics->schedule().table_of_contents()) CHECK(row != "heat");
}

TEST_CASE("heat gives the same bits for any number of threads", "[heat][threads]") {
    Scene scene = freezing_square();
    scene.domain.cell = 0.01; // 1200 cells: loops worth threads
    auto one = start_heat(scene, 1);
    for (int k = 0; k < 40; ++k) one->step(one->next_step());
    auto two = start_heat(scene, 2);
    for (int k = 0; k < 40; ++k) two->step(two->next_step());
    const bool same_heat = one->points().enthalpy == two->points().enthalpy, same_temperature = one->points().temperature == two->points().temperature;
    CHECK(same_heat);
    CHECK(same_temperature);
    CHECK(one->heat()->books().entered() == two->heat()->books().entered());
}

TEST_CASE("a run of heat goes on from its state bit by bit, alone, with mechanics, and in the capacity form", "[heat][restart]") {
    Scene alone = freezing_square();
    Scene moving = alone;
    make_moving(moving, {0.4, 0.2}, 200.0);
    Scene capacity = alone;
    capacity.heat->formulation = "capacity";
    capacity.heat->materials[0].residual_temperature = -0.5;
    for (const Scene& scene : {alone, moving, capacity}) {
        const auto prepared = [&] {
            auto s = start_heat(scene);
            PrescribedField field;
            field.velocity = Vector(1e-5, 3e-6);
            if (s->mechanics()) s->prescribe(field);
            return s;
        };
        auto whole = prepared(), first = prepared(), second = prepared();
        for (int k = 0; k < 60; ++k) whole->step(whole->next_step());
        for (int k = 0; k < 31; ++k) first->step(first->next_step());
        auto from = first->state(), to = second->state();
        REQUIRE(from.size() == to.size());
        for (std::size_t c = 0; c < from.size(); ++c) std::copy(from[c].data, from[c].data + from[c].size(), to[c].data);
        second->restored();
        for (int k = 31; k < 60; ++k) second->step(second->next_step());
        const bool same_heat = second->points().enthalpy == whole->points().enthalpy, same_temperature = second->points().temperature == whole->points().temperature;
        CHECK(same_heat);
        CHECK(same_temperature);
        CHECK(second->heat()->books().entered() == whole->heat()->books().entered());
    }
}

TEST_CASE("a step beyond the limit of heat is refused, and said with the limit", "[eq43]") {
    Scene scene = freezing_square();
    auto simulation = start_heat(scene);
    const HeatLimit limit = simulation->heat()->limit(simulation->grid(), simulation->points());
    // C h^2 / (2 k) of the frozen soil: sensible heat capacity and the largest conductivity
    CHECK(limit.step == Approx((0.57 * 2650 * 900 + 430 * 2100) * 0.0025 / (2 * std::pow(2.92, 0.57) * std::pow(2.24, 0.43))));
    CHECK(limit.automatic == Approx(0.5 * limit.step));
    const std::string fault = fault_of([&] { simulation->step(1.01 * limit.step); });
    CHECK(says(fault, "is beyond the largest stable one of heat"));
    CHECK(says(fault, "use step.fixed = \"auto\", or at most"));
    CHECK(fault_of([&] { simulation->step(limit.step); }) == "");
}

TEST_CASE("a scene on a faster clock of heat runs through the same states in less of its time", "[heat][time_scale]") {
    Scene slow = freezing_square();
    slow.heat->boundaries[0].value.amplitude = 3.0;
    slow.heat->boundaries[0].value.period = 1e5;
    Scene fast = slow;
    fast.heat->time_scale = 86400.0;
    auto a = start_heat(slow), b = start_heat(fast);
    for (int k = 0; k < 200; ++k) {
        a->step(400.0);
        b->step(400.0 / 86400.0);
    }
    for (std::size_t p = 0; p < a->points().count(); ++p) REQUIRE(b->points().temperature[p] == Approx(a->points().temperature[p]).margin(1e-9));
    CHECK(b->heat()->books().entered() == Approx(a->heat()->books().entered()).epsilon(1e-9));
    REQUIRE(b->heat()->warnings().size() == 1);
    CHECK(says(b->heat()->warnings()[0], "86400 times faster"));
}

TEST_CASE("the balance of ground at zero that a held node barely reaches is measured by what the span could move", "[heat]") {
    ThermalMaterialSpec dry = soil_material();
    dry.curve = "none";
    Scene scene = heat_scene(dry, {0.2, 0.2}, 0.2, 0.0);
    scene.domain.size = {1.4, 1.4};
    scene.bodies[0].polygon = box({0.6 + 2e-10, 0.0}, {0.8 + 2e-10, 0.2}, 9).polygon;
    scene.heat->boundaries = {held_side("right", -41.6)};
    auto simulation = start_heat(scene);
    for (int k = 0; k < 20; ++k) simulation->step(simulation->next_step());
    CHECK(simulation->heat()->books().moved() < 1e-6); // J: the node holds a part of 1e-19 of the ground
    CHECK(balance(*simulation) < 1e-12);
}
