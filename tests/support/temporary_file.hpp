#pragma once
// Files of a test: ctest runs test cases of one program side by side, so each process has a folder of its own.
#include <filesystem>
#include <string>
#include <unistd.h>

namespace talik {

class TestFolder {
public:
    TestFolder() : path_(std::filesystem::path(TALIK_BINARY_DIR) / "test-files" / std::to_string(::getpid())) {
        std::filesystem::create_directories(path_);
    }
    ~TestFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    std::string file(const std::string& name) const { return (path_ / name).string(); }

private:
    std::filesystem::path path_;
};

// The folder of this process, gone with it.
inline std::string test_file(const std::string& name) {
    static const TestFolder folder;
    return folder.file(name);
}

} // namespace talik
