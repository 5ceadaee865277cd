#include "common/packing/farm_setup.hpp"

#include "common/base/error.hpp"
#include "tests/support/catch.hpp"

using namespace talik;

TEST_CASE("the setup of a farm travels whole: bonds with their memory of thaw, packings with the stress of their depth") {
    FarmSetup sent;
    sent.parameters.bond = BondParameters{1e6, 2e6, 0.7, true, 0.3};
    Packing packing;
    packing.x = packing.y = {0.25, 0.75};
    packing.radius = {0.1, 0.2};
    packing.vertical_stress = 2e4, packing.lateral_stress = 9e3;
    packing.contacts = {{0, 1, {1, -1}, 3.0, true}};
    sent.packings = {packing};
    sent.packing_of_rve = {0, 0, 0};
    const auto bytes = encode(sent);
    const FarmSetup got = decode_farm_setup(bytes);
    REQUIRE(got.parameters.bond);
    CHECK(got.parameters.bond->strength_factor == 0.7);
    CHECK(got.parameters.bond->rebond_on_freezing);
    CHECK(got.parameters.bond->rebond_ice_saturation == 0.3);
    REQUIRE(got.packings.size() == 1);
    CHECK(got.packings[0].vertical_stress == 2e4);
    CHECK(got.packings[0].lateral_stress == 9e3);
    CHECK(got.packings[0].contacts[0].tangential_force == 3.0);
    CHECK(got.packings[0].contacts[0].bonded);
    CHECK(got.packing_of_rve == sent.packing_of_rve);
    CHECK_THROWS_AS(decode_farm_setup(std::span(bytes).first(bytes.size() - 1)), Error);
}
