// The program of a block with all its threads at work at once, as on a GPU. By itself it compares bits; built with the thread
// sanitizer (tools/check-races) it is what a race check on a GPU would be: every access of every thread, and nothing but barriers
// between them.
#include <cstdlib>
#include <string>

#include "tests/rve-farm/block/block_suite.hpp"
#include "tests/rve-farm/block/emulated_device.hpp"

using namespace talik;
using namespace talik::farm;

namespace {

std::shared_ptr<EmulatedDevice> device(bool real_threads, int barrier_left_out = -1, std::size_t shared_bytes = 227 * 1024) {
    EmulatedDevice::Options options;
    options.real_threads = real_threads;
    options.barrier_left_out = barrier_left_out;
    options.shared_bytes_of_a_block = shared_bytes;
    return std::make_shared<EmulatedDevice>(options);
}

// After some sub-steps of RVEs of 40 and 100 discs, a thread to a disc and less.
std::vector<std::byte> state(const std::shared_ptr<EmulatedDevice>& device, bool bonds, bool fluctuation, bool ledger, Precision precision) {
    Farm farm = block_suite::farm_on({device}, block_suite::parameters(bonds, fluctuation), {samples::disordered(40), samples::disordered(100)}, precision, ledger, 1);
    for (const Answer& answer : block_suite::step_all(farm, 1, 4e-5, 4)) REQUIRE(answer.status == Status::ok);
    std::vector<std::byte> bytes;
    for (int id = 0; id < farm.size(); ++id) farm.save(id, bytes);
    return bytes;
}

} // namespace

TEST_CASE("the threads of a block at work at once come to the same bits, with every effect", "[block][team][threads]") {
    for (bool bonds : {false, true})
        for (bool fluctuation : {false, true})
            for (bool ledger : {false, true})
                for (Precision precision : {Precision::single_, Precision::double_}) {
                    INFO("bonds " << bonds << ", fluctuation " << fluctuation << ", ledger " << ledger << ", " << name_of(precision));
                    CHECK(state(device(true), bonds, fluctuation, ledger, precision) == state(device(false), bonds, fluctuation, ledger, precision));
                }
    const auto spread = device(true, -1, 34000); // memory that is not shared
    CHECK(state(spread, true, true, true, Precision::double_) == state(device(false), true, true, true, Precision::double_));
}

// For the thread sanitizer, which has to find it.
TEST_CASE("a barrier of the block's program is left out", "[.planted]") {
    const auto faulty = device(true, std::stoi(std::getenv("TALIK_BARRIER")));
    Farm farm = block_suite::farm_on({faulty}, block_suite::parameters(false, false), {samples::disordered(100)}, Precision::single_, true, 1);
    block_suite::step_all(farm, 1, 4e-5, 4);
    SUCCEED();
}
