#include "rve-farm/packing/k0_path.hpp"

#include <fmt/format.h>

#include "common/base/error.hpp"
#include "rve-farm/packing/press.hpp"

namespace talik::farm {

std::vector<Packing> k0_snapshots(const RveSpec& spec, const Packing& start) {
    ensure(spec.packing.k0.has_value());
    Press press(spec, start, spec.parameters.contact.friction);
    std::vector<Packing> snapshots;
    for (const double vertical : spec.packing.k0->stresses()) {
        press.compress_laterally_held(vertical);
        require(press.settle({}), fmt::format("rve.packing.k0: the packing of seed {} does not come to rest at a vertical stress of {:.3g} Pa", start.seed, vertical),
                "take more discs, or another range of stresses");
        Packing snapshot = press.at_rest(spec.packing.pressure, start.seed);
        snapshot.vertical_stress = -press.state().stress[1];
        snapshot.lateral_stress = -press.state().stress[0]; // K0 is their ratio
        snapshots.push_back(std::move(snapshot));
    }
    return snapshots;
}

} // namespace talik::farm
