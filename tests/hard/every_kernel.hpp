#pragma once
// Each hard case of an RVE runs on every kernel of this machine: all instruction levels, both precisions.
#include <string>
#include <vector>

#include "tests/support/rve_samples.hpp"

namespace talik::hard {

struct KernelChoice {
    farm::Level level;
    farm::Precision precision;

    std::string name() const { return std::string(farm::name_of(level)) + " " + farm::name_of(precision); }
    bool single() const { return precision == farm::Precision::single_; }
    farm::FarmOptions options() const {
        farm::FarmOptions options;
        options.threads = 1;
        options.level = level;
        options.precision = precision;
        return options;
    }
    farm::Farm farm_of(const RveParameters& parameters, const Packing& packing) const { return farm::Farm(parameters, {packing}, {0}, options()); }
};

inline std::vector<KernelChoice> every_kernel() {
    std::vector<KernelChoice> all;
    for (farm::Level level : farm::levels_of_this_machine())
        for (farm::Precision precision : {farm::Precision::double_, farm::Precision::single_}) all.push_back({level, precision});
    return all;
}

} // namespace talik::hard
