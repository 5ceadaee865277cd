#pragma once
// The MPI job as both ends of the exchange see it: who is there, and a lock, because MPI is called by one thread at a time.
#include <cstdint>
#include <memory>
#include <mpi.h>
#include <mutex>
#include <string>
#include <vector>

#include "exchange/process_identity.hpp"
#include "exchange/wait.hpp"

namespace talik::exchange::mpi {

struct Rank { // what each rank tells all others
    std::int32_t role = 0, version = 0;
    ProcessIdentity process;
    std::uint64_t machine = 0; // of this machine since its start
    char host[64] = {};
};

class World {
public:
    static std::shared_ptr<World> job();  // met by begin()
    static std::shared_ptr<World> self(); // of this process alone, for tests; each has messages of its own

    void begin(Role role); // all ranks meet; exactly one is the driver
    void end(double patience_seconds) noexcept;

    MPI_Comm comm() const { return comm_; }
    std::mutex& mutex() { return mutex_; }
    int driver() const { return driver_; }
    std::vector<int> farms() const;
    const Rank& rank(int number) const { return ranks_[static_cast<std::size_t>(number)]; }

private:
    World() = default;
    void start();
    void wait_for(MPI_Request& request);
    MPI_Comm comm_ = MPI_COMM_NULL;
    std::mutex mutex_;
    int driver_ = -1;
    std::vector<Rank> ranks_;
    bool met_ = false;
};

std::uint64_t this_machine();

} // namespace talik::exchange::mpi
