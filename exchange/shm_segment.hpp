#pragma once
// The segment /dev/shm/talik-NAME: made by the driver, joined by the farm, nameless as soon as both have it (so that
// nothing is left whatever dies later), and removed where its maker is dead.
#include <boost/interprocess/mapped_region.hpp>
#include <boost/interprocess/shared_memory_object.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "exchange/shm_layout.hpp"
#include "exchange/wait.hpp"

namespace talik::exchange {

class SharedSegment {
public:
    // The driver's side. free_bytes: of /dev/shm; a test may lie.
    static SharedSegment create(const std::string& name, std::size_t ring_bytes, const std::function<std::uint64_t()>& free_bytes);
    // The farm's side; waits for the segment to appear.
    static SharedSegment join(const std::string& name, const WaitLimits& limits);
    // The farm's side in the driver's own process and mapping: for the thread sanitizer, which knows memory by its address.
    static SharedSegment join_here(const std::string& name, const SharedSegment& made);

    ~SharedSegment();
    SharedSegment(SharedSegment&&) noexcept = default;
    SharedSegment& operator=(SharedSegment&&) = delete;

    shm::Segment& operator*() const { return *static_cast<shm::Segment*>(region_->get_address()); }
    shm::Segment* operator->() const { return &**this; }
    std::byte* ring_data(int role) const;
    int file() const { return memory_.get_mapping_handle().handle; }

    void remove_name() noexcept; // if it is still this segment's

private:
    SharedSegment(boost::interprocess::shared_memory_object&& memory, const std::string& name);
    static bool try_join(const std::string& name, boost::interprocess::shared_memory_object& memory);
    void map();
    boost::interprocess::shared_memory_object memory_;
    std::shared_ptr<boost::interprocess::mapped_region> region_; // null until it is mapped
    std::string file_name_; // "talik-NAME"; empty once removed
};

std::uint64_t free_shared_memory(); // of /dev/shm, bytes

// Removes every segment of this user whose maker is dead; returns how many.
int remove_stale_segments();

} // namespace talik::exchange
