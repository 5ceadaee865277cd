#pragma once
// A schema as text: help on a terminal, and a page of the documentation.
#include <string>
#include <vector>

namespace talik::scene {

enum class Shape { always, optional, list }; // [table], [table] present = on, [[table]]

struct RowText {
    std::string name;
    std::string kind;     // "pressure (Pa, kPa, MPa, GPa)", "whole number", ...
    std::string standard; // the default; empty = none
    std::string range;    // empty = any
    std::string meaning;
    bool required = false;
    bool inner = false; // a table inside: described in a section of its own
};

struct Section {
    std::string path; // "rve.packing"; empty = the root
    Shape shape = Shape::always;
    std::string meaning;
    std::vector<RowText> rows;
};

std::string help_text(const std::vector<Section>& sections);
std::string markdown(const std::string& title, const std::string& introduction, const std::vector<Section>& sections);

} // namespace talik::scene
