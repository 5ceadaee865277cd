#pragma once
// Where things are, seen from the running program: a build folder or an installation at any prefix.
#include <filesystem>
#include <string>

namespace talik {

// A program of Talik, beside this one.
std::filesystem::path sibling_program(const std::string& name);

// A file as given; where there is none of that name, the shipped case that it names: "cases/biaxial/dense.toml",
// "biaxial/dense.toml" or "biaxial/dense". As given where there is no such case either.
std::string find_case(const std::string& name);

} // namespace talik
