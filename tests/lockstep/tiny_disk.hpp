#pragma once
#include <sys/mount.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>

namespace talik::lockstep {

// A disk of its own, of a few pages: for root only.
class TinyDisk {
public:
    TinyDisk(const std::filesystem::path& path, const std::string& size) : path_(path) {
        std::filesystem::create_directories(path);
        mounted_ = mount("talik-test", path.c_str(), "tmpfs", 0, ("size=" + size).c_str()) == 0;
        why_ = std::strerror(errno);
    }
    ~TinyDisk() {
        if (mounted_) umount2(path_.c_str(), MNT_DETACH);
    }
    TinyDisk(const TinyDisk&) = delete;
    TinyDisk& operator=(const TinyDisk&) = delete;
    bool mounted() const { return mounted_; }
    const std::string& why() const { return why_; }

private:
    std::filesystem::path path_;
    bool mounted_ = false;
    std::string why_;
};

} // namespace talik::lockstep
