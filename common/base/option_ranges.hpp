#pragma once
// Ranges of command-line options, said in words: the ready-made ones print 300 digits and let "nan" pass.
#include <CLI/CLI.hpp>

#include <cmath>
#include <cstdlib>
#include <string>

namespace talik {

inline CLI::Validator option_range(const std::string& wanted, bool (*holds)(double)) {
    return CLI::Validator([=](std::string& text) {
        char* end = nullptr;
        const double value = std::strtod(text.c_str(), &end);
        const bool sound = !text.empty() && *end == '\0' && std::isfinite(value) && holds(value);
        return sound ? std::string() : "must be " + wanted + ", not \"" + text + "\"";
    }, "", wanted);
}

inline CLI::Validator above_zero() { return option_range("a number > 0", [](double v) { return v > 0.0; }); }
inline CLI::Validator thread_count() { return option_range("a whole number from 0 to 4096", [](double v) { return v >= 0.0 && v <= 4096.0 && v == std::floor(v); }); }
inline CLI::Validator not_empty() {
    return CLI::Validator([](std::string& text) { return text.empty() ? std::string("must not be empty") : std::string(); }, "", "not_empty");
}

} // namespace talik
