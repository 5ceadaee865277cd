#pragma once
// The exchange between the ranks of one MPI job: mpirun -n 1 mpm-driver run SCENE --exchange mpi : -n N rve-farm serve
// --exchange mpi. Who is driver and who is farm is told by each rank, not by its number. Waiting sleeps: no rank spins.
// In a build without MPI these say so.
#include <memory>
#include <vector>

#include "exchange/channel.hpp"

namespace talik::exchange {

// To be called first in both programs, before long work: all ranks meet here.
void begin_mpi(Role role);
// farms: as many as are expected; 0 = as there are.
std::vector<std::unique_ptr<Channel>> make_mpi_channels(int farms, const WaitLimits& limits);
std::unique_ptr<Channel> join_mpi_channel(const WaitLimits& limits);
// The orderly end of the job, once the channels are gone. After an error: the launcher ends the rest.
void end_mpi(bool in_order) noexcept;

// Both ends in this process, for tests.
std::pair<std::unique_ptr<Channel>, std::unique_ptr<Channel>> mpi_pair(std::size_t capacity, const WaitLimits& limits);
bool built_with_mpi();

} // namespace talik::exchange
