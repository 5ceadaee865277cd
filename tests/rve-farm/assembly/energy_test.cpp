// The energy of leapfrog, and the ledger of an RVE.
#include <algorithm>
#include <cmath>

#include "tests/support/catch.hpp"
#include "tests/support/rve_samples.hpp"

using namespace talik;
using namespace talik::farm;

namespace {

RveParameters undamped_and_frictionless() {
    RveParameters parameters;
    parameters.damping = 0;
    parameters.contact.friction = 0;
    return parameters;
}

double total(const Answer& a) { return a.stored_energy + a.kinetic_energy; }

// A lattice pressed so firmly that no contact opens, with radii that differ a little: it rings for ever.
Packing closed_network() {
    Packing packing = samples::lattice(36, 0.04, 0.0, 0.002, 3);
    std::uint64_t seed = 5;
    for (int i = 0; i < 36; ++i) {
        packing.velocity_x.push_back(0.01 * samples::draw(seed));
        packing.velocity_y.push_back(0.01 * samples::draw(seed));
        packing.spin.push_back(0);
    }
    return packing;
}

// The largest departure from the energy at the start, over a stretch of time, relative to the kinetic energy.
double departure(int sub_steps, int macro_steps) {
    Farm farm(undamped_and_frictionless(), {closed_network()}, {0});
    Answer start = samples::step(farm, {0, 0, 0, 0}, 1e-4, sub_steps);
    double largest = 0, kinetic = 0;
    for (int k = 0; k < macro_steps; ++k) {
        const Answer answer = samples::step(farm, {0, 0, 0, 0}, 1e-4, sub_steps);
        largest = std::max(largest, std::abs(total(answer) - total(start)));
        kinetic = std::max(kinetic, answer.kinetic_energy);
    }
    return largest / kinetic;
}

} // namespace

TEST_CASE("without damping and friction a closed contact network keeps its energy over 1e5 steps", "[energy]") {
    Farm farm(undamped_and_frictionless(), {closed_network()}, {0});
    const int contacts = farm.measure(0).contacts;
    REQUIRE(contacts == 108); // three per disc
    Answer start = samples::step(farm, {0, 0, 0, 0}, 1e-3, 100), answer;
    for (int k = 0; k < 1000; ++k) {
        answer = samples::step(farm, {0, 0, 0, 0}, 1e-3, 100);
        REQUIRE(answer.contacts == contacts); // closed it is
    }
    REQUIRE(answer.kinetic_energy > 1e-6 * total(start));
    CHECK(std::abs(total(answer) - total(start)) <= 1e-6 * total(start));
}

TEST_CASE("the energy error of a closed network is of second order in the step", "[energy]") {
    const double coarse = departure(10, 200), fine = departure(20, 200); // steps of 1e-5 and 5e-6 s
    INFO("departures " << coarse << " and " << fine);
    CHECK(coarse / fine > 3.0); // 4, for second order
    CHECK(coarse / fine < 5.5);
}

TEST_CASE("with contacts opening and closing the energy is kept to 1e-3", "[energy]") {
    Packing packing = samples::disordered(64);
    std::uint64_t seed = 11;
    for (int i = 0; i < 64; ++i) { // fast enough to leave contacts
        packing.velocity_x.push_back(0.3 * samples::draw(seed));
        packing.velocity_y.push_back(0.3 * samples::draw(seed));
        packing.spin.push_back(0);
    }
    Farm farm(undamped_and_frictionless(), {packing}, {0});
    const Answer start = samples::step(farm, {0, 0, 0, 0}, 1e-3, 1000); // 1e-6 s
    Answer answer;
    int fewest = start.contacts, most = start.contacts;
    for (int k = 0; k < 100; ++k) {
        answer = samples::step(farm, {0, 0, 0, 0}, 1e-3, 1000);
        fewest = std::min(fewest, answer.contacts), most = std::max(most, answer.contacts);
    }
    CHECK(most > fewest + 3); // they do open and close
    CHECK(std::abs(total(answer) - total(start)) < 1e-3 * total(start));
}

TEST_CASE("the ledger of an RVE closes: work = stored + kinetic + friction + damping + bonds broken", "[energy]") {
    const auto error = [](bool bonds, bool fluctuation, double damping, int refinement) {
        RveParameters parameters;
        parameters.damping = damping;
        parameters.fluctuation_stress = fluctuation;
        if (bonds) parameters.bond = BondParameters{3e6, 3e6, 1};
        Farm farm(parameters, {samples::disordered(64)}, {0});
        for (int k = 0; k < 20; ++k) samples::step(farm, {0, 0, 0, 0}, 1e-3); // nearly at rest
        if (bonds) farm.activate_bonds();
        const Answer start = farm.measure(0);
        Answer answer;
        for (int k = 0; k < 60; ++k) answer = samples::step(farm, {2e-4, 3e-4, -1e-4, -4e-4}, 1e-3, 100 * refinement);
        if (bonds) REQUIRE(answer.broken_bonds > 5);
        REQUIRE(answer.friction_dissipation > 0);
        const double turned_over = std::abs(answer.work) + answer.friction_dissipation;
        INFO("bonds " << bonds << ", fluctuation " << fluctuation << ", damping " << damping);
        // Opening, closing and breaking happen somewhere within a sub-step: the rest of the ledger's error. A tenth of a
        // percent at the usual step (a quarter of the critical one).
        CHECK(std::abs(samples::ledger_error(start, answer)) < 1e-3 * turned_over);
        return std::abs(samples::ledger_error(start, answer)) / turned_over;
    };
    for (bool bonds : {false, true})
        for (bool fluctuation : {false, true})
            for (double damping : {0.0, 0.2}) CHECK(error(bonds, fluctuation, damping, 8) < 1e-4);
    error(true, true, 0.2, 1);
    error(false, false, 0.2, 1);
}

TEST_CASE("a gas of discs without contacts is heated by compression as its kinetic stress says", "[energy][eq49]") {
    RveParameters parameters;
    parameters.fluctuation_stress = true;
    parameters.damping = 0;
    Packing packing = samples::lattice(4, -3.0); // far apart
    packing.velocity_x = {0.1, -0.1, 0.1, -0.1};
    packing.velocity_y = {0, 0, 0, 0};
    packing.spin = {0, 0, 0, 0};
    Farm farm(parameters, {packing}, {0});
    const Answer start = farm.measure(0);
    Answer answer;
    double pressure_work = 0, before = start.stress[0];
    for (int k = 0; k < 100; ++k) {
        answer = samples::step(farm, {-1e-3, 0, 0, 0}, 1e-4, 100); // along x by 10 %
        // V sigma : D dt of the macro step, from the answers alone; V = area times thickness.
        pressure_work += -1e-3 * (before * answer.cell_area * std::exp(1e-3) + answer.stress[0] * answer.cell_area) / 2 * 0.1;
        before = answer.stress[0];
    }
    REQUIRE(answer.contacts == 0);
    // dv/dt = -D v: v_x grows as exp(0.1), its energy as exp(0.2), to first order in the strain of a sub-step (1e-5).
    CHECK(answer.kinetic_energy / start.kinetic_energy == Approx(std::exp(0.2)).epsilon(1e-5));
    CHECK(std::abs(samples::ledger_error(start, answer)) < 1e-12 * answer.work);
    CHECK(answer.work == Approx(pressure_work).epsilon(1e-4)); // the trapezoid over a macro step
}
