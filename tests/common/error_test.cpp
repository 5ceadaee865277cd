#include "common/base/error.hpp"
#include "tests/support/catch.hpp"

using namespace talik;

TEST_CASE("an error is one line that names place, problem and remedy") {
    const Error e(ExitCode::bad_input, "scene.toml:3: contact.friction", "is negative", "give a value >= 0");
    CHECK(std::string(e.what()) == "scene.toml:3: contact.friction: is negative (give a value >= 0)");
}

TEST_CASE("require throws a bad-input error only where the condition fails") {
    CHECK_NOTHROW(require(true, "p", "r"));
    CHECK_THROWS_AS(require(false, "p", "r"), Error);
}
