// What a sub-step of a block takes of shared memory, counted on its own lists: for tools/gpu-report, and for who changes the layout.
#include <fmt/core.h>

#include <map>
#include <set>

#include "rve-farm/block/block_farm.hpp"
#include "rve-farm/block/block_image.hpp"
#include "rve-farm/block/block_work.hpp"
#include "rve-farm/packing/prepare.hpp"
#include "tests/rve-farm/block/emulated_device.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/rve_samples.hpp"

using namespace talik;
using namespace talik::farm;

namespace {

// Passes through shared memory (CUDA C++ Programming Guide: 32 banks of 4 bytes, a pass serves one word of each; accesses of 16
// bytes go by eight threads at a time, of 8 by sixteen) of an access of `bytes` at each of these addresses.
int wavefronts(const std::vector<std::uintptr_t>& addresses, std::size_t bytes) {
    const std::size_t together = std::min<std::size_t>(32, 128 / bytes);
    int passes = 0;
    for (std::size_t first = 0; first < addresses.size(); first += together) {
        std::map<std::size_t, std::set<std::uintptr_t>> words; // of a bank
        for (std::size_t k = first; k < std::min(addresses.size(), first + together); ++k)
            for (std::uintptr_t word = addresses[k] / 4; word <= (addresses[k] + bytes - 1) / 4; ++word) words[word % 32].insert(word);
        std::size_t most = 0;
        for (const auto& [bank, of_it] : words) most = std::max(most, of_it.size());
        passes += static_cast<int>(most);
    }
    return passes;
}

// Of all pieces of a four.
template <class Real>
int wavefronts_of_fours(const std::vector<int>& slots) {
    using Column = FourColumn<BlockRow<Real>, Real>;
    int passes = 0;
    for (int piece = 0; piece < Column::pieces; ++piece) {
        std::vector<std::uintptr_t> addresses;
        for (int slot : slots) addresses.push_back(16 * static_cast<std::uintptr_t>(Column::index(slot) + 32 * piece));
        passes += wavefronts(addresses, 16);
    }
    return passes;
}

std::vector<int> warp_at(int first) {
    std::vector<int> slots(32);
    std::iota(slots.begin(), slots.end(), first);
    return slots;
}

struct Traffic {
    int groups = 0, warps = 0, contact_rows = 0, incoming_rows = 0, wavefronts = 0;
    std::size_t shared_bytes = 0;
};

// As in `rve-farm bench`: settled near 100 kPa, sheared at 0.01 1/s until the skin of the list has been chosen by that.
Farm sheared(int discs) {
    RveSpec spec;
    spec.packing.discs = discs;
    spec.packing.void_ratio = 0.2;
    RveParameters p;
    p.time_step = 1e-5;
    FarmOptions options;
    options.threads = 1;
    Farm farm(p, {prepare_packing(spec, spec.packing.seed)}, {0}, options);
    for (int k = 0; k < 600; ++k) REQUIRE(samples::step(farm, {1e-5, 0, 0, -1e-5}, 1e-3, 100).status == Status::ok);
    return farm;
}

template <class Real>
Traffic traffic_of(Assembly& rve, const EmulatedDevice& gpu, bool bonds, bool ledger) {
    rve.layout().update(rve.view(), block_shape());
    const SlotLayout& layout = rve.layout();
    BlockSize size;
    REQUIRE(BlockImage(rve).size_of(layout, size) == Status::ok);
    const BlockShape shape = shape_of_block(gpu, sizeof(Real) == 4 ? Precision::single_ : Precision::double_, bonds, size);
    Traffic t{layout.groups, shape.threads / 32, layout.contact_slots() / 32, 0, 0, shape.shared_bytes};
    const int own = wavefronts_of_fours<Real>(warp_at(0)), number = static_cast<int>(sizeof(Real)) / 4;
    for (int g = 0; g < layout.groups; ++g) {
        // move_discs: force, motion twice, displacement twice; inverse inertia; where what comes in begins and ends
        t.wavefronts += 5 * own + number + 2;
        for (int m = 0;; ++m) {
            std::vector<int> actions;
            std::vector<std::uintptr_t> indices;
            for (int k = 32 * g; k < 32 * (g + 1); ++k) {
                const auto slot = static_cast<std::size_t>(k);
                if (layout.incoming_begin[slot] + m >= layout.incoming_begin[slot + 1]) continue;
                indices.push_back(2 * static_cast<std::uintptr_t>(layout.incoming_begin[slot] + m));
                actions.push_back(layout.incoming[static_cast<std::size_t>(layout.incoming_begin[slot] + m)] / 4);
            }
            if (actions.empty()) break;
            ++t.incoming_rows;
            t.wavefronts += wavefronts(indices, 2) + wavefronts_of_fours<Real>(actions);
        }
        // step_contacts: displacement, force; where contacts begin and end
        t.wavefronts += 2 * own + 2;
        for (int c = layout.group_begin[static_cast<std::size_t>(g)]; c < layout.group_begin[static_cast<std::size_t>(g) + 1]; c += 32) {
            std::vector<int> partners;
            for (int lane = 0; lane < 32; ++lane) partners.push_back(layout.partner[static_cast<std::size_t>(c + lane)] / 4);
            // partner and its displacement; start, memory twice, action; f_t; bond twice
            t.wavefronts += 1 + wavefronts_of_fours<Real>(partners) + 4 * own + (ledger ? wavefronts(std::vector<std::uintptr_t>{0, 16, 32, 48, 64, 80, 96, 112, 128, 144, 160, 176, 192, 208, 224, 240}, 4) * 2 : 0) +
                            (bonds ? 2 : 0);
        }
    }
    return t;
}

} // namespace

