#include "rve-farm/packing/random_discs.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "common/base/error.hpp"

namespace talik::farm {
namespace {

// Whether disc i at (x, y) is clear of the discs placed so far, images included.
bool is_clear(const Packing& p, const std::vector<std::size_t>& placed, double side, double x, double y, double radius) {
    for (std::size_t j : placed) {
        const double dx = x - p.x[j] - side * std::round((x - p.x[j]) / side); // to the nearest image
        const double dy = y - p.y[j] - side * std::round((y - p.y[j]) / side);
        const double reach = radius + p.radius[j];
        if (dx * dx + dy * dy < reach * reach) return false;
    }
    return true;
}

} // namespace

std::uint64_t RandomNumbers::next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

Packing random_discs(const RveSpec& spec, std::uint64_t seed, int attempt, double void_ratio) {
    RandomNumbers random(seed * 1000003u + static_cast<std::uint64_t>(attempt) * 7919u + 17u);
    const auto count = static_cast<std::size_t>(spec.packing.discs);
    Packing p;
    p.thickness = spec.parameters.thickness;
    p.grain_density = spec.parameters.grain_density;
    p.seed = seed;
    p.x.resize(count), p.y.resize(count), p.radius.resize(count);
    double solid = 0.0; // m^2
    for (double& r : p.radius) {
        r = spec.packing.radius_min + (spec.packing.radius_max - spec.packing.radius_min) * random.uniform();
        solid += std::numbers::pi * r * r;
    }
    const double side = std::sqrt((1.0 + void_ratio) * solid);
    p.cell = side * Matrix::Identity();
    // The largest first, while there is room for them; their numbers stay in the order of the draw.
    std::vector<std::size_t> order(count), placed;
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return p.radius[a] > p.radius[b]; });
    for (std::size_t i : order) {
        int draws = 0;
        do {
            p.x[i] = side * random.uniform();
            p.y[i] = side * random.uniform();
            ensure(++draws < 1000000); // at void ratios of 1 and more a free place is found within some hundred draws
        } while (!is_clear(p, placed, side, p.x[i], p.y[i], p.radius[i]));
        placed.push_back(i);
    }
    return p;
}

} // namespace talik::farm
