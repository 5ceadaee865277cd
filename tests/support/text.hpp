#pragma once
// Texts in tests, in the words that Catch2 2.13 and 3 share.
#include <string>

#include "tests/support/catch.hpp"

inline bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

// Shows the whole text where the part is missing.
#define CHECK_CONTAINS(text, part)          \
    do {                                    \
        const std::string text_seen = text; \
        CAPTURE(text_seen);                 \
        CHECK(contains(text_seen, part));   \
    } while (false)
