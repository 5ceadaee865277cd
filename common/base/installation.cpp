#include "common/base/installation.hpp"

namespace talik {

namespace fs = std::filesystem;

fs::path sibling_program(const std::string& name) { return fs::read_symlink("/proc/self/exe").parent_path() / name; }

std::string find_case(const std::string& name) {
    std::error_code none;
    if (name.empty() || fs::exists(name, none) || fs::path(name).is_absolute()) return name;
    const fs::path shipped = sibling_program("..").lexically_normal() / "share" / "talik"; // of an installation
    for (const char* folder : {"", "cases"})
        for (const char* ending : {"", ".toml"})
            if (const fs::path candidate = shipped / folder / (name + ending); fs::is_regular_file(candidate, none)) return candidate.string();
    return name;
}

} // namespace talik
