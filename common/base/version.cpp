#include "common/base/version.hpp"

#include <fmt/format.h>
#include <hdf5.h>

#include "talik_build_facts.hpp" // made by CMake

namespace talik {

std::string version() { return TALIK_VERSION; }
std::string code_that_packs() { return TALIK_PACKERS; }

std::string build_facts(const std::string& program) {
    return fmt::format("{} {} (commit {})\ncompiler: {} {}, {}\nbackends: cpu{}\nHDF5 {}.{}.{}, MPI: {}", program,
                       TALIK_VERSION, TALIK_COMMIT, TALIK_COMPILER, TALIK_COMPILER_VERSION, TALIK_BUILD_TYPE,
                       TALIK_CUDA_BACKEND ? ", cuda" : "", H5_VERS_MAJOR, H5_VERS_MINOR, H5_VERS_RELEASE, TALIK_MPI);
}

} // namespace talik
