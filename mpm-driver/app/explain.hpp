#pragma once
// mpm-driver explain: what a scene calls for and what it will cost, without a run.
#include <string>
#include <vector>

namespace talik::driver {

int explain(const std::string& scene, const std::vector<std::string>& set, int threads);

} // namespace talik::driver
