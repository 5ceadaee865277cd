#pragma once
// Points as a VTK unstructured grid (.vtu) and their series over time (.pvd): what ParaView 5.11 opens directly.
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace talik {

// One quantity of all points; data holds `components` values per point, one point after the other.
struct PointArray {
    std::string name; // with the unit: "temperature (C)"
    int components = 1;
    std::span<const double> data;
};

// positions: x y z per point, m.
void write_vtu(const std::filesystem::path& path, std::span<const double> positions, const std::vector<PointArray>& arrays);

struct SeriesEntry {
    double time; // s
    std::string file;
};
void write_pvd(const std::filesystem::path& path, const std::vector<SeriesEntry>& entries);

} // namespace talik
