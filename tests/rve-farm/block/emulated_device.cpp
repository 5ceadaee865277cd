#include "tests/rve-farm/block/emulated_device.hpp"

#include <barrier>
#include <cstring>
#include <numeric>
#include <thread>
#include <utility>

#include "common/base/error.hpp"
#include "rve-farm/block/run_block.hpp"
#include "rve-farm/block/visit_block_physics.hpp"

namespace talik::farm {
namespace {

// One thread of a block.
class RealThread {
public:
    RealThread(int me, int threads, std::barrier<>& barrier, int left_out) : me_(me), threads_(threads), barrier_(barrier), left_out_(left_out) {}
    int threads() const { return threads_; }

    template <class T>
    class Privates {
    public:
        explicit Privates(const RealThread&) {}
        T& operator()(int) { return value_; }

    private:
        T value_{};
    };

    template <class Body>
    void phase(Body&& body) const {
        body(me_);
        if (phase_++ != left_out_) barrier_.arrive_and_wait();
    }

private:
    int me_, threads_;
    std::barrier<>& barrier_;
    int left_out_;
    mutable int phase_ = 0;
};

} // namespace

std::byte* EmulatedDevice::allocate(std::size_t bytes, const std::string&) {
    memory_.push_back(std::make_unique_for_overwrite<std::byte[]>(bytes + 256));
    const auto address = reinterpret_cast<std::uintptr_t>(memory_.back().get());
    return memory_.back().get() + (256 - address % 256) % 256;
}
void EmulatedDevice::copy_in(int, std::byte* device, const std::byte* host, std::size_t bytes) { std::memcpy(device, host, bytes); }
void EmulatedDevice::copy_out(int, std::byte* host, const std::byte* device, std::size_t bytes) { std::memcpy(host, device, bytes); }

void EmulatedDevice::launch(int, const BlockLaunch& launch) {
    ensure(launch.shared_bytes <= options_.shared_bytes_of_a_block && launch.threads % 32 == 0);
    ++launches_;
    std::vector<int> order(static_cast<std::size_t>(launch.blocks));
    std::iota(order.begin(), order.end(), 0);
    std::uint64_t draw = options_.seed;
    for (std::size_t i = order.size(); i > 1; --i) {
        draw = draw * 6364136223846793005u + 1442695040888963407u;
        std::swap(order[i - 1], order[(draw >> 33) % i]);
    }
    const BlockSource source{launch.rves, launch.tasks, launch.results};
    const std::size_t granted = (launch.shared_bytes + 15) / 16 * 16;
    visit_block_physics(launch, [&]<class Real>(auto ledger, auto spread, const auto& physics, Real) {
        for (const int block : order) {
            const std::unique_ptr<std::byte[]> shared(new std::byte[granted]); // exactly, for the address sanitizer
            std::memset(shared.get(), 0xff, granted); // no numbers
            const auto run = [&](const auto& team) {
                run_block<decltype(ledger)::value, decltype(spread)::value, Real>(team, source, block, physics, contact_law_of(*launch.parameters), shared.get(), launch.shared_bytes);
            };
            if (!options_.real_threads) {
                run(CpuBlockTeam(launch.threads, options_.seed + static_cast<std::uint64_t>(block)));
                continue;
            }
            std::barrier<> barrier(launch.threads);
            std::vector<std::jthread> threads;
            for (int me = 0; me < launch.threads; ++me)
                threads.emplace_back([&, me] { run(RealThread(me, launch.threads, barrier, options_.barrier_left_out)); });
        }
    });
}

} // namespace talik::farm
