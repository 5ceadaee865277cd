#include "rve-farm/kernel/kernel.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "common/base/error.hpp"
#include "rve-farm/kernel/levels.hpp"
#include "rve-farm/kernel/plain_kernel.hpp"

namespace talik::farm {
namespace {

bool this_machine_has(Level level) {
    __builtin_cpu_init();
    switch (level) {
    case Level::plain: return true; // every x86-64
    case Level::sse4: return __builtin_cpu_supports("sse4.2") && __builtin_cpu_supports("popcnt");
    case Level::avx2: return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
    case Level::avx512:
        return this_machine_has(Level::avx2) && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
               __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
    }
    return false;
}

std::array<Kernel, 2> both(Level level, const LevelKernels& k) {
    return {Kernel{level, Precision::single_, k.single_shape, k.single_}, Kernel{level, Precision::double_, k.double_shape, k.double_}};
}

std::array<Kernel, 2> kernels_of(Level level) {
    switch (level) {
    case Level::plain: break;
    case Level::sse4: return both(level, sse4_kernels());
    case Level::avx2: return both(level, avx2_kernels());
    case Level::avx512: return both(level, avx512_kernels());
    }
    return {Kernel{level, Precision::single_, LaneShape{}, run_plain_single}, Kernel{level, Precision::double_, LaneShape{}, run_plain_double}};
}

constexpr std::array all_levels = {Level::plain, Level::sse4, Level::avx2, Level::avx512};

} // namespace

const char* name_of(Level level) {
    switch (level) {
    case Level::plain: return "plain";
    case Level::sse4: return "sse4";
    case Level::avx2: return "avx2";
    case Level::avx512: return "avx512";
    }
    return "unknown";
}

const char* name_of(Precision precision) { return precision == Precision::single_ ? "single" : "double"; }

std::optional<Level> level_named(const std::string& name) {
    for (Level level : all_levels)
        if (name == name_of(level)) return level;
    return std::nullopt;
}

std::vector<Level> levels_of_this_machine() {
    std::vector<Level> levels;
    for (Level level : all_levels)
        if (this_machine_has(level)) levels.push_back(level);
    return levels;
}

Level best_level() { return levels_of_this_machine().back(); }

const Kernel& kernel(Level level, Precision precision) {
    require(this_machine_has(level), fmt::format("this machine has no {}", name_of(level)), fmt::format("its best level is {}", name_of(best_level())));
    static const auto table = [] {
        std::array<std::array<Kernel, 2>, all_levels.size()> kernels;
        for (Level l : all_levels)
            if (this_machine_has(l)) kernels[static_cast<std::size_t>(l)] = kernels_of(l);
        return kernels;
    }();
    return table[static_cast<std::size_t>(level)][precision == Precision::single_ ? 0 : 1];
}

} // namespace talik::farm
