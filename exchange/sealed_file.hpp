#pragma once
// A seal at the end of a checkpoint's file: the checksum of every byte before it. It is looked at before the file is
// opened, because a damaged file can do worse than fail to be read: HDF5 trusts its own tables, and state is just numbers.
// HDF5 itself never looks beyond the end that it wrote down; sealed files open with every tool.
#include <filesystem>

namespace talik::exchange {

// After the file was closed, once.
void seal(const std::filesystem::path& path);
// The file is there, sealed, and holds the bytes that were sealed; else an Error with exit code 2.
void require_sealed(const std::filesystem::path& path);

} // namespace talik::exchange
