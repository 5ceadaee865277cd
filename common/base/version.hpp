#pragma once
// What this build is: printed by --version, written into every file.
#include <string>

namespace talik {

std::string version();                                // "0.1.0"
std::string build_facts(const std::string& program);  // several lines: version, commit, compiler, backends, libraries
std::string code_that_packs();                        // other code, other bits of a packing: part of its name in the cache

} // namespace talik
