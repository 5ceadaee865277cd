#pragma once
// What any device that runs blocks has to fulfil: an emulated one on every machine, a GPU where there is one (tests/gpu).
#include <functional>
#include <memory>
#include <vector>

#include "tests/support/catch.hpp"
#include "tests/support/rve_samples.hpp"

namespace talik::farm::block_suite {

using Devices = std::vector<std::shared_ptr<Device>>;

inline RveParameters parameters(bool bonds, bool fluctuation, double damping = 0.2) {
    RveParameters p;
    p.damping = damping;
    p.fluctuation_stress = fluctuation;
    if (bonds) p.bond = BondParameters{2e6, 2e6, 1.0}; // weak: some break on the way
    return p;
}

// Without devices: the plain kernel.
inline Farm farm_on(const Devices& devices, const RveParameters& p, const std::vector<Packing>& packings, Precision precision, bool ledger = true, int threads = 2) {
    FarmOptions options;
    options.devices = devices;
    options.level = Level::plain;
    options.precision = precision;
    options.ledger = ledger;
    options.threads = threads;
    std::vector<int> each(packings.size());
    for (std::size_t k = 0; k < each.size(); ++k) each[k] = static_cast<int>(k);
    Farm farm(p, packings, each, options);
    if (p.bond) farm.activate_bonds();
    return farm;
}

// The same increments for all RVEs, with a factor that differs from one to the next.
inline std::vector<Answer> step_all(Farm& farm, double scale, double time_increment, int substeps) {
    std::vector<std::uint32_t> ids;
    std::vector<double> increments, ice;
    for (int id = 0; id < farm.size(); ++id) {
        const double own = scale * (1 + 0.1 * id);
        ids.push_back(static_cast<std::uint32_t>(id));
        for (double g : {-5e-5, 2e-4, -1e-4, 3e-5}) increments.push_back(own * g);
        ice.push_back(1.0);
    }
    std::vector<Answer> answers(ids.size());
    farm.advance(ids, increments, ice, time_increment, substeps, answers);
    return answers;
}

inline double difference(const Answer& a, const Answer& b) {
    double largest = 0;
    for (std::size_t k = 0; k < 3; ++k) largest = std::max(largest, std::abs(a.stress[k] - b.stress[k]));
    return largest;
}

// Three macro steps of 50 sub-steps of a heap that is far from rest: in single each from the state of the plain kernel, within 1e-6
// of the pressure. In double each likewise, within 1e-12 per macro step, and a digit more for what contacts that open and slide make
// of rounding in 50 sub-steps (as in kernel_test.cpp).
inline void check_against_plain(const Devices& devices, const std::vector<int>& sizes) {
    for (int discs : sizes)
        for (bool bonds : {false, true})
            for (bool fluctuation : {false, true})
                for (Precision precision : {Precision::single_, Precision::double_}) {
                    const bool is_double = precision == Precision::double_, ledger = discs != 31;
                    const std::vector<Packing> packing = {samples::disordered(discs)};
                    const RveParameters p = parameters(bonds, fluctuation);
                    Farm plain = farm_on({}, p, packing, Precision::double_, ledger), farm = farm_on(devices, p, packing, precision, ledger);
                    REQUIRE(farm.on_gpu());
                    const double pressure = std::abs(samples::mean_pressure(plain.measure(0))) + 1e3; // one disc alone has none
                    for (int k = 0; k < 3; ++k) {
                        std::vector<std::byte> state;
                        plain.save(0, state);
                        farm.load(0, state);
                        const Answer expected = step_all(plain, 1, 5e-4, 50)[0], answer = step_all(farm, 1, 5e-4, 50)[0];
                        INFO(discs << " discs, bonds " << bonds << ", fluctuation " << fluctuation << ", " << name_of(precision) << ", step " << k);
                        REQUIRE(answer.status == Status::ok);
                        CHECK(difference(answer, expected) < (is_double ? 5e-12 : 1e-6) * pressure);
                        CHECK(answer.bonds == expected.bonds);
                        CHECK(answer.stiffness == Approx(expected.stiffness).epsilon(1e-4)); // a contact more or less in single
                        CHECK(answer.cell_area == Approx(expected.cell_area).epsilon(1e-14));
                        const double energy = (is_double ? 1e-9 : 1e-4) * (expected.stored_energy + expected.kinetic_energy + 1e-9);
                        CHECK(std::abs(answer.kinetic_energy - expected.kinetic_energy) < energy);
                        CHECK(std::abs(answer.work - expected.work) < energy);
                        CHECK(std::abs(answer.friction_dissipation - expected.friction_dissipation) < energy);
                        CHECK(std::abs(answer.damping_dissipation - expected.damping_dissipation) < energy);
                        CHECK(std::abs(answer.bond_dissipation - expected.bond_dissipation) < energy);
                    }
                }
}

// A settled assembly, sheared as slowly as in a simulation (ten macro steps of 100 sub-steps, 1e-6 of strain each): here few contacts
// open or slide, and nothing multiplies the rounding of the sums. Returns the largest difference of a macro step from the same state, as a
// part of the pressure.
inline double largest_difference_of_slow_shear(const Devices& devices, Precision precision) {
    const std::vector<Packing> packing = {samples::disordered(400)};
    const RveParameters p = parameters(false, false, 0.7);
    Farm plain = farm_on({}, p, packing, Precision::double_), farm = farm_on(devices, p, packing, precision);
    const auto at_rest = samples::mean_pressure(step_all(plain, 0, 0.2, 20000)[0]);
    double largest = 0;
    for (int k = 0; k < 10; ++k) {
        std::vector<std::byte> state;
        plain.save(0, state);
        farm.load(0, state);
        const Answer expected = step_all(plain, 0.005, 1e-3, 100)[0], answer = step_all(farm, 0.005, 1e-3, 100)[0];
        REQUIRE(answer.status == Status::ok);
        largest = std::max(largest, difference(answer, expected) / at_rest);
    }
    return largest;
}

// The state of some RVEs of three sizes after steps that spend several lists.
inline std::vector<std::byte> state_after(const Devices& devices, Precision precision, int steps = 6) {
    std::vector<Packing> packings;
    for (int k = 0; k < 5; ++k) packings.push_back(samples::disordered(40 + 37 * (k % 3), static_cast<std::uint64_t>(k + 1)));
    Farm farm = farm_on(devices, parameters(true, true), packings, precision);
    for (int k = 0; k < steps; ++k)
        for (const Answer& answer : step_all(farm, 10, 1e-3, 100)) REQUIRE(answer.status == Status::ok);
    std::vector<std::byte> bytes;
    for (int id = 0; id < farm.size(); ++id) farm.save(id, bytes);
    REQUIRE(farm.assembly(0).numbers().rebuilds > 2);
    return bytes;
}

// What is saved and loaded elsewhere, or seen and touched on the way, goes on to the same bits.
inline void check_that_state_comes_and_goes(const Devices& devices) {
    const std::vector<Packing> packings = {samples::disordered(64), samples::disordered(100)};
    const auto fresh = [&] { return farm_on(devices, parameters(true, false), packings, Precision::single_); };
    Farm straight = fresh(), seen = fresh(), loaded = fresh();
    for (int k = 0; k < 2; ++k) {
        step_all(straight, 3, 1e-3, 100);
        step_all(seen, 3, 1e-3, 100);
        seen.assembly(1); // fetched, and sent again
        seen.measure(0);
    }
    std::vector<std::byte> bytes;
    for (int id = 0; id < 2; ++id) straight.save(id, bytes);
    std::size_t used = 0;
    for (int id = 0; id < 2; ++id) used += loaded.load(id, std::span(bytes).subspan(used));
    for (Farm* farm : {&straight, &seen, &loaded}) step_all(*farm, 3, 1e-3, 100);
    for (int id = 0; id < 2; ++id) {
        CHECK(samples::same_bits(straight, id, seen, id));
        CHECK(samples::same_bits(straight, id, loaded, id));
    }
    seen.reset_velocities(0);
    seen.set_friction(0);
    step_all(straight, 3, 1e-3, 100);
    step_all(seen, 3, 1e-3, 100);
    CHECK_FALSE(samples::same_bits(straight, 0, seen, 0));
}

// A disc that outruns the list: the chunk is taken again on fresh ones, with the response of a wide list.
inline void check_that_outrun_lists_are_made_anew(const Devices& devices) {
    const auto thrown = [&](double skin) {
        RveParameters p;
        p.skin = skin;
        Farm farm = farm_on(devices, p, {samples::disordered(64)}, Precision::double_);
        farm.assembly(0).view().velocity_x[5] = 1.0; // m/s: 1 mm in the macro step
        const Answer answer = samples::step(farm, {0, 0, 0, 0}, 1e-3, 100);
        REQUIRE(answer.status == Status::ok);
        return std::pair(answer, std::as_const(farm).assembly(0).numbers());
    };
    const auto [narrow, numbers] = thrown(5e-5);
    const auto [wide, others] = thrown(3e-3);
    CHECK(numbers.rebuilds > others.rebuilds + 2);
    CHECK(numbers.retaken_chunks > 0);
    CHECK(difference(narrow, wide) < 1e-9 * samples::mean_pressure(wide)); // a missed contact would show as 1e-3 and more
}

} // namespace talik::farm::block_suite
