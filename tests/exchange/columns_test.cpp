#include "exchange/columns.hpp"
#include "common/physics/rve_columns.hpp"
#include "exchange/hello.hpp"
#include "tests/exchange/support.hpp"
#include "tests/support/catch.hpp"

using namespace talik;
using namespace talik::exchange;
using namespace talik::exchange::test;

namespace {
Hello farm_hello() {
    Hello hello;
    hello.role = Role::farm;
    hello.program = "test-farm";
    hello.request_columns = rve_columns::requests();
    hello.answer_columns = rve_columns::answers();
    return hello;
}
} // namespace

TEST_CASE("A table lays its columns one behind the other", "[exchange][columns]") {
    const ColumnTable table({rve_columns::stress, rve_columns::status, rve_columns::work});
    CHECK(table.size() == 3);
    CHECK(table.components() == 5);
    CHECK(table.first_component(0) == 0);
    CHECK(table.first_component(1) == 3);
    CHECK(table.first_component(2) == 4);
    CHECK(table.index("work") == 2);
    CHECK(table.index("colour") == -1);
}

TEST_CASE("A column named twice, or without components, is refused", "[exchange][columns]") {
    CHECK_THROWS_AS(ColumnTable({rve_columns::stress, rve_columns::stress}), Error);
    CHECK_THROWS_AS(ColumnTable({Column{"nothing", 0, "1", ""}}), Error);
}

TEST_CASE("A subset of what is offered agrees, in any order", "[exchange][columns]") {
    Hello driver = driver_hello();
    std::swap(driver.answer_columns[0], driver.answer_columns[2]);
    CHECK_NOTHROW(check_agreement(driver, farm_hello()));
}

TEST_CASE("Every mismatch of the columns is named, field by field and all at once", "[exchange][columns]") {
    Hello driver = driver_hello();
    driver.answer_columns = {Column{"stress", 4, "kPa", ""}, rve_columns::status, Column{"colour", 1, "1", ""}};
    driver.dimension = 3;
    ExitCode code = ExitCode::done;
    const std::string text = error_text([&] { check_agreement(driver, farm_hello()); }, &code);
    CHECK(code == ExitCode::bad_input);
    CHECK(contains(text, "'stress': components: 4 asked for, 3 offered; unit: 'kPa' asked for, 'Pa' offered"));
    CHECK(contains(text, "column 'colour' is asked for, but not offered"));
    CHECK(contains(text, "dimension: the driver has 3, the farm 2"));
}

TEST_CASE("The mandatory columns cannot be left out", "[exchange][columns]") {
    Hello driver = driver_hello();
    driver.request_columns = {rve_columns::ice_saturation};
    driver.answer_columns = {rve_columns::stress};
    const std::string text = error_text([&] { check_agreement(driver, farm_hello()); });
    CHECK(contains(text, "column 'displacement_gradient_increment' is mandatory"));
    CHECK(contains(text, "column 'status' is mandatory"));
}

TEST_CASE("The layout hash tells order, shape and unit apart, and overlooks what columns mean", "[exchange][columns]") {
    const ColumnTable request(mandatory_request_columns());
    const auto hash = [&](std::vector<Column> answer) { return layout_hash(request, ColumnTable(std::move(answer))); };
    const auto base = hash({rve_columns::stress, rve_columns::status});
    CHECK(hash({rve_columns::status, rve_columns::stress}) != base);
    CHECK(hash({Column{"stress", 3, "kPa", ""}, rve_columns::status}) != base);
    CHECK(hash({Column{"stress", 4, "Pa", ""}, rve_columns::status}) != base);
    CHECK(hash({Column{"stress", 3, "Pa", "in other words"}, rve_columns::status}) == base);
}

TEST_CASE("A hello arrives as it was sent", "[exchange][columns]") {
    const Hello sent = driver_hello();
    const Hello got = decode_hello(encode(sent));
    CHECK(got.program == sent.program);
    CHECK(got.run_id == sent.run_id);
    CHECK(got.epoch == sent.epoch);
    CHECK(got.scene_hash == sent.scene_hash);
    CHECK(got.request_columns == sent.request_columns);
    CHECK(got.answer_columns == sent.answer_columns);
    CHECK(got.answer_columns[0].meaning == sent.answer_columns[0].meaning);
}

TEST_CASE("A hello cut short anywhere is an error, never a crash", "[exchange][columns]") {
    const std::vector<std::byte> whole = encode(driver_hello());
    for (std::size_t size = 0; size < whole.size(); ++size)
        CHECK_THROWS_AS(decode_hello(std::span(whole).first(size)), Error);
    std::vector<std::byte> longer = whole;
    longer.push_back(std::byte{0});
    CHECK_THROWS_AS(decode_hello(longer), Error);
}
