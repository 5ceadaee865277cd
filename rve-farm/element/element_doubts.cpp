#include "rve-farm/element/element_doubts.hpp"

#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "common/base/error.hpp"

namespace talik::farm {
namespace {

constexpr double warned = 0.05, refused = 0.5; // of the pressure; the servo holds it within 0.1 % up to the peak

// Which normal stress the path holds at the pressure: sxx, syy, or none.
std::optional<std::size_t> held_stress(const ElementTest& test) {
    if (test.path == "biaxial") return 0;
    if (test.path == "simple_shear" && !test.constant_height) return 1;
    return {};
}

struct Worst {
    std::size_t rve = 0;
    double pressure = 0.0, error = 0.0; // Pa; over the pressure asked for
};

Worst worst_pressure(const ElementTest& test, const std::vector<ElementCurve>& curves) {
    Worst worst;
    const auto held = held_stress(test);
    for (std::size_t i = 0; held && i < curves.size(); ++i) {
        const double pressure = -curves[i].back().answer.stress[*held]; // Pa, compression positive
        const double error = std::abs(pressure - test.pressure) / test.pressure;
        if (error > worst.error) worst = {i, pressure, error};
    }
    return worst;
}

std::string describe(const Worst& worst, const ElementTest& test) {
    return fmt::format("the pressure of {:.4g} Pa was not held: RVE {} ended at {:.4g} Pa", test.pressure, worst.rve, worst.pressure);
}

} // namespace

std::vector<std::string> doubts_before(const ElementTest& test, const std::vector<Packing>& packings) {
    if (!held_stress(test) || test.settle) return {};
    for (const Packing& packing : packings)
        if (packing.pressure > 0.0 && std::abs(packing.pressure - test.pressure) > 0.01 * test.pressure)
            return {fmt::format("a packing was prepared at {:.4g} Pa, the test holds {:.4g} Pa: it starts with a jump (settle = true brings it there first)", packing.pressure, test.pressure)};
    return {};
}

std::vector<std::string> doubts_after(const ElementTest& test, const std::vector<ElementCurve>& curves) {
    const Worst worst = worst_pressure(test, curves);
    if (worst.error <= warned || worst.error > refused) return {};
    return {describe(worst, test) + " (take a lower rate, more discs, or a smaller step)"};
}

void refuse_nonsense(const ElementTest& test, const std::vector<ElementCurve>& curves) {
    for (std::size_t i = 0; i < curves.size(); ++i)
        for (const ElementRow& row : curves[i])
            if (!(row.answer.void_ratio >= 0.0))
                fail(ExitCode::failed, fmt::format("the void ratio of RVE {} fell to {:.3g} at macro step {}: discs overlap beyond the sense of the contact law", i, row.answer.void_ratio, row.step),
                     "take a smaller strain or pressure, or a larger normal_stiffness");
    const Worst worst = worst_pressure(test, curves);
    if (!(worst.error <= refused)) fail(ExitCode::failed, describe(worst, test), "take a lower rate, more discs, or a smaller step; the curves are kept as they are");
}

} // namespace talik::farm
