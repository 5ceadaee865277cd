// What the host does for an RVE in a macro step when its state is on a device, with a list that holds and with one that is spent:
// the device here takes no time and answers what it answered first. For docs/performance.md.
#include <fmt/core.h>

#include <chrono>
#include <cstring>

#include "tests/rve-farm/block/block_suite.hpp"
#include "tests/rve-farm/block/emulated_device.hpp"

using namespace talik;
using namespace talik::farm;

namespace {

class HollowDevice : public EmulatedDevice {
public:
    std::vector<BlockResult> first; // by RVE
    bool hollow = false, spends_lists = false;

    void launch(int stream, const BlockLaunch& launch) override {
        if (!hollow) EmulatedDevice::launch(stream, launch);
        for (int k = 0; k < launch.blocks; ++k) {
            const auto rve = static_cast<std::size_t>(launch.tasks[k].rve);
            if (first.size() <= rve) first.resize(rve + 1);
            (hollow ? launch.results[k] : first[rve]) = hollow ? first[rve] : launch.results[k];
            if (spends_lists) launch.results[k].sums.discs.largest_drift_squared = 1;
        }
    }
};

} // namespace

TEST_CASE("what the host does in a macro step", "[.host-cost]") {
    constexpr int steps = 30;
    const auto step = [](Farm& farm) {
        const auto begin = std::chrono::steady_clock::now();
        block_suite::step_all(farm, 1e-6, 1e-3, 100);
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    };
    // Least time of a step, s.
    const auto least = [&](const std::vector<Packing>& packings, int rves, int threads, bool lists) {
        const auto gpu = std::make_shared<HollowDevice>();
        FarmOptions options;
        options.devices = {gpu};
        options.precision = Precision::single_;
        options.threads = threads;
        std::vector<int> packing_of;
        for (int k = 0; k < rves; ++k) packing_of.push_back(k % static_cast<int>(packings.size()));
        Farm farm(block_suite::parameters(false, false), packings, packing_of, options);
        step(farm); // the first goes through the host
        gpu->spends_lists = lists;
        step(farm);
        gpu->hollow = true;
        double seconds = 1e9;
        for (int k = 0; k < steps; ++k) seconds = std::min(seconds, step(farm));
        return seconds;
    };
    std::vector<Packing> packings; // in no order: what bins hold cannot be foreseen
    for (unsigned seed = 0; seed < 32; ++seed) {
        packings.push_back(samples::disordered(400, seed));
        Packing& packing = packings.back();
        for (std::size_t i = packing.x.size() - 1; i > 0; --i) {
            const std::size_t j = (i * 7919 + 104729 * (seed + 1)) % (i + 1);
            std::swap(packing.x[i], packing.x[j]), std::swap(packing.y[i], packing.y[j]), std::swap(packing.radius[i], packing.radius[j]);
        }
    }
    for (int threads : {1, 2}) {
        fmt::print("host: {} threads, {:.3f} us for an RVE in a macro step\n", threads, 1e6 * least({samples::disordered(31)}, 20000, threads, false) / 20000);
        fmt::print("host: {} threads, {:.1f} us for the list of an RVE of 400 discs\n", threads, 1e6 * least(packings, 256, threads, true) / 256);
    }
}
