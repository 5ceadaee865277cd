#pragma once
// The exchange through a folder, for debugging and for a shared file system: every message is a file, written under a
// temporary name and then renamed, with checksums; a step is one message each way. `tail -f FOLDER/driver.log` follows a run by
// eye, and the newest messages stay to be looked at.
#include <memory>
#include <string>

#include "exchange/channel.hpp"

namespace talik::exchange {

struct FileOptions {
    std::size_t most_unread_bytes = std::size_t(64) << 20; // of each side: then the writer waits
};

// The driver makes the folder (mode 0700) or takes over one that an exchange left, the farm joins it.
std::unique_ptr<Channel> make_file_channel(const std::string& folder, const WaitLimits& limits, const FileOptions& options = {});
std::unique_ptr<Channel> join_file_channel(const std::string& folder, const WaitLimits& limits, const FileOptions& options = {});

} // namespace talik::exchange
