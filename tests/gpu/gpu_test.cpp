// What a GPU of this machine does. Run by `ctest -L gpu`, and by tools/gpu-check.
#include "rve-farm/block/block_farm.hpp"
#include "rve-farm/block/block_work.hpp"
#include "tests/rve-farm/block/block_suite.hpp"

using namespace talik;
using namespace talik::farm;

namespace {

block_suite::Devices gpus() {
    block_suite::Devices devices = open_gpus().devices;
    REQUIRE_FALSE(devices.empty());
    return devices;
}
block_suite::Devices one() { return {gpus().front()}; }

} // namespace

TEST_CASE("a GPU gives the stress of the plain kernel, at every size and with every effect", "[gpu][eq5][eq49]") {
    block_suite::check_against_plain(one(), {1, 31, 33, 50, 127, 400, 1000, 2000});
}

TEST_CASE("a GPU gives the stress of the plain kernel for small RVEs, under compute-sanitizer too", "[gpu][small]") {
    block_suite::check_against_plain(one(), {31, 64});
}

TEST_CASE("slow shear of a settled assembly: a GPU is within 1e-12 of the pressure of the plain kernel in double, 1e-6 in single", "[gpu][eq49]") {
    CHECK(block_suite::largest_difference_of_slow_shear(one(), Precision::double_) < 1e-12);
    CHECK(block_suite::largest_difference_of_slow_shear(one(), Precision::single_) < 1e-6);
}

TEST_CASE("a GPU gives the same bits every time", "[gpu]") {
    for (Precision precision : {Precision::single_, Precision::double_}) {
        const auto expected = block_suite::state_after(one(), precision);
        for (int again = 0; again < 5; ++again) CHECK(block_suite::state_after(one(), precision) == expected);
    }
}

TEST_CASE("no bit depends on the number of GPUs", "[gpu]") { CHECK(block_suite::state_after(gpus(), Precision::single_) == block_suite::state_after(one(), Precision::single_)); }

TEST_CASE("the state of RVEs on a GPU can be seen, changed, saved and loaded", "[gpu]") { block_suite::check_that_state_comes_and_goes(one()); }

TEST_CASE("a disc that outruns the list makes a GPU take the chunk again, with the response of a wide list", "[gpu][neighbours]") {
    block_suite::check_that_outrun_lists_are_made_anew(one());
}

// Beyond a few per cent of strain no two runs agree; curves of one and the other must be drawn from the same heap of curves: the
// means over 24 packings differ by no more than four standard errors of their difference.
TEST_CASE("to large strain the mean strength of many RVEs on a GPU is that on the CPU", "[gpu]") {
    std::vector<Packing> packings;
    for (std::uint64_t k = 1; k <= 24; ++k) packings.push_back(samples::disordered(100, k));
    Farm gpu = block_suite::farm_on(one(), block_suite::parameters(false, false), packings, Precision::single_, false);
    Farm cpu = block_suite::farm_on({}, block_suite::parameters(false, false), packings, Precision::single_, false);
    const auto mean_shear = [](Farm& farm) { // over the second half of 10 % of strain
        std::vector<double> sums(24, 0.0);
        for (int k = 0; k < 500; ++k) {
            const auto answers = block_suite::step_all(farm, 1, 1e-3, 100);
            for (std::size_t i = 0; i < sums.size() && k >= 250; ++i) sums[i] += (answers[i].stress[0] - answers[i].stress[1]) / 500;
        }
        return sums;
    };
    const auto moments = [](const std::vector<double>& v) {
        double mean = 0, square = 0;
        for (double x : v) mean += x / static_cast<double>(v.size());
        for (double x : v) square += (x - mean) * (x - mean) / static_cast<double>(v.size() - 1);
        return std::pair(mean, square / static_cast<double>(v.size())); // of the mean
    };
    const auto [a, va] = moments(mean_shear(gpu));
    const auto [b, vb] = moments(mean_shear(cpu));
    CHECK(std::abs(a - b) < 4 * std::sqrt(va + vb));
}
