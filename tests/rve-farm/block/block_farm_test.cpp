#include "rve-farm/block/block_farm.hpp"

#include <fmt/format.h>

#include "common/base/error.hpp"
#include "rve-farm/block/block_work.hpp"
#include "tests/rve-farm/block/block_suite.hpp"
#include "tests/rve-farm/block/emulated_device.hpp"
#include "tests/support/text.hpp"

using namespace talik;
using namespace talik::farm;

namespace {

std::shared_ptr<EmulatedDevice> emulated(std::uint64_t seed = 1, std::size_t shared_bytes = 227 * 1024) {
    EmulatedDevice::Options options;
    options.seed = seed;
    options.shared_bytes_of_a_block = shared_bytes;
    return std::make_shared<EmulatedDevice>(options);
}

// As a GPU that falls off its bus, when so many launches are done.
class LostDevice : public EmulatedDevice {
public:
    int launches_left = 1000000;
    void launch(int stream, const BlockLaunch& launch) override {
        if (launches_left-- <= 0) fail(ExitCode::out_of_resource, "GPU 0: computing failed: unspecified launch failure", "go on from the last checkpoint");
        EmulatedDevice::launch(stream, launch);
    }
};

// Counts what is copied back.
class WatchedDevice : public EmulatedDevice {
public:
    std::size_t bytes_out = 0;
    void copy_out(int stream, std::byte* host, const std::byte* device, std::size_t bytes) override {
        bytes_out += bytes;
        EmulatedDevice::copy_out(stream, host, device, bytes);
    }
};

} // namespace

TEST_CASE("a block in scrambled order gives the stress of the plain kernel, at every size and with every effect", "[block][kernel][eq5][eq49]") {
    block_suite::check_against_plain({emulated(7)}, {1, 31, 33, 127, 400});
}

TEST_CASE("slow shear of a settled assembly: a block is within 1e-12 of the pressure of the plain kernel in double, 1e-6 in single", "[block][kernel][eq49]") {
    for (const auto& [precision, bound] : {std::pair(Precision::double_, 1e-12), std::pair(Precision::single_, 1e-6)}) {
        const double largest = block_suite::largest_difference_of_slow_shear({emulated()}, precision);
        INFO(name_of(precision) << ": " << fmt::format("{:.1e}", largest));
        CHECK(largest < bound);
    }
}

TEST_CASE("no bit depends on the order of blocks and threads, nor on the number of devices", "[block][team]") {
    for (Precision precision : {Precision::single_, Precision::double_}) {
        const auto expected = block_suite::state_after({emulated(1)}, precision);
        CHECK(block_suite::state_after({emulated(77)}, precision) == expected);
        CHECK(block_suite::state_after({emulated(3), emulated(4), emulated(5)}, precision) == expected);
    }
}

TEST_CASE("an RVE that does not fit into shared memory gives the same with part of its working memory elsewhere", "[block]") {
    CHECK(block_suite::state_after({emulated(1, 26000)}, Precision::double_, 2) == block_suite::state_after({emulated(1)}, Precision::double_, 2));
    block_suite::check_against_plain({emulated(5, 80 * 1024)}, {700});
}

TEST_CASE("the state of RVEs on a device can be seen, changed, saved and loaded", "[block]") { block_suite::check_that_state_comes_and_goes({emulated()}); }

TEST_CASE("the numbers of an RVE on a device are at hand without copying it back", "[block]") {
    const auto gpu = std::make_shared<WatchedDevice>();
    const std::vector<Packing> packings = {samples::disordered(64), samples::disordered(100)};
    Farm farm = block_suite::farm_on({gpu}, block_suite::parameters(true, false), packings, Precision::single_);
    block_suite::step_all(farm, 1, 1e-3, 100);
    const std::size_t before = gpu->bytes_out;
    for (int id = 0; id < farm.size(); ++id) CHECK(farm.numbers(id).disc_count == static_cast<int>(packings[static_cast<std::size_t>(id)].x.size()));
    CHECK(gpu->bytes_out == before);
    block_suite::step_all(farm, 1, 1e-3, 100);
    CHECK(gpu->bytes_out - before < 4096); // sums and numbers, not discs: 164 of them have some 20 kB
}

