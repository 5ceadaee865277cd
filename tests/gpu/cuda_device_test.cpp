// The file that talks to GPUs, against a stand-in for the CUDA runtime.
#include "common/base/error.hpp"
#include "tests/gpu/stand_in_runtime.hpp"
#include "tests/rve-farm/block/block_suite.hpp"
#include "tests/rve-farm/block/emulated_device.hpp"
#include "tests/support/text.hpp"

using namespace talik;
using namespace talik::farm;
using stand_in::Machine;

namespace {

block_suite::Devices gpus_of(const Machine& machine) {
    stand_in::set(machine);
    block_suite::Devices devices = open_gpus().devices;
    REQUIRE(static_cast<int>(devices.size()) == machine.gpus);
    return devices;
}

// From nothing to a state that was computed, seen, changed and computed on.
void use_a_gpu() {
    const Gpus gpus = open_gpus();
    if (gpus.devices.empty()) fail(ExitCode::out_of_resource, gpus.reason, "-");
    Farm farm = block_suite::farm_on(gpus.devices, block_suite::parameters(true, false), {samples::disordered(40), samples::disordered(64)}, Precision::single_);
    block_suite::step_all(farm, 1, 1e-3, 20);
    farm.assembly(1);
    block_suite::step_all(farm, 1, 1e-3, 20);
}

} // namespace

TEST_CASE("whenever the streams of a GPU do their work, the bits are the same", "[gpu-calls]") {
    for (Precision precision : {Precision::single_, Precision::double_}) {
        const auto expected = block_suite::state_after({std::make_shared<EmulatedDevice>()}, precision);
        for (stand_in::Pace pace : {stand_in::Pace::late, stand_in::Pace::at_once, stand_in::Pace::at_random})
            for (int gpus : {1, 3}) {
                Machine machine;
                machine.pace = pace;
                machine.gpus = gpus;
                CHECK(block_suite::state_after(gpus_of(machine), precision) == expected);
            }
    }
}

TEST_CASE("copies to and from a GPU go by page-locked memory, and all that was taken is given back", "[gpu-calls]") {
    for (stand_in::Pace pace : {stand_in::Pace::late, stand_in::Pace::at_random}) {
        Machine machine;
        machine.pace = pace;
        block_suite::check_that_state_comes_and_goes(gpus_of(machine));
        CHECK(stand_in::copies_of_other_memory() == 0);
        CHECK(stand_in::bytes_taken() == 0);
    }
}

TEST_CASE("every call of the CUDA runtime that fails is one line that names the GPU and what was being done, and exit code 4", "[gpu-calls][errors]") {
    stand_in::set({});
    use_a_gpu();
    const int calls = stand_in::calls();
    REQUIRE(calls > 100);
    int unnoticed = 0;
    for (bool lost : {false, true})
        for (int call = 0; call < calls; ++call) {
            Machine machine;
            machine.failing_call = call;
            machine.lost = lost;
            machine.error = lost ? cudaErrorLaunchFailure : cudaErrorMemoryAllocation;
            stand_in::set(machine);
            bool failed = false;
            try {
                use_a_gpu();
            } catch (const Error& error) {
                failed = true;
                INFO("call " << call << ", " << stand_in::failed() << ": " << error.what());
                CHECK(error.code() == ExitCode::out_of_resource);
                const std::string text = error.what();
                CHECK(text.find('\n') == std::string::npos);
                CHECK_CONTAINS(text, "GPU");
                CHECK_CONTAINS(text, lost ? "unspecified failure" : "out of memory");
            }
            INFO("call " << call << ", " << stand_in::failed());
            if (failed) continue; // else it gives the GPU back, where nothing need be said
            unnoticed += stand_in::failed() == "cudaSetDevice";
            CHECK((stand_in::failed() == "cudaSetDevice" || stand_in::failed() == "cudaFree" || stand_in::failed() == "cudaFreeHost" || stand_in::failed() == "cudaStreamDestroy"));
        }
    CHECK(unnoticed == 2); // once each: taken into use to be given back
}

TEST_CASE("a machine without a driver, with one that is too old, without GPUs or with old ones says so", "[gpu-calls][errors]") {
    const auto reason = [](const Machine& machine) {
        stand_in::set(machine);
        const Gpus gpus = open_gpus();
        CHECK(gpus.devices.empty());
        return gpus.reason;
    };
    Machine machine;
    machine.driver = 0;
    CHECK_CONTAINS(reason(machine), "no NVIDIA driver was found");
    machine.driver = 11040;
    CHECK_CONTAINS(reason(machine), "the NVIDIA driver is too old: it is for CUDA 11.4, this program was built with CUDA 13.0");
    machine = {};
    machine.gpus = 0;
    CHECK_CONTAINS(reason(machine), "this machine has no GPU");
    machine = {};
    machine.compute_capability = 7;
    CHECK_CONTAINS(reason(machine), "older than compute capability 8.0");
}

TEST_CASE("a GPU that does not answer is left out, and where none is left or there is too little memory --backend auto takes the CPU", "[gpu-calls][errors]") {
    Machine machine;
    machine.gpus = 3;
    stand_in::set(machine);
    open_gpus();
    const int calls = stand_in::calls() / 3;
    machine.failing_call = calls + 4; // of the second
    stand_in::set(machine);
    CHECK(open_gpus().devices.size() == 2);
    FarmOptions options;
    options.backend = Backend::automatic;
    options.threads = 1;
    const auto on_gpu = [&](const Machine& now) {
        stand_in::set(now);
        Farm farm(RveParameters(), {samples::disordered(31)}, std::vector<int>(8, 0), options);
        block_suite::step_all(farm, 1, 1e-3, 10);
        return farm.on_gpu();
    };
    CHECK(on_gpu({}));
    machine = {};
    machine.failing_call = 4;
    CHECK_FALSE(on_gpu(machine));
    machine = {};
    machine.memory = 100000;
    CHECK_FALSE(on_gpu(machine));
    stand_in::set({});
}

TEST_CASE("a GPU with too little memory is refused before anything is taken, with the figure needed", "[gpu-calls][errors]") {
    Machine machine;
    machine.memory = 1000000;
    const block_suite::Devices devices = gpus_of(machine);
    const std::size_t before = stand_in::bytes_taken();
    try {
        block_suite::farm_on(devices, block_suite::parameters(false, false), {samples::disordered(2000)}, Precision::single_);
        FAIL("accepted");
    } catch (const Error& error) {
        CHECK(error.code() == ExitCode::out_of_resource);
        CHECK_CONTAINS(error.what(), "1 RVEs of up to 2000 discs need ");
        CHECK_CONTAINS(error.what(), "of the memory of GPU 0 (Stand-in), which has 1 MiB left");
    }
    CHECK(stand_in::bytes_taken() == before);
}
