#pragma once
// What --exchange of both programs means: shm:NAME, file:FOLDER, mpi.
#include <memory>
#include <string>
#include <vector>

#include "exchange/channel.hpp"

namespace talik::exchange {

// The driver's ends of an exchange with `farms` farms. The first has the name itself, the others NAME.1, NAME.2, ... (of MPI:
// as many as there are in the job, in the order of their ranks; `farms` must then be 0 or that number).
std::vector<std::unique_ptr<Channel>> make_exchange(const std::string& address, int farms, const WaitLimits& limits);
std::string address_of_farm(const std::string& address, int farm);
std::unique_ptr<Channel> make_exchange(const std::string& address, const WaitLimits& limits); // one end, shm or file
// A farm's end.
std::unique_ptr<Channel> join_exchange(const std::string& address, const WaitLimits& limits);

bool is_mpi(const std::string& address);

} // namespace talik::exchange
