#include "common/base/progress.hpp"
#include "tests/support/catch.hpp"

#include <cmath>
#include <limits>

using namespace talik;

TEST_CASE("durations are told in the units a person would take, and nonsense is not told as a number") {
    CHECK(readable_duration(0.2) == "0 s");
    CHECK(readable_duration(61.0) == "1 min 01 s");
    CHECK(readable_duration(3.0 * 3600 + 5 * 60) == "3 h 05 min");
    for (const double endless : {1e11, 1e300, std::numeric_limits<double>::infinity(), std::nan("")}) CHECK(readable_duration(endless) == "centuries");
}
