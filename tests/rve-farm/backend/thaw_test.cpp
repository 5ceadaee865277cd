// What thaw and frost do to the bonds of an RVE, through the column that the driver sends.
#include <algorithm>
#include <cmath>
#include <vector>

#include "rve-farm/backend/farm.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/rve_samples.hpp"

using namespace talik;
using namespace talik::farm;

namespace {

constexpr double strength = 1e7; // c_n = c_t, Pa

RveParameters bonded(bool rebond) {
    RveParameters parameters;
    parameters.bond = BondParameters{strength, strength, 1.0, rebond, 0.5};
    return parameters;
}

const std::array<double, 4> nothing = {0, 0, 0, 0};

// A frozen RVE, sheared and pulled a little, so that its bonds carry tension and shear, and come to rest.
Farm strained(const RveParameters& parameters) {
    Farm farm(parameters, {samples::disordered(100)}, {0});
    farm.activate_bonds();
    for (int k = 0; k < 20; ++k) samples::step(farm, {1.5e-3, 1e-3, 0, 5e-4}, 1e-3);
    for (int k = 0; k < 100; ++k) samples::step(farm, nothing, 1e-3);
    return farm;
}

// The S_i below which each bond breaks, Eqs. (6)-(8): max(tension / (beta_a c_n r^2), |f_t| / (beta_a c_t r^2)), in order.
std::vector<double> critical_saturations(const Farm& farm) {
    const AssemblyView& s = farm.assembly(0).view();
    std::vector<double> critical;
    for (int c = 0; c < s.contact_count(); ++c) {
        if (s.bonded[c] == 0) continue;
        const double radius = std::min(s.radius[s.first[c]], s.radius[s.second[c]]);
        const double normal = farm.parameters().contact.normal_stiffness * geometry_of(s, c).overlap; // f_n, N, > 0 in compression
        critical.push_back(std::max({0.0, -normal, std::abs(s.tangential_force[c])}) / (strength * radius * radius));
    }
    std::sort(critical.begin(), critical.end());
    return critical;
}

} // namespace

TEST_CASE("thaw at constant strain breaks exactly the bonds whose force exceeds the lowered strength", "[eq6][eq7][eq8]") {
    Farm farm = strained(bonded(false));
    const std::vector<double> critical = critical_saturations(farm);
    REQUIRE(critical.size() > 100);
    REQUIRE(critical.back() < 1.0);
    REQUIRE(critical[critical.size() / 2] > 1e-3); // the bonds do carry something
    // In the widest gap between two bonds' critical saturations of the upper half: there the little that forces still
    // change in one sub-step of an RVE at rest cannot move a bond across.
    std::size_t weakest = critical.size() / 2;
    for (std::size_t k = weakest; k + 1 < critical.size(); ++k)
        if (critical[k + 1] - critical[k] > critical[weakest + 1] - critical[weakest]) weakest = k;
    const double saturation = 0.5 * (critical[weakest] + critical[weakest + 1]);
    const Answer before = farm.measure(0);
    const Answer after = samples::step(farm, nothing, 1e-6, 1, saturation); // one sub-step: nothing has time to follow
    CHECK(after.bonds == static_cast<int>(weakest) + 1);
    CHECK(after.broken_bonds - before.broken_bonds == static_cast<int>(critical.size() - weakest) - 1);
    CHECK(after.bond_dissipation > before.bond_dissipation);
}

TEST_CASE("full thaw breaks every bond that carries tension or shear, and leaves those in pure compression", "[eq6][eq8]") {
    Farm farm = strained(bonded(false));
    const std::vector<double> critical = critical_saturations(farm);
    const auto loaded = std::count_if(critical.begin(), critical.end(), [](double s) { return s > 1e-9; });
    const Answer after = samples::step(farm, nothing, 1e-6, 1, 0.0);
    CHECK(after.bonds <= static_cast<int>(critical.size()) - static_cast<int>(loaded));
}

TEST_CASE("ground that freezes again is bonded anew only where the scene says so, at the contacts present", "[eq8][rebond]") {
    for (const bool rebond : {false, true}) {
        INFO("rebond_on_freezing " << rebond);
        Farm farm = strained(bonded(rebond));
        samples::step(farm, {-2e-3, 0, 0, -2e-3}, 1e-3, 0, 0.0); // thaws under compression
        const Answer thawed = samples::step(farm, nothing, 1e-3, 0, 0.49);
        const Answer frozen = samples::step(farm, nothing, 1e-3, 0, 0.5); // the threshold itself counts
        const int formed = frozen.bonds + frozen.broken_bonds - thawed.bonds - thawed.broken_bonds;
        REQUIRE(thawed.contacts > thawed.bonds + 50);
        CHECK(formed == (rebond ? thawed.contacts - thawed.bonds : 0));
    }
}

TEST_CASE("an RVE that never thawed does not bond anew, whatever breaks by load", "[rebond]") {
    Farm farm = strained(bonded(true));
    for (int k = 0; k < 20; ++k) samples::step(farm, {0, 2e-2, 0, 0}, 1e-3); // shear that breaks bonds
    const Answer broken = farm.measure(0);
    REQUIRE(broken.broken_bonds > 0);
    for (int k = 0; k < 5; ++k) CHECK(samples::step(farm, nothing, 1e-3, 0, k % 2 ? 0.6 : 1.0).bonds <= broken.bonds);
}

TEST_CASE("the memory of a thaw is saved with the RVE, so that a restart bonds anew at the same step", "[rebond][checkpoint]") {
    Farm farm = strained(bonded(true)), other = strained(bonded(true));
    samples::step(farm, {-2e-3, 0, 0, -2e-3}, 1e-3, 0, 0.0);
    std::vector<std::byte> bytes;
    farm.save(0, bytes);
    REQUIRE(other.load(0, bytes) == bytes.size());
    samples::step(farm, nothing, 1e-3, 0, 0.7);
    samples::step(other, nothing, 1e-3, 0, 0.7);
    CHECK(farm.measure(0).bonds > 0);
    CHECK(samples::same_bits(farm, 0, other, 0));
}