TEST_CASE("a warp fetches fours of its own in whole wavefronts", "[block]") {
    CHECK(wavefronts_of_fours<float>(warp_at(0)) == 4); // 32 times 16 bytes, 128 bytes to a pass
    CHECK(wavefronts_of_fours<float>(warp_at(96)) == 4);
    CHECK(wavefronts_of_fours<double>(warp_at(0)) == 8);
    CHECK(wavefronts_of_fours<double>(warp_at(96)) == 8);
    CHECK(wavefronts_of_fours<float>(std::vector<int>(32, 5)) == 4); // one for all
    std::vector<int> clash;
    for (int lane = 0; lane < 32; ++lane) clash.push_back(8 * lane);
    CHECK(wavefronts_of_fours<float>(clash) == 32);
}

TEST_CASE("what a sub-step takes of shared memory", "[.traffic]") {
    struct Machine {
        int compute_capability;
        std::size_t of_a_block, of_a_multiprocessor;
    };
    for (int discs : {100, 400, 1000}) {
        Farm farm = sheared(discs);
        Assembly& rve = farm.assembly(0);
        for (const Machine& machine : {Machine{80, 163 * 1024, 164 * 1024}, Machine{90, 227 * 1024, 228 * 1024}}) {
            EmulatedDevice::Options options;
            options.shared_bytes_of_a_block = machine.of_a_block;
            options.shared_bytes_of_a_multiprocessor = machine.of_a_multiprocessor;
            const EmulatedDevice gpu(options);
            for (bool bonds : {false, true})
                for (bool ledger : {false, true})
                    for (bool single : {true, false}) {
                        const Traffic t = single ? traffic_of<float>(rve, gpu, bonds, ledger) : traffic_of<double>(rve, gpu, bonds, ledger);
                        fmt::print("traffic {} {} {} {} {} {} {} {} {} {} {}\n", machine.compute_capability, single ? "single" : "double", discs, bonds ? "on" : "off",
                                   ledger ? "on" : "off", t.groups, t.warps, t.contact_rows, t.incoming_rows, t.wavefronts, t.shared_bytes);
                    }
        }
    }
}
