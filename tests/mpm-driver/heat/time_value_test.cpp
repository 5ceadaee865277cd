#include "mpm-driver/heat/time_value.hpp"

#include <cmath>

#include "common/io/text_file.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/temporary_file.hpp"

using namespace talik;
using namespace talik::driver;

TEST_CASE("the mean of a value over steps is the same however the time is cut", "[heat]") {
    TimeValueSpec sine;
    sine.constant = -2.0;
    sine.amplitude = 10.0;
    sine.period = 7.0;
    sine.shift = 1.3;
    const std::string file = test_file("times.csv");
    write_file_atomically(file, "time_s,value\n1,5\n2,-3\n2,4\n6,0\n");
    TimeValueSpec table;
    table.file = file;
    for (const TimeValueSpec& spec : {sine, table}) {
        const TimeValue value(spec, "test");
        double sum = 0.0, time = 0.0;
        for (int k = 1; k <= 37; ++k) {
            const double next = 8.0 * std::pow(k / 37.0, 1.3);
            sum += (next - time) * value.mean(time, next);
            time = next;
        }
        CHECK(sum / 8.0 == Approx(value.mean(0.0, 8.0)).epsilon(1e-13));
        CHECK(value.mean(3.0, 3.0 + 1e-9) == Approx(value.at(3.0)).epsilon(1e-8));
    }
    // Before the first row its value; straight between rows; a jump at 2 s: 5 + 1 + (4 + 0)/2 * 4, then 0 for 2 s
    CHECK(TimeValue(table, "test").mean(0.0, 8.0) == Approx((5.0 + 1.0 + 8.0 + 0.0) / 8.0));
    CHECK(TimeValue(sine, "test").mean(0.0, 7.0) == Approx(-2.0));
    CHECK(TimeValue(sine, "test").at(1.3 + 7.0 / 4.0) == Approx(8.0));
}
