#pragma once
// Text and raw files, written completely or not at all; a full disk is an error that says so.
#include <filesystem>
#include <string>

namespace talik {

std::string read_text_file(const std::filesystem::path& path);

// Writes beside the target, flushes to disk and renames: a reader sees the old file or the new one, never a half.
void write_file_atomically(const std::filesystem::path& path, const std::string& content);

// mkdir -p, with the reason where it cannot be done.
void make_folder(const std::filesystem::path& path);

// Throws "PATH: cannot be written: REASON" with exit code 4 (no space, quota) or 2 (permissions, no such folder).
[[noreturn]] void fail_to_write(const std::filesystem::path& path, int error_number);

} // namespace talik
