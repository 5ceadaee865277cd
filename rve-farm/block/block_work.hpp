#pragma once
// The working memory of a block during a chunk: columns in shared memory, in the order of how much they gain by being there.
// What does not fit into the budget lies in the device's memory (the slower variant). One function lays them out, for the block
// itself and for whoever has to know how much it will take.
#include <cstddef>
#include <cstdint>

#include "rve-farm/block/block_task.hpp"
#include "rve-farm/kernel/disc_step.hpp"

namespace talik::farm {

// A row is fetched in one access.
template <class Real>
struct alignas(16) BlockRow {
    Real x, y, turn;  // w, non-affine, m; relative to the frame, rad: since the start of the chunk
    Real radius; // m
};

// The number of threads of a block: as many warps as may be, of which no more than an eighth are idle while the groups are dealt to
// them in rounds.
TALIK_HOST_DEVICE int block_threads(int groups, int most_warps) {
    int warps = most_warps < groups ? most_warps : groups;
    for (; warps > 1; --warps) {
        const int dealt = (groups + warps - 1) / warps * warps;
        if (8 * (dealt - groups) <= dealt) break;
    }
    return warps * 32;
}
constexpr int most_warps_in_shared = 7, most_warps_spread = 16; // 400 discs are 13 groups: two rounds of seven

// What all threads need and one of them computes.
template <class Real>
struct BlockUniforms {
    PlanarStretch<Real> discs;              // U - I of the sub-step
    CellMotion<Real> cell;                  // F - I, for the contacts
    Symmetric change, gained;               // U - I and I - U^-1, for the ledger
    std::int32_t accepted, finite;
    double largest_displacement;            // m
    // Of that one thread.
    ChunkMotion motion;
    Stretch stretch, last_stretch;
};

// What each thread leaves at the end, in the place of the columns, which nobody needs any more.
static_assert(offsetof(ChunkSums, largest_drift_squared) == sizeof(ChunkSums) - sizeof(double), "the last number is a maximum, the others are sums");
struct BlockScratch {
    static constexpr int sums = sizeof(ChunkSums) / sizeof(double);
    TALIK_HOST_DEVICE static std::size_t bytes(int threads) { return static_cast<std::size_t>(threads) * sizeof(ChunkSums); }
};

template <class Real>
struct BlockWork {
    BlockUniforms<Real>* uniforms = nullptr;
    Real* verdicts = nullptr;  // of the threads: the largest displacement squared of their discs, or no number
    double* scratch = nullptr; // begins where the columns begin
    // discs; several columns one behind the other, disc_slots apart
    BlockRow<Real>* displacement = nullptr;
    Real* velocity = nullptr;     // x, y, spin: m/s, m/s, 1/s
    Real* force = nullptr;        // of the contacts that the disc owns: x, y, torque: N, N, N m
    Real* inverse_mass = nullptr; // 1/m, 2/(m r^2): 1/kg, 1/(kg m^2)
    // contacts, contact_slots apart
    Real* contact_force = nullptr; // on the partner: x, y, torque: N, N, N m
    Real* memory = nullptr;        // turn, elongation, tangential change; bonded; f_t of the last sub-step: as present
    Real* start = nullptr;         // normal x, y, inverse length, overlap, tangential force: ContactStart
    // short numbers
    std::uint16_t *partner = nullptr, *incoming = nullptr, *incoming_begin = nullptr;

    static constexpr int starts = 5;
    TALIK_HOST_DEVICE static constexpr int memories(bool bonds, bool ledger) { return 3 + ledger + bonds; }
    static constexpr int turn = 0, elongation = 1, tangential_change = 2, bonded = 3; // of `memory`; with bonds
    TALIK_HOST_DEVICE static constexpr int tangential(bool bonds) { return 3 + bonds; }  // with the ledger

    struct Bytes {
        std::size_t shared, spread;
    };

    // Where it may spread, what is beyond the budget of shared_bytes goes to spread_memory; else all is shared (and the compiler
    // knows it), whatever the budget. Returns what is taken of both.
    template <bool may_spread>
    TALIK_HOST_DEVICE Bytes lay_out(const BlockSize& size, bool bonds, bool ledger, int threads, std::byte* shared_memory, [[maybe_unused]] std::size_t shared_bytes,
                                    [[maybe_unused]] std::byte* spread_memory) {
        Bytes used{0, 0};
        const auto room = [](std::size_t bytes) { return (bytes + 15) / 16 * 16; };
        uniforms = reinterpret_cast<BlockUniforms<Real>*>(shared_memory);
        used.shared = room(sizeof(BlockUniforms<Real>));
        verdicts = reinterpret_cast<Real*>(shared_memory + used.shared);
        used.shared += room(static_cast<std::size_t>(threads) * sizeof(Real));
        const std::size_t before_columns = used.shared;
        scratch = reinterpret_cast<double*>(shared_memory + before_columns);
        const auto place = [&](auto*& column, std::size_t entries) {
            using Column = decltype(column + 0);
            const std::size_t bytes = room(entries * sizeof(*column));
            if constexpr (may_spread) {
                if (used.shared + bytes > shared_bytes) {
                    column = reinterpret_cast<Column>(spread_memory + used.spread);
                    used.spread += bytes;
                    return;
                }
            }
            column = reinterpret_cast<Column>(shared_memory + used.shared);
            used.shared += bytes;
        };
        const auto discs = static_cast<std::size_t>(size.disc_slots()), contacts = static_cast<std::size_t>(size.contact_slots);
        place(displacement, discs);
        place(contact_force, 3 * contacts);
        place(memory, static_cast<std::size_t>(memories(bonds, ledger)) * contacts);
        place(force, 3 * discs);
        place(velocity, 3 * discs);
        place(partner, contacts);
        place(incoming, static_cast<std::size_t>(size.incoming));
        place(incoming_begin, discs + 1);
        place(start, starts * contacts);
        place(inverse_mass, 2 * discs);
        const std::size_t with_scratch = before_columns + BlockScratch::bytes(threads);
        used.shared = used.shared > with_scratch ? used.shared : with_scratch;
        return used;
    }
};

} // namespace talik::farm
