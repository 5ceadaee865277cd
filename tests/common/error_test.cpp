#include "common/base/error.hpp"
#include "tests/support/catch.hpp"

using namespace talik;

TEST_CASE("an error is one line that names place, problem and remedy") {
    const Error e(ExitCode::bad_input, "scene.toml:3: contact.friction", "is negative", "give a value >= 0");
    CHECK(std::string(e.what()) == "scene.toml:3: contact.friction: is negative (give a value >= 0)");
}

TEST_CASE("an error stays one line whatever a user's value holds") {
    const Error e(ExitCode::bad_input, "s.toml:3: a\nb", "\"1\tm\r\n\" is \x1b[31mred\x7f", "take \"ü\"");
    CHECK(std::string(e.what()) == R"(s.toml:3: a\nb: "1\tm\r\n" is \u001B[31mred\u007F (take "ü"))");
}

TEST_CASE("require throws a bad-input error only where the condition fails") {
    CHECK_NOTHROW(require(true, "p", "r"));
    CHECK_THROWS_AS(require(false, "p", "r"), Error);
}