TEST_CASE("a block whose disc outruns the list is taken again on a fresh one, with the response of a wide list", "[block][neighbours]") {
    block_suite::check_that_outrun_lists_are_made_anew({emulated()});
}

TEST_CASE("a multiprocessor is filled with warps, whatever the size of RVEs", "[block]") {
    const auto gpu = emulated();
    const auto check = [&](int discs, Precision precision, int warps_of_a_block, int blocks) {
        const int groups = (discs + 31) / 32, candidates = 85 * discs / 40; // as in `rve-farm bench`
        const BlockShape shape = shape_of_block(*gpu, precision, false, {groups, candidates, candidates});
        INFO(discs << " discs, " << name_of(precision));
        CHECK_FALSE(shape.spread);
        CHECK(shape.threads == 32 * warps_of_a_block);
        const auto fit = gpu->shared_bytes_of_a_multiprocessor() / (shape.shared_bytes + shared_bytes_of_the_system);
        const int most = (precision == Precision::single_ ? warps_of_a_multiprocessor<float>(false) : warps_of_a_multiprocessor<double>(false)) / warps_of_a_block;
        CHECK(std::min<int>(static_cast<int>(fit), most) == blocks);
    };
    check(400, Precision::single_, 7, 3); // 13 groups in two rounds
    check(1000, Precision::single_, 16, 1);
    check(100, Precision::single_, 2, 11);
    check(400, Precision::double_, 13, 1);
}

TEST_CASE("too little memory on a device is refused with the figure needed", "[block][errors]") {
    EmulatedDevice::Options options;
    options.memory = 1000000;
    try {
        block_suite::farm_on({std::make_shared<EmulatedDevice>(options)}, block_suite::parameters(false, false), {samples::disordered(2000)}, Precision::single_);
        FAIL("accepted");
    } catch (const Error& error) {
        CHECK(error.code() == ExitCode::out_of_resource);
        CHECK_CONTAINS(error.what(), "1 RVEs of up to 2000 discs need ");
        CHECK_CONTAINS(error.what(), "has 1 MiB left");
    }
}

TEST_CASE("a device lost in mid-run is an error, and what was saved before goes on elsewhere to the same bits", "[block][errors]") {
    const std::vector<Packing> packings = {samples::disordered(64)};
    const RveParameters p = block_suite::parameters(true, false);
    Farm sound = block_suite::farm_on({emulated()}, p, packings, Precision::single_);
    const auto gpu = std::make_shared<LostDevice>();
    Farm lost = block_suite::farm_on({gpu}, p, packings, Precision::single_);
    block_suite::step_all(sound, 1, 1e-3, 100);
    block_suite::step_all(lost, 1, 1e-3, 100);
    std::vector<std::byte> saved;
    lost.save(0, saved);
    gpu->launches_left = 1;
    bool failed = false;
    for (int k = 0; k < 5 && !failed; ++k) try {
            block_suite::step_all(lost, 1, 1e-3, 100);
        } catch (const Error& error) {
            failed = true;
            CHECK(error.code() == ExitCode::out_of_resource);
            CHECK_CONTAINS(error.what(), "GPU 0");
        }
    REQUIRE(failed);
    Farm other = block_suite::farm_on({emulated()}, p, packings, Precision::single_);
    other.load(0, saved);
    for (Farm* farm : {&sound, &other}) block_suite::step_all(*farm, 1, 1e-3, 100);
    CHECK(samples::same_bits(sound, 0, other, 0));
}

TEST_CASE("a machine without a GPU says why, and --backend cuda is refused for lack of a resource", "[block][errors]") {
    const Gpus gpus = open_gpus();
    if (!gpus.devices.empty()) return; // what a GPU does: tests/gpu
    CHECK_FALSE(gpus.reason.empty());
    FarmOptions options;
    options.backend = Backend::cuda;
    try {
        Farm(RveParameters(), {samples::disordered(9)}, {0}, options);
        FAIL("accepted");
    } catch (const Error& error) {
        CHECK(error.code() == ExitCode::out_of_resource);
        CHECK_CONTAINS(error.what(), gpus.reason);
    }
    options.backend = Backend::automatic;
    CHECK_FALSE(Farm(RveParameters(), {samples::disordered(9)}, std::vector<int>(200, 0), options).on_gpu());
}
