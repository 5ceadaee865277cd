// What the host does for an RVE in a macro step, when its state is on a device and its list holds: the device here takes no time and
// answers what it answered first. For docs/performance.md.
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
    bool hollow = false;

    void launch(int stream, const BlockLaunch& launch) override {
        if (!hollow) EmulatedDevice::launch(stream, launch);
        for (int k = 0; k < launch.blocks; ++k) {
            const auto rve = static_cast<std::size_t>(launch.tasks[k].rve);
            if (first.size() <= rve) first.resize(rve + 1);
            (hollow ? launch.results[k] : first[rve]) = hollow ? first[rve] : launch.results[k];
        }
    }
};

} // namespace

TEST_CASE("what the host does in a macro step", "[.host-cost]") {
    constexpr int rves = 20000, steps = 30;
    for (int threads : {1, 2}) {
        const auto gpu = std::make_shared<HollowDevice>();
        FarmOptions options;
        options.devices = {gpu};
        options.precision = Precision::single_;
        options.threads = threads;
        Farm farm(block_suite::parameters(false, false), {samples::disordered(31)}, std::vector<int>(rves, 0), options);
        block_suite::step_all(farm, 1e-6, 1e-3, 100); // the first goes through the host
        block_suite::step_all(farm, 1e-6, 1e-3, 100);
        gpu->hollow = true;
        double least = 1e9;
        for (int k = 0; k < steps; ++k) {
            const auto begin = std::chrono::steady_clock::now();
            block_suite::step_all(farm, 1e-6, 1e-3, 100);
            least = std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
        }
        fmt::print("host: {} threads, {:.3f} us for an RVE in a macro step\n", threads, 1e6 * least / rves);
    }
}
