#pragma once
// Telling a segment of a dead run from one in use, by its preamble, whatever version wrote it.
#include <string>

#include "exchange/process_identity.hpp"

namespace talik::exchange {

enum class SegmentState { gone, being_made, in_use, stale, foreign };

struct SegmentFinding {
    SegmentState state = SegmentState::gone;
    ProcessIdentity creator;
};

std::string segment_path(const std::string& file_name); // "/dev/shm/talik-NAME"
SegmentFinding examine_segment(const std::string& file_name);
// Unlinks the name if it is still that of the open file: no other run's segment is ever hit.
bool unlink_if_same(int file, const std::string& file_name) noexcept;
// Removes the segment if its maker is dead, and says so.
bool remove_if_stale(const std::string& file_name);

} // namespace talik::exchange
