#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <functional>

#include "rve-farm/block/block_image.hpp"
#include "rve-farm/block/run_block.hpp"
#include "rve-farm/physics/physics_choice.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/rve_samples.hpp"

using namespace talik;
using namespace talik::farm;

namespace {

// A block in which one barrier is missing: at the end of the given phase some threads are late, and do its work when others are in
// the next phase already.
class LosingTeam : public CpuBlockTeam {
public:
    LosingTeam(int threads, std::uint64_t seed, int lost_phase) : CpuBlockTeam(threads, seed), lost_(lost_phase) {}

    template <class Body>
    void phase(Body&& body) const {
        scramble();
        const std::size_t half = order_.size() / 2;
        if (now_ == lost_) {
            const std::vector<int> late(order_.begin() + static_cast<std::ptrdiff_t>(half), order_.end());
            for (std::size_t k = 0; k < half; ++k) body(order_[k]);
            held_back_ = [body, late] {
                for (int thread : late) body(thread);
            };
        } else if (held_back_) {
            for (std::size_t k = 0; k < half; ++k) body(order_[k]);
            held_back_();
            held_back_ = nullptr;
            for (std::size_t k = half; k < order_.size(); ++k) body(order_[k]);
        } else {
            for (int thread : order_) body(thread);
        }
        ++now_;
    }

private:
    int lost_;
    mutable int now_ = 0;
    mutable std::function<void()> held_back_;
};

using Frictional = Physics<NoBond, LocalDamping<double>, NoFluctuation, double>;

// Virial and work after four sub-steps; no number where the block finds that its discs have none.
double virial(std::uint64_t seed, int lost_phase) {
    RveParameters p;
    Assembly rve(p, samples::disordered(127));
    rve.layout().update(rve.view(), block_shape());
    const BlockImage image(rve);
    BlockSize size;
    REQUIRE(image.size_of(rve.layout(), size) == Status::ok);
    std::vector<std::max_align_t> memory(image.bytes() / sizeof(std::max_align_t) + 1);
    const auto device = reinterpret_cast<std::byte*>(memory.data());
    const BlockRve there = image.write(rve, size, device, device);
    BlockTask task;
    task.request.stretch = stretch_of(-1e-5, 4e-5, -2e-5, 1e-5, 0);
    task.request.substeps = 4;
    task.request.sub_step = task.request.first_kick = 1e-5;
    task.request.displacement_allowed = 1;
    task.numbers = rve.numbers();
    const int threads = block_threads(size.groups, 7);
    BlockWork<double> work;
    std::byte* const anywhere = reinterpret_cast<std::byte*>(std::uintptr_t{4096});
    std::vector<std::max_align_t> shared(work.lay_out<false>(size, false, threads, anywhere, 0, anywhere).shared / sizeof(std::max_align_t) + 1);
    BlockResult result;
    const Frictional physics{{p.contact.normal_stiffness, p.contact.tangential_stiffness, p.contact.friction}, {}, {p.damping}, {}};
    run_block<true, false, double>(LosingTeam(threads, seed, lost_phase), BlockSource{&there, &task, &result}, 0, physics, contact_law_of(p), reinterpret_cast<std::byte*>(shared.data()), 0);
    if (!result.accepted) return std::nan("");
    return result.sums.contacts.virial.xx + result.sums.contacts.virial.yy + result.sums.ledger.work;
}

// In a process of its own, since who reads what is not there yet may also walk out of its memory. True: crashed, or came to
// other bits.
bool is_caught(int lost_phase, double sound) {
    const pid_t child = fork();
    REQUIRE(child >= 0);
    if (child == 0) {
        for (int signal : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE}) std::signal(signal, SIG_DFL); // not the test program's own handlers
        _exit(virial(1, lost_phase) == sound ? 0 : 1);
    }
    int status = 0;
    REQUIRE(waitpid(child, &status, 0) == child);
    return !(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

} // namespace

// Phases 0 and 1 load, 2 + 2 k moves discs, 3 + 2 k takes contacts.
TEST_CASE("a barrier left out of the block's program is caught by the scrambled order", "[block][team][planted]") {
    const double sound = virial(1, -1);
    REQUIRE(std::isfinite(sound));
    CHECK(virial(2, -1) == sound);
    CHECK(virial(3, -1) == sound);
    CHECK_FALSE(is_caught(-1, sound));
    for (int lost : {0, 1, 2, 3, 4, 5}) {
        INFO("barrier after phase " << lost);
        CHECK(is_caught(lost, sound));
    }
}
