#pragma once
// The packings a scene calls for: read from its files, or prepared by `rve-farm pack` at the first run and then cached.
#include <filesystem>
#include <vector>

#include "common/packing/packing.hpp"
#include "common/packing/packing_spec.hpp"

namespace talik::driver {

// threads: of the preparation; 0 = all.
std::vector<Packing> obtain_packings(const RveSpec& rve, int threads, bool quiet);

// TALIK_CACHE, else XDG_CACHE_HOME/talik, else HOME/.cache/talik.
std::filesystem::path cache_folder();

} // namespace talik::driver
