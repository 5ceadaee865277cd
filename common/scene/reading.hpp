#pragma once
// Reading one value of a document into a variable; what is wrong with it becomes a fault, and reading goes on, so that one
// pass names every fault of a file.
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "common/scene/toml_document.hpp"
#include "common/scene/units.hpp"

namespace talik::scene {

struct Fault {
    std::string position, key, problem, remedy; // "scene.toml:12", "domain.cell"
    std::string text() const;                   // "FILE:LINE: KEY: what is wrong (what to do)"
};
using Faults = std::vector<Fault>;

// Throws the first fault as an Error; how many more there are stands in its remedy.
void throw_if_any(const Faults& faults, const std::string& how_to_list_all);

struct Range {
    double least = -std::numeric_limits<double>::infinity(), most = std::numeric_limits<double>::infinity();
    bool above_least = false; // > instead of >=
    bool holds(double value) const { return (above_least ? value > least : value >= least) && value <= most; }
    std::string text(std::string_view unit = "") const; // "> 0 m", "in (0, 1]"; empty = any
};
inline Range any() { return {}; }
inline Range positive() { return {.least = 0.0, .above_least = true}; }
inline Range not_negative() { return {.least = 0.0}; }
inline Range at_least(double least) { return {.least = least}; }
inline Range between(double least, double most) { return {.least = least, .most = most}; }

// Each returns whether the value was sound; `out` is untouched otherwise.
bool read(const Value&, const std::string& key, Dimension, const Range&, double& out, Faults&);
bool read_whole(const Value&, const std::string& key, const Range&, std::int64_t& out, Faults&);
bool read(const Value&, const std::string& key, bool& out, Faults&);
bool read(const Value&, const std::string& key, std::string& out, Faults&);
bool read(const Value&, const std::string& key, const std::vector<std::string>& choices, std::string& out, Faults&);
bool read(const Value&, const std::string& key, const std::vector<std::string>& choices, std::vector<std::string>& out, Faults&);
// A list of quantities of one dimension; count 0 = any number.
bool read(const Value&, const std::string& key, Dimension, const Range&, std::size_t count, std::vector<double>& out, Faults&);

bool wrong_kind(const Value&, const std::string& key, const std::string& wanted, Faults&); // adds the fault; false
std::string nearest(const std::string& word, const std::vector<std::string>& known);       // empty = none is near
std::string joined(const std::string& path, const std::string& name);                      // "a.b"; "b" at the root

// Values as TOML text, so that reading them returns the same bits.
std::string literal(double);
std::string literal(const std::string&);
std::string literal(bool);
std::string fingerprint(const std::string& text); // 16 hexadecimal digits of the 64-bit FNV-1a hash

} // namespace talik::scene
