#pragma once
// The text of the error that a piece of code ends in; empty where it ends well.
#include <string>

#include "common/base/error.hpp"

namespace talik::driver::tests {

template <class Work>
std::string fault_of(Work&& work) {
    try {
        work();
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

inline bool says(const std::string& message, const std::string& words) { return message.find(words) != std::string::npos; }

} // namespace talik::driver::tests
