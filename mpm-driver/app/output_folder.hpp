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

// A run from the start would leave checkpoints of two runs side by side. The number removed.
int remove_checkpoints(const std::filesystem::path& folder);

} // namespace talik::driver
