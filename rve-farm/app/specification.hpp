#pragma once
// Specifications of rve-farm in TOML: what `pack` and `element` read, from the same tables of keys as the driver's scenes.
#include <string>
#include <vector>

#include "common/packing/packing_spec.hpp"
#include "rve-farm/element/element_test.hpp"

namespace talik::farm {

struct ElementSpec {
    std::string title;
    RveSpec rve;
    ElementTest test;
};

// Each throws one Error with the first fault and the number of the others. `dump`: the checked content as TOML.
RveSpec read_pack_specification(const std::string& file, const std::vector<std::string>& overrides, std::string& dump);
ElementSpec read_element_specification(const std::string& file, const std::vector<std::string>& overrides, std::string& dump);
std::string pack_help();
std::string element_help();

} // namespace talik::farm
