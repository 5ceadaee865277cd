#pragma once
// A hard case: what could go wrong, what must hold all the same, the bound and where it comes from. What is measured goes
// to stdout, a line for each figure, which tools/hard-cases gathers into the table of docs/hard-cases.md.
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

#include "tests/support/catch.hpp"

namespace talik::hard {

// Errors of rounding of a relative size that add up like steps of a random walk: four standard deviations of so many of them.
inline double rounding_walk(double unit, double count) { return 4.0 * unit * std::sqrt(count); }
constexpr double unit_double = 1.1e-16, unit_single = 6e-8;

// What must hold: a figure that may not exceed its bound.
struct Invariant {
    const char* what;   // with its unit
    double bound;
    const char* because; // where the bound comes from
};

class HardCase {
public:
    HardCase(const char* area, const char* name, const char* danger) : area_(area), name_(name), danger_(danger) {}

    // variant: kernel, size, ... of this measurement; the table keeps the worst of all.
    void holds(const Invariant& invariant, double figure, const std::string& variant = "") {
        report(invariant, figure, variant);
        INFO(name_ << " " << variant << ": " << invariant.what << ": " << figure << ", bound " << invariant.bound);
        CHECK((std::isfinite(figure) && figure <= invariant.bound));
    }
    // The other way round: without a safeguard the case must fail by the same invariant.
    void fails_without(const char* safeguard, const Invariant& invariant, double figure, const std::string& variant = "") {
        print("without", invariant, figure, variant, safeguard);
        INFO(name_ << " " << variant << " without " << safeguard << ": " << invariant.what << ": " << figure << ", bound " << invariant.bound);
        CHECK(!(std::isfinite(figure) && figure <= invariant.bound));
    }

private:
    void report(const Invariant& invariant, double figure, const std::string& variant) const { print("case", invariant, figure, variant, ""); }
    void print(const char* kind, const Invariant& invariant, double figure, const std::string& variant, const char* safeguard) const {
        const double margin = figure > 0 ? invariant.bound / figure : HUGE_VAL; // how many times more would have been borne
        std::printf("hard-%s\t%s\t%s\t%s\t%s\t%.6g\t%.6g\t%.4g\t%s\t%s\t%s\n", kind, area_, name_, danger_, invariant.what, figure, invariant.bound, margin,
                    invariant.because, variant.c_str(), safeguard);
        std::fflush(stdout);
    }

    const char *area_, *name_, *danger_;
};

} // namespace talik::hard
