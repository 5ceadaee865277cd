#pragma once
// One or many packings in an HDF5 file: groups /packing/0000, /packing/0001, ... with the fields of Packing.
#include <string>
#include <vector>

#include "common/packing/packing.hpp"

namespace talik {

// Before the work of preparing packings: `file` replaces nothing but a packing file.
void check_place_of_packings(const std::string& file);

// Written under a temporary name and renamed, so that a packing file is whole or absent. `specification`: the TOML text it
// was prepared from, kept with it (may be empty).
void write_packings(const std::string& file, const std::string& program, const std::vector<Packing>& packings,
                    const std::string& specification = "");
std::vector<Packing> read_packings(const std::string& file);

} // namespace talik
