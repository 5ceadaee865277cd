#pragma once
// A kernel runs a chunk of a macro step on one RVE: some sub-steps of a constant velocity gradient on one candidate list.
// It works on a copy of the state in displacement form and gives it back only where the list has held, so that taking a
// chunk back costs nothing. Kernels differ in precision and in the instruction level that they were compiled for; the laws
// (contact_step.hpp, disc_step.hpp) are one text.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/physics/rve_parameters.hpp"
#include "rve-farm/assembly/answer.hpp"
#include "rve-farm/assembly/columns.hpp"
#include "rve-farm/assembly/slot_layout.hpp"
#include "rve-farm/kernel/chunk_request.hpp"

namespace talik::farm {

enum class Precision { single_, double_ };

// The plain kernel: scalar code for any machine, and the one that can be visited in scrambled order. The others: lanes.
enum class Level { plain, sse4, avx2, avx512 };

struct ChunkOutcome {
    bool accepted = false;
    bool finite = true;
    double largest_displacement = 0; // of any disc during the chunk, non-affine, m
    Stretch stretch, last_stretch;   // of the sub-step that would come next, and of the last one
    double strain = 0;               // bound of the relative change of any length
    Answer answer;                   // of the state at the end; only where accepted
    double load_seconds = 0, inner_seconds = 0, close_seconds = 0; // where asked for
};

// Memory of a thread that kernels work in: grows to the largest RVE it has met.
class WorkMemory {
public:
    std::byte* take(std::size_t bytes) {
        if (bytes + 64 > memory_.size()) memory_.resize(bytes + 64);
        const auto address = reinterpret_cast<std::uintptr_t>(memory_.data());
        return memory_.data() + (64 - address % 64) % 64;
    }

private:
    std::vector<std::byte> memory_;
};

struct Kernel {
    Level level = Level::plain;
    Precision precision = Precision::double_;
    LaneShape shape;
    ChunkOutcome (*run)(const RveParameters&, const ChunkRequest&, AssemblyView&, const ColumnChoice&, const SlotLayout&, WorkMemory&) = nullptr;
};

const char* name_of(Level level);
const char* name_of(Precision precision);
std::optional<Level> level_named(const std::string& name);

std::vector<Level> levels_of_this_machine(); // from plain to best
Level best_level();
const Kernel& kernel(Level level, Precision precision); // refuses (bad_input) a level that this machine lacks

// Tests: the plain kernel with every phase visited in an order scrambled by the seed, on groups of `lanes`.
ChunkOutcome run_shuffled(std::uint64_t seed, Precision precision, const RveParameters&, const ChunkRequest&, AssemblyView&, const ColumnChoice&,
                          const SlotLayout&, WorkMemory&);

} // namespace talik::farm
