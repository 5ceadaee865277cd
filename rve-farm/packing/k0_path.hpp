#pragma once
// Packings at the stress of their depth: snapshots along one K0 compression, as ground is loaded by what is laid upon it.
#include <vector>

#include "common/packing/packing.hpp"
#include "common/packing/packing_spec.hpp"

namespace talik::farm {

// `start`, at rest at its isotropic pressure, is compressed vertically without lateral strain. Whenever the vertical stress
// has come to the next of spec.packing.k0->stresses() the packing is brought to rest there (vertical and shear stress within
// 0.1 %, unbalanced force below 1e-4 of the mean contact force, over ten macro steps) and kept, tangential forces
// included; then the same packing goes on. So the snapshots are states of one history, not packings of their own.
std::vector<Packing> k0_snapshots(const RveSpec& spec, const Packing& start);

} // namespace talik::farm
