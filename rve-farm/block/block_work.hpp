#pragma once
// The working memory of a block during a chunk: columns in shared memory, in the order of how much they gain by being there.
// What does not fit into the budget lies in the device's memory (the slower variant). One function lays them out, for the block
// itself and for whoever has to know how much it will take.
#include <cstddef>
#include <cstdint>

#include "rve-farm/block/block_task.hpp"
#include "rve-farm/kernel/contact_step.hpp"
#include "rve-farm/kernel/disc_step.hpp"

namespace talik::farm {

// Where a disc is, and how large.
template <class Real>
struct BlockRow {
    Real x, y, turn; // w, non-affine, m; relative to the frame, rad: since the start of the chunk
    Real radius;     // m
};
template <class Real>
struct BlockMotion {
    Real x, y, spin;   // m/s, m/s, 1/s
    Real inverse_mass; // 1/m, 1/kg
};
// Of the contacts that a disc owns.
template <class Real>
struct BlockForce {
    Real x, y, torque; // N, N, N m
    Real nothing;
};
template <class Real>
struct BlockMemory {
    Real turn, elongation;              // ContactMemory
    Real tangential_change, tangential_start; // of f_t since the start, and there, N
};
// What a contact gives its partner.
template <class Real>
struct BlockAction {
    Real x, y, torque; // N, N, N m
    Real tangential;   // f_t, N
};

// Everything that a sub-step needs comes in fours. A column of fours lies in pieces of 16 bytes, the largest that a thread fetches
// in one access, those of the 32 threads of a warp side by side: whole wavefronts, no bank conflicts.
template <class Four, class Real>
class FourColumn {
public:
    struct alignas(16) Piece {
        Real part[16 / sizeof(Real)];
    };
    static constexpr int pieces = static_cast<int>(sizeof(Four) / sizeof(Piece));
    static_assert(sizeof(Four) == 4 * sizeof(Real) && (pieces == 1 || pieces == 2));
    TALIK_HOST_DEVICE static int index(int slot) { return pieces == 1 ? slot : slot + (slot & ~31); } // of its first piece

    TALIK_HOST_DEVICE static std::size_t bytes(std::size_t slots) { return (slots + 31) / 32 * 32 * sizeof(Four); }
    TALIK_HOST_DEVICE void lie_at(std::byte* memory) { pieces_ = reinterpret_cast<Piece*>(memory); }

