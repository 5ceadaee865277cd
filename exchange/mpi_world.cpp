#include "exchange/mpi_world.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <string>
#include <thread>

#include "common/base/error.hpp"
#include "common/base/interrupt.hpp"
#include "exchange/checksum.hpp"
#include "exchange/frame.hpp"

namespace talik::exchange::mpi {
namespace {

constexpr std::chrono::milliseconds nap{1};

void start_mpi() {
    int started = 0, level = 0;
    MPI_Initialized(&started);
    if (started) return;
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &level);
    require(level >= MPI_THREAD_SERIALIZED, "this MPI does not let threads take turns", "use an MPI built with threads (Debian's Open MPI is)");
}

} // namespace

std::uint64_t this_machine() {
    std::ifstream in("/proc/sys/kernel/random/boot_id");
    std::string id;
    in >> id;
    return checksum(id);
}

std::shared_ptr<World> World::job() {
    static const std::shared_ptr<World> world(new World);
    return world;
}

std::shared_ptr<World> World::self() {
    static const bool started = [] {
        start_mpi();
        std::atexit([] { MPI_Finalize(); });
        return true;
    }();
    ensure(started);
    const std::shared_ptr<World> made(new World);
    MPI_Comm_dup(MPI_COMM_SELF, &made->comm_);
    made->ranks_.resize(1);
    made->ranks_[0].process = this_process();
    made->ranks_[0].machine = this_machine();
    return made;
}

// Sleeps, where MPI itself would spin.
void World::wait_for(MPI_Request& request) {
    for (int done = 0;;) {
        MPI_Test(&request, &done, MPI_STATUS_IGNORE);
        if (done) return;
        if (interrupted()) fail(ExitCode::failed, fmt::format("interrupted by {} while waiting for the other ranks", interrupt_name()), "start again");
        std::this_thread::sleep_for(nap);
    }
}

void World::begin(Role role) {
    start_mpi();
    MPI_Comm_dup(MPI_COMM_WORLD, &comm_);
    int count = 0;
    MPI_Comm_size(comm_, &count);
    Rank own;
    own.role = static_cast<std::int32_t>(role);
    own.version = protocol_version;
    own.process = this_process();
    own.machine = this_machine();
    gethostname(own.host, sizeof own.host - 1);
    ranks_.resize(static_cast<std::size_t>(count));
    MPI_Request request;
    MPI_Iallgather(&own, sizeof own, MPI_BYTE, ranks_.data(), sizeof own, MPI_BYTE, comm_, &request);
    wait_for(request);
    met_ = true;
    int drivers = 0;
    for (int i = 0; i < count; ++i) {
        require(rank(i).version == protocol_version, fmt::format("rank {} speaks version {} of the exchange, this one version {}", i, rank(i).version, protocol_version),
                "use driver and farms of the same version of Talik");
        if (rank(i).role == static_cast<std::int32_t>(Role::driver)) driver_ = i, ++drivers;
    }
    require(drivers == 1 && count >= 2, fmt::format("this MPI job has {} driver(s) and {} farm(s)", drivers, count - drivers),
            "start it with: mpirun -n 1 mpm-driver run SCENE --exchange mpi : -n N rve-farm serve --exchange mpi");
}

std::vector<int> World::farms() const {
    std::vector<int> farms;
    for (int i = 0; i < static_cast<int>(ranks_.size()); ++i)
        if (i != driver_) farms.push_back(i);
    return farms;
}

// Whoever cannot meet the others any more leaves without: the launcher then ends the job.
void World::end(double patience_seconds) noexcept {
    if (!met_) return;
    met_ = false;
    MPI_Request request;
    MPI_Ibarrier(comm_, &request);
    const auto begin = std::chrono::steady_clock::now();
    for (int done = 0; !done;) {
        MPI_Test(&request, &done, MPI_STATUS_IGNORE);
        if (!done && std::chrono::steady_clock::now() - begin > std::chrono::duration<double>(patience_seconds)) return;
        if (!done) std::this_thread::sleep_for(nap);
    }
    MPI_Finalize();
}

} // namespace talik::exchange::mpi
