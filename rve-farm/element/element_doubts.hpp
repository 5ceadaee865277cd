#pragma once
// Whether an element test was the test that was asked for.
#include <string>
#include <vector>

#include "common/packing/packing.hpp"
#include "rve-farm/element/element_test.hpp"

namespace talik::farm {

// Before: packings prepared at another pressure than the one held start with a jump.
std::vector<std::string> doubts_before(const ElementTest& test, const std::vector<Packing>& packings);

// After: the pressure to be held was missed by more than 5 % at the end.
std::vector<std::string> doubts_after(const ElementTest& test, const std::vector<ElementCurve>& curves);

// Curves that mean nothing, as an Error with exit code 1: a negative void ratio, a held pressure missed by more than half.
void refuse_nonsense(const ElementTest& test, const std::vector<ElementCurve>& curves);

} // namespace talik::farm