    TALIK_HOST_DEVICE Four at(int slot) const {
        const Piece* p = pieces_ + index(slot);
        if constexpr (pieces == 1) return {p[0].part[0], p[0].part[1], p[0].part[2], p[0].part[3]};
        else return {p[0].part[0], p[0].part[1], p[32].part[0], p[32].part[1]};
    }
    TALIK_HOST_DEVICE void put(int slot, const Four& four) const {
        [[maybe_unused]] auto [a, b, c, d] = four;
#if defined(__CUDA_ARCH__) // the last is often the constant that was fetched: or the compiler would store the others by twos and ones
        if constexpr (sizeof(Real) == 4) asm volatile("" : "+f"(d));
        else asm volatile("" : "+d"(d));
#endif
        Piece* p = pieces_ + index(slot);
        if constexpr (pieces == 1) p[0] = {a, b, c, d};
        else p[0] = {a, b}, p[32] = {c, d};
    }

private:
    Piece* pieces_;
};

// The number of threads of a block: the groups of discs are dealt to its warps in as few rounds as may be, and no warp more than
// these rounds need.
TALIK_HOST_DEVICE int block_threads(int groups, int most_warps) {
    const int rounds = (groups + most_warps - 1) / most_warps;
    return 32 * ((groups + rounds - 1) / rounds);
}

// The warps that live on a multiprocessor at a time, in as many blocks as find room in its shared memory: what the kernels are
// compiled for, with 80 registers to a thread of the smaller number and 128 to others (its 65,536 are dealt in fourths).
template <class Real>
constexpr int warps_of_a_multiprocessor(bool spread) { return sizeof(Real) == 4 && !spread ? 24 : 16; }
constexpr std::size_t shared_bytes_of_the_system = 1024; // taken from every block by CUDA

// What all threads need and one of them computes.
template <class Real>
struct BlockUniforms {
    PlanarStretch<Real> discs;              // U - I of the sub-step
    CellMotion<Real> cell;                  // F - I, for the contacts
    PlanarStretch<Real> counted, gained;    // for the ledger: what a virial of this sub-step counts for; I - U^-1 of the one before
    std::int32_t accepted, finite;
    double largest_displacement;            // m
    // Of that one thread.
    ChunkMotion motion;
    Stretch stretch, last_stretch, next_stretch;
    PlanarStretch<Real> next_gained;
};

// What each thread leaves at the end, in the place of the columns, which nobody needs any more.
static_assert(offsetof(ChunkSums, discs) + offsetof(DiscSums<double>, largest_drift_squared) == sizeof(ChunkSums) - sizeof(double), "the last number is a maximum, the others are sums");
struct BlockScratch {
    static constexpr int sums = sizeof(ChunkSums) / sizeof(double);
    TALIK_HOST_DEVICE static std::size_t bytes(int threads) { return static_cast<std::size_t>(threads) * sizeof(ChunkSums); }
};

template <class Real>
struct BlockWork {
    BlockUniforms<Real>* uniforms = nullptr;
    Real* verdicts = nullptr;  // of the threads: the largest displacement squared of their discs, or no number
    double* scratch = nullptr; // begins where the columns begin
    FourColumn<BlockRow<Real>, Real> displacement; // by disc slot
    FourColumn<BlockMotion<Real>, Real> motion;
    FourColumn<BlockForce<Real>, Real> force;
    FourColumn<BlockAction<Real>, Real> action; // by contact slot
    FourColumn<BlockMemory<Real>, Real> memory;
    FourColumn<ContactStart<Real>, Real> start;
    Real* inverse_inertia = nullptr;            // 2/(m r^2), 1/(kg m^2), by disc slot
    std::uint8_t* bonded = nullptr;             // 1 or 0, by contact slot
    std::int32_t* group_begin = nullptr;        // contact slots, by group of discs and one more
    // short numbers
    std::uint16_t *partner = nullptr, *incoming = nullptr, *incoming_begin = nullptr;

    struct Bytes {
        std::size_t shared, spread;
    };

    // Where it may spread, what is beyond the budget of shared_bytes goes to spread_memory; else all is shared (and the compiler
    // knows it), whatever the budget. Returns what is taken of both.
    template <bool may_spread>
    TALIK_HOST_DEVICE Bytes lay_out(const BlockSize& size, bool bonds, int threads, std::byte* shared_memory, [[maybe_unused]] std::size_t shared_bytes,
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
        const auto place_fours = [&](auto& column, std::size_t slots) {
            std::byte* memory_of_column = nullptr;
            place(memory_of_column, column.bytes(slots));
            column.lie_at(memory_of_column);
        };
        const auto discs = static_cast<std::size_t>(size.disc_slots()), contacts = static_cast<std::size_t>(size.contact_slots);
        place(group_begin, static_cast<std::size_t>(size.groups) + 1);
        place_fours(displacement, discs);
        place_fours(action, contacts);
        place_fours(memory, contacts);
        place_fours(force, discs);
        place_fours(motion, discs);
        place(inverse_inertia, discs);
        place(bonded, bonds ? contacts : 0);
        place(partner, contacts);
        place(incoming, static_cast<std::size_t>(size.incoming));
        place(incoming_begin, discs + 1);
        place_fours(start, contacts);
        const std::size_t with_scratch = before_columns + BlockScratch::bytes(threads);
        used.shared = used.shared > with_scratch ? used.shared : with_scratch;
        return used;
    }
};

} // namespace talik::farm
