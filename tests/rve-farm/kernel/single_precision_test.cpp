// Float in displacement form against double: the increments of a slow thaw are 1e-7 of a branch per macro step and less.
#include <cmath>

#include "tests/support/catch.hpp"
#include "tests/support/rve_samples.hpp"

using namespace talik;
using namespace talik::farm;

namespace {

Farm farm_of(Precision precision, int discs) {
    FarmOptions options;
    options.precision = precision;
    options.threads = 1;
    RveParameters p;
    Farm farm(p, {samples::disordered(discs)}, {0}, options);
    return farm;
}

// A settled state, the same for both precisions: they part from bits, not from a heap in motion.
std::vector<std::byte> settled(int discs) {
    RveParameters p;
    p.damping = 0.7;
    Farm farm = Farm(p, {samples::disordered(discs)}, {0});
    for (int k = 0; k < 300; ++k) samples::step(farm, {0, 0, 0, 0}, 1e-3, 100);
    farm.reset_velocities(0);
    std::vector<std::byte> bytes;
    farm.save(0, bytes);
    return bytes;
}

double difference(const Answer& a, const Answer& b) {
    double largest = 0;
    for (std::size_t k = 0; k < 3; ++k) largest = std::max(largest, std::abs(a.stress[k] - b.stress[k]));
    return largest;
}

} // namespace

TEST_CASE("single precision: each macro step is within 1e-6 of the pressure of double's from the same state", "[kernel][single]") {
    Farm single = farm_of(Precision::single_, 100), twice = farm_of(Precision::double_, 100);
    const auto start = settled(100);
    single.load(0, start);
    twice.load(0, start);
    for (double rate : {1e-4, 1e-2, 1.0})
        for (int k = 0; k < 30; ++k) {
            std::vector<std::byte> bytes;
            twice.save(0, bytes);
            single.load(0, bytes);
            const Answer a = samples::step(single, {0, rate * 1e-3, 0, 0}, 1e-3, 100), b = samples::step(twice, {0, rate * 1e-3, 0, 0}, 1e-3, 100);
            INFO("rate " << rate << ", macro step " << k);
            CHECK(difference(a, b) < 1e-6 * samples::mean_pressure(b));
        }
}

TEST_CASE("single precision: after 10,000 macro steps at 1e-4 1/s the stress is within 1e-6 of the pressure of double's", "[kernel][single]") {
    Farm single = farm_of(Precision::single_, 100), twice = farm_of(Precision::double_, 100);
    const auto start = settled(100);
    single.load(0, start);
    twice.load(0, start);
    const Answer before = twice.measure(0);
    Answer a, b;
    double worst = 0;
    for (int k = 0; k < 10000; ++k) { // 0.1 % of simple shear
        a = samples::step(single, {0, 1e-7, 0, 0}, 1e-3, 100);
        b = samples::step(twice, {0, 1e-7, 0, 0}, 1e-3, 100);
        worst = std::max(worst, difference(a, b));
    }
    const double pressure = samples::mean_pressure(b);
    WARN("largest difference on the way " << worst / pressure << ", at the end " << difference(a, b) / pressure << " of the pressure");
    CHECK(difference(a, before) > 1e-3 * pressure); // the stress has moved
    CHECK(difference(a, b) < 1e-6 * pressure);
}
