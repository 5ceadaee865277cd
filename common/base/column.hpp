#pragma once
// A named quantity that travels: a column of a batch of the exchange, a field of an output file.
#include <string>

namespace talik {

struct Column {
    std::string name;
    int components = 1;
    std::string unit;    // SI, "1" for a pure number
    std::string meaning; // with its sign convention; for people, not compared

    bool operator==(const Column& other) const {
        return name == other.name && components == other.components && unit == other.unit;
    }
};

} // namespace talik
