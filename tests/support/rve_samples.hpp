#pragma once
// Small assemblies for tests, and one-line ways to drive them.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "common/packing/packing.hpp"
#include "rve-farm/backend/farm.hpp"

namespace talik::farm::samples {

// A repeatable number in [-1, 1).
inline double draw(std::uint64_t& state) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return static_cast<double>(state >> 11) / 4503599627370496.0 - 1.0;
}

// Discs on a triangular lattice, pushed together by `overlap` (of a radius), shaken by `jitter` (of a radius), radii
// varied by `spread`; sites beyond `discs` stay vacant. Contacts have no history. Mean radius 4 mm.
inline Packing lattice(int discs, double overlap, double jitter = 0, double spread = 0, std::uint64_t seed = 1) {
    const double radius = 0.004, pitch = 2 * radius * (1 - overlap / 2);
    const int along = std::max(1, static_cast<int>(std::lround(std::sqrt(discs))));
    int rows = (discs + along - 1) / along;
    rows += rows % 2; // the lattice repeats after two rows
    Packing packing;
    packing.cell << along * pitch, 0, 0, rows * pitch * std::sqrt(3.0) / 2;
    for (int i = 0; i < discs; ++i) {
        const int row = i / along, column = i % along;
        packing.x.push_back(pitch * (column + 0.5 * (row % 2)) + jitter * radius * draw(seed));
        packing.y.push_back(pitch * std::sqrt(3.0) / 2 * row + jitter * radius * draw(seed));
        packing.radius.push_back(radius * (1 + spread * draw(seed)));
    }
    return packing;
}

// A disordered heap of contacts of two kinds of history: what the laws are compared on.
inline Packing disordered(int discs, std::uint64_t seed = 7) { return lattice(discs, 0.04, 0.03, 0.03, seed); }

inline Answer step(Farm& farm, const std::array<double, 4>& increment, double time_increment, int substeps = 0, double ice = 1,
                   int id = 0) {
    const auto who = static_cast<std::uint32_t>(id);
    Answer answer;
    farm.advance(std::span(&who, 1), increment, std::span(&ice, 1), time_increment, substeps, std::span(&answer, 1));
    return answer;
}

inline FarmOptions threads(int count) {
    FarmOptions options;
    options.threads = count;
    return options;
}

inline double mean_pressure(const Answer& answer) { return -(answer.stress[0] + answer.stress[1]) / 2; }

// What the ledger of an RVE leaves unexplained between two answers, J.
inline double ledger_error(const Answer& from, const Answer& to) {
    const auto held = [](const Answer& a) {
        return a.stored_energy + a.kinetic_energy + a.friction_dissipation + a.damping_dissipation + a.bond_dissipation;
    };
    return (to.work - from.work) - (held(to) - held(from));
}

inline bool same_bits(const Farm& a, int id_a, const Farm& b, int id_b) {
    std::vector<std::byte> bytes_a, bytes_b;
    a.save(id_a, bytes_a);
    b.save(id_b, bytes_b);
    return bytes_a == bytes_b;
}

} // namespace talik::farm::samples
