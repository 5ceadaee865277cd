#pragma once
// The folder a run writes to: one run at a time, and nothing in it that belongs to an earlier one.
#include <filesystem>

namespace talik::driver {

// Holds FOLDER/.lock while it lives; the kernel lets go of it with the process, however that ends. A second run is refused.
class OutputLock {
public:
    explicit OutputLock(const std::filesystem::path& folder);
    ~OutputLock();
    OutputLock(const OutputLock&) = delete;
    OutputLock& operator=(const OutputLock&) = delete;

private:
    int file_ = -1;
};

// Where a run's files belong there is no folder of that name, nor anything else that a file does not replace.
void require_room_for_files(const std::filesystem::path& folder);

// Whether a run writes, or removes, this file of its output folder itself.
bool is_written_by_run(const std::filesystem::path& folder, const std::filesystem::path& file);

// A run from the start would leave checkpoints of two runs side by side. The number removed.
int remove_checkpoints(const std::filesystem::path& folder);

} // namespace talik::driver
