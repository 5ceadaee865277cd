#include "mpm-driver/constitutive/packing_choice.hpp"

#include <cmath>
#include <random>

#include "common/base/error.hpp"

namespace talik::driver {

std::vector<int> deal_packings(int count, int packings, std::uint64_t seed) {
    std::vector<int> dealt(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) dealt[static_cast<std::size_t>(i)] = i % packings;
    std::mt19937_64 random(seed); // its numbers are the same everywhere; std::shuffle's order is not
    for (std::size_t i = dealt.size(); i > 1; --i) std::swap(dealt[i - 1], dealt[random() % i]);
    return dealt;
}

int k0_levels(const std::vector<Packing>& packings) {
    if (packings.empty() || packings.front().vertical_stress <= 0.0) return 1;
    int levels = 1;
    while (levels < static_cast<int>(packings.size()) && packings[static_cast<std::size_t>(levels)].seed == packings.front().seed) ++levels;
    require(packings.size() % static_cast<std::size_t>(levels) == 0, "the packings are no whole K0 paths: their seeds have different numbers of snapshots",
            "prepare them with one call of `rve-farm pack`");
    return levels;
}

std::vector<int> deal_packings_by_depth(const std::vector<Packing>& packings, const std::vector<double>& vertical_stress, std::uint64_t seed) {
    const int levels = k0_levels(packings), paths = static_cast<int>(packings.size()) / levels;
    std::vector<int> dealt = deal_packings(static_cast<int>(vertical_stress.size()), paths, seed);
    for (std::size_t rve = 0; rve < dealt.size(); ++rve) {
        const int first = dealt[rve] * levels;
        int nearest = first;
        const auto distance = [&](int k) { return std::abs(packings[static_cast<std::size_t>(k)].vertical_stress - vertical_stress[rve]); };
        for (int k = first; k < first + levels; ++k)
            if (distance(k) < distance(nearest)) nearest = k;
        dealt[rve] = nearest;
    }
    return dealt;
}

} // namespace talik::driver
