// RVEs strained far, fast, apart and to and fro, on every kernel.
#include <algorithm>
#include <cmath>

#include "tests/hard/every_kernel.hpp"
#include "tests/hard/hard_case.hpp"
#include "tests/hard/rve_figures.hpp"

using namespace talik;
using namespace talik::farm;
using namespace talik::hard;

TEST_CASE("five per cent of strain in one macro step answer what fifty small steps answer", "[hard][rve]") {
    HardCase hard("RVE", "5 % strain in one macro step", "discs jump through each other and chunks explode");
    const Invariant split{"bits in which 100 sub-steps asked for differ from the 513 that are needed", 0, "1e-4 of strain for a sub-step"};
    const std::array<double, 4> large = {-0.05, 0, 0, 0.05};
    for (const KernelChoice& kernel : every_kernel()) {
        const auto fresh = [&](double distance = 0) { return kernel.farm_of(RveParameters(), moved(samples::disordered(64), distance)); };
        const auto fifty = [&](Farm farm) {
            Answer answer;
            for (int k = 0; k < 50; ++k) answer = samples::step(farm, {large[0] / 50, 0, 0, large[3] / 50}, 1e-4, 11);
            return answer;
        };
        Farm few = fresh(), enough = fresh(), at_once = fresh();
        const Answer split_by_itself = samples::step(few, large, 5e-3, 100), asked = samples::step(enough, large, 5e-3, 513);
        REQUIRE(split_by_itself.status == Status::ok);
        CHECK(split_by_itself.split_steps == 1);
        hard.holds(split, difference(split_by_itself, asked), kernel.name());
        const Answer answer = samples::step(at_once, large, 5e-3, 550), reference = fifty(fresh());
        // In 550 sub-steps: single rounds displacements of 5 % of a cell of 0.06 m, double the positions in it.
        const double rounding = kernel.single() ? rounding_walk(unit_single, 550) * 0.05 * 0.06 : rounding_walk(unit_double, 550) * 0.06; // m
        const double pressure = samples::mean_pressure(reference), scatter = difference(fifty(fresh(rounding)), reference) / pressure;
        hard.holds({kernel.single() ? "stress against fifty steps of the same motion in single, of the pressure" : "stress against fifty steps of the same motion, of the pressure", scatter,
                    "the fifty steps' own change when their discs start as far off as 550 sub-steps round"}, difference(answer, reference) / pressure, kernel.name());
    }
}

TEST_CASE("shear to ten times its height keeps the volume of an RVE, its ledger and its pressure", "[hard][rve]") {
    HardCase hard("RVE", "shear to gamma = 10", "the cell degenerates, contacts are lost in reductions of its basis");
    const Invariant volume{"change of the area, relative", 1e-14, "simple shear is isochoric: compensated sums leave the rounding (1e-16) of a determinant of a cell sheared by ten"};
    const Invariant pressure{"largest over least pressure of the last eight tenths", 3, "a critical state: forces spread like an exponential, their mean over 64 discs by an eighth; four standard deviations up and down"};
    for (const KernelChoice& kernel : every_kernel()) {
        Farm farm = kernel.farm_of(RveParameters(), samples::disordered(64));
        const Answer start = farm.measure(0);
        Answer answer;
        double least = 1e300, most = 0;
        for (int k = 0; k < 1000; ++k) {
            answer = samples::step(farm, {0, 1e-2, 0, 0}, 1e-3, 100);
            REQUIRE(answer.status == Status::ok);
            if (k < 200) continue;
            least = std::min(least, samples::mean_pressure(answer)), most = std::max(most, samples::mean_pressure(answer));
        }
        hard.holds(volume, std::abs(answer.cell_area / start.cell_area - 1), kernel.name());
        hard.holds(closed_ledger, ledger_residual(start, answer), kernel.name());
        hard.holds(pressure, most / least, kernel.name());
    }
}

TEST_CASE("an RVE pulled apart carries nothing and carries again once it is pressed together", "[hard][rve]") {
    HardCase hard("RVE", "pulled apart to no contact, and recompressed", "a gas of discs gathers speed and explodes when it closes");
    const Invariant nothing{"largest stress while apart, Pa", 0, "no contact, no force"};
    for (const KernelChoice& kernel : every_kernel()) {
        Farm farm = kernel.farm_of(RveParameters(), samples::disordered(64));
        for (int k = 0; k < 20; ++k) samples::step(farm, {0, 0, 0, 0}, 1e-3);
        const Answer start = farm.measure(0);
        Answer answer;
        for (int k = 0; k < 60; ++k) answer = samples::step(farm, {5e-3, 0, 0, 5e-3}, 5e-3);
        REQUIRE(answer.status == Status::ok);
        hard.holds(nothing, largest_stress(answer), kernel.name());
        for (int k = 0; k < 60; ++k) answer = samples::step(farm, {-5e-3, 0, 0, -5e-3}, 5e-3);
        for (int k = 0; k < 50; ++k) answer = samples::step(farm, {0, 0, 0, 0}, 1e-3);
        REQUIRE(answer.status == Status::ok);
        CHECK(samples::mean_pressure(answer) > 0); // it carries again, another packing of the same area
        hard.holds(first_law, held_over_fed(start, answer), kernel.name());
        hard.holds(closed_ledger, ledger_residual(start, answer), kernel.name());
    }
}

TEST_CASE("isochoric cycles toward liquefaction never pull on a packing without bonds", "[hard][rve]") {
    HardCase hard("RVE", "isochoric cycles toward liquefaction", "near no effective stress contacts chatter, and stress turns to tension");
    const Invariant tension{"largest tensile principal stress, of the first pressure", 1e-12, "contacts without bonds only push: rounding"};
    const Invariant volume{"change of the area, relative", 1e-14, "isochoric: compensated sums leave the rounding of a determinant"};
    for (const KernelChoice& kernel : every_kernel()) {
        Farm farm = kernel.farm_of(RveParameters(), samples::lattice(64, 0.01, 0.05, 0.03, 5));
        for (int k = 0; k < 20; ++k) samples::step(farm, {0, 0, 0, 0}, 1e-3);
        const Answer start = farm.measure(0);
        Answer answer;
        double pulled = 0;
        for (int k = 0; k < 1200; ++k) { // thirty cycles of +-1 %
            const double way = (k / 10) % 4 == 0 || (k / 10) % 4 == 3 ? 1e-3 : -1e-3;
            answer = samples::step(farm, {0, way, 0, 0}, 1e-3);
            REQUIRE(answer.status == Status::ok);
            pulled = std::max(pulled, largest_tension(answer));
        }
        hard.holds(tension, pulled / samples::mean_pressure(start), kernel.name());
        hard.holds(volume, std::abs(answer.cell_area / start.cell_area - 1), kernel.name());
        hard.holds(closed_ledger, ledger_residual(start, answer), kernel.name());
    }
}
