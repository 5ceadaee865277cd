#include "common/scene/units.hpp"

#include <cstdlib>

#include "tests/support/text.hpp"

using namespace talik::scene;

TEST_CASE("a quantity with a unit is the SI value to the last bit") {
    CHECK(read_quantity("100 kPa", Dimension::pressure).value == 1e5);
    CHECK(read_quantity("2.5 mm", Dimension::length).value == 2.5e-3);
    CHECK(read_quantity("0.1mm", Dimension::length).value == 0.1e-3);
    CHECK(read_quantity("20 d", Dimension::time).value == 20.0 * 86400.0);
    CHECK(read_quantity("1e6 N/m", Dimension::stiffness).value == 1e6);
    CHECK(read_quantity(" -0.02 m/s ", Dimension::velocity).value == -0.02);
    CHECK(read_quantity("1.2e-2 MPa", Dimension::pressure).value == 1.2e4);
    CHECK(read_quantity("30 mm/min", Dimension::velocity).value == Approx(5e-4).epsilon(1e-15)); // one rounding of the division
    CHECK(read_quantity("15 %", Dimension::none).value == 0.15);
}

TEST_CASE("a bare number means SI") {
    for (const auto dimension : {Dimension::length, Dimension::pressure, Dimension::none})
        CHECK(read_quantity("0.3", dimension).value == 0.3);
}

TEST_CASE("a quantity of another dimension is refused, with the units that are accepted") {
    const auto read = read_quantity("100 kPa", Dimension::length);
    CHECK_CONTAINS(read.problem, "\"100 kPa\" is a pressure, not a length");
    CHECK_CONTAINS(read.remedy, "m, mm, cm");
}

TEST_CASE("an unknown unit and a text without a number are refused") {
    CHECK_CONTAINS(read_quantity("3 furlong", Dimension::length).problem, "unknown unit \"furlong\"");
    for (const std::string text : {"", "kPa", "nan", "inf Pa", "0x10 Pa", "1e999 Pa"})
        CHECK_FALSE(read_quantity(text, Dimension::pressure).problem.empty());
}

TEST_CASE("every unit is read as one SI unit times a positive factor, in its own dimension only") {
    const auto dimensions = {Dimension::length, Dimension::time, Dimension::velocity, Dimension::acceleration, Dimension::pressure,
                             Dimension::force, Dimension::stiffness, Dimension::density, Dimension::rate, Dimension::angle};
    for (const auto own : dimensions) {
        CHECK(read_quantity("2 " + std::string(si_unit(own)), own).value == 2.0);
        for (const auto unit : accepted_units(own)) {
            const std::string text = "2 " + std::string(unit);
            for (const auto other : dimensions) CHECK(read_quantity(text, other).problem.empty() == (own == other));
            CHECK(read_quantity(text, own).value > 0.0);
        }
    }
}
