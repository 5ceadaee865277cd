// What mpi_channel.hpp promises, in a build without MPI.
#include "common/base/error.hpp"
#include "exchange/mpi_channel.hpp"

namespace talik::exchange {
namespace {

[[noreturn]] void absent() {
    fail(ExitCode::bad_input, "--exchange mpi: this build has no MPI", "install libopenmpi-dev and openmpi-bin, configure anew and build; or use shm:NAME or file:FOLDER");
}

} // namespace

bool built_with_mpi() { return false; }
void begin_mpi(Role) { absent(); }
std::vector<std::unique_ptr<Channel>> make_mpi_channels(int, const WaitLimits&) { absent(); }
std::unique_ptr<Channel> join_mpi_channel(const WaitLimits&) { absent(); }
void end_mpi(bool) noexcept {}
std::pair<std::unique_ptr<Channel>, std::unique_ptr<Channel>> mpi_pair(std::size_t, const WaitLimits&) { absent(); }

} // namespace talik::exchange
