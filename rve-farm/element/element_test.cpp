#include "rve-farm/element/element_test.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "common/base/error.hpp"
#include "rve-farm/backend/farm.hpp"
#include "rve-farm/element/servo.hpp"
#include "rve-farm/element/status_words.hpp"

namespace talik::farm {
namespace {

ServoTargets targets_of(const ElementTest& test) {
    using T = ComponentTarget;
    if (test.path == "isotropic") return {T::rate(-test.rate), T::rate(-test.rate), T::rate(0.0)};
    if (test.path == "biaxial") return {T::stress(-test.pressure), T::rate(-test.rate), T::rate(0.0)};
    if (test.path == "isochoric") return {T::rate(test.rate), T::rate(-test.rate), T::rate(0.0)};
    ensure(test.path == "simple_shear"); // gamma' = 2 D_xy, with the spin that leaves planes y = constant where they are
    return {T::rate(0.0), test.constant_height ? T::rate(0.0) : T::stress(-test.pressure), T::rate(0.5 * test.rate), -0.5 * test.rate};
}

// Many RVEs along one path, each with a servo of its own.
class Bench {
public:
    Bench(const ElementTest& test, const RveParameters& parameters, const std::vector<Packing>& packings, const FarmOptions& options)
        : test_(test), farm_(parameters, packings, one_each(packings.size()), options), ids_(packings.size()), increments_(4 * packings.size()),
          ice_(parameters.bond ? packings.size() : 0, test.ice_saturation), answers_(packings.size()), strains_(4 * packings.size(), 0.0) {
        std::iota(ids_.begin(), ids_.end(), 0u);
        for (std::size_t i = 0; i < ids_.size(); ++i) answers_[i] = farm_.measure(static_cast<int>(i));
    }

    void make_ready() {
        for (int id = 0; id < farm_.size(); ++id)
            if (test_.forget_shear_forces) farm_.reset_tangential_forces(id);
        measure();
        if (test_.settle) settle();
        if (test_.activate_bonds) farm_.activate_bonds();
        measure();
        std::fill(strains_.begin(), strains_.end(), 0.0);
        // With these gains a lateral stress of 100 kPa is held within 0.1 % up to the peak (measured, 200 discs at 0.1 1/s).
        servos_.assign(ids_.size(), Servo(targets_of(test_), std::max(1.0, 10.0 * test_.rate), 0.5, 0.05));
    }

    void step(double increment) {
        for (std::size_t i = 0; i < ids_.size(); ++i) {
            const auto gradient = servos_[i].next(answers_[i], increment);
            std::copy(gradient.begin(), gradient.end(), increments_.begin() + static_cast<std::ptrdiff_t>(4 * i));
            for (std::size_t c = 0; c < 4; ++c) strains_[4 * i + c] += gradient[c]; // logarithmic: the principal axes stay, or gamma
        }
        farm_.advance(ids_, increments_, ice_, increment, 0, answers_);
        ++steps_;
        for (std::size_t i = 0; i < ids_.size(); ++i)
            if (answers_[i].status != Status::ok)
                fail(ExitCode::failed, fmt::format("at macro step {} RVE {} {}", steps_, i, in_words(answers_[i])),
                     "take a smaller rve.time_step or a lower rate");
    }

    void record(std::vector<ElementCurve>& curves, long step, double time) const {
        for (std::size_t i = 0; i < ids_.size(); ++i)
            curves[i].push_back({step, time, strains_[4 * i], strains_[4 * i + 3], strains_[4 * i + 1] + strains_[4 * i + 2], answers_[i]});
    }

private:
    static std::vector<int> one_each(std::size_t count) {
        std::vector<int> each(count);
        std::iota(each.begin(), each.end(), 0);
        return each;
    }
    void measure() {
        for (std::size_t i = 0; i < ids_.size(); ++i) answers_[i] = farm_.measure(static_cast<int>(i));
    }

    // All stresses to the pressure, 0.1 % and an unbalanced force of 1e-4, held over ten macro steps by every RVE.
    void settle() {
        const ServoTargets isotropic{ComponentTarget::stress(-test_.pressure), ComponentTarget::stress(-test_.pressure), ComponentTarget::stress(0.0)};
        servos_.assign(ids_.size(), Servo(isotropic));
        const double increment = 10.0 * farm_.parameters().time_step;
        for (int lasting = 0, k = 0; lasting < 10; ++k) {
            require(k < 200000, "the RVEs do not come to rest under the pressure", "give the RVE some damping, or leave out `settle`");
            step(increment);
            bool at_rest = true;
            for (std::size_t i = 0; i < ids_.size(); ++i)
                at_rest = at_rest && servos_[i].error(answers_[i]) < 1e-3 * test_.pressure && answers_[i].unbalanced_force < 1e-4;
            lasting = at_rest ? lasting + 1 : 0;
        }
        for (int id = 0; id < farm_.size(); ++id) farm_.reset_velocities(id);
        steps_ = 0;
    }

    const ElementTest& test_;
    Farm farm_;
    std::vector<Servo> servos_;
    std::vector<std::uint32_t> ids_;
    std::vector<double> increments_, ice_;
    std::vector<Answer> answers_;
    std::vector<double> strains_; // xx xy yx yy of each RVE, summed displacement-gradient increments
    long steps_ = 0;
};

} // namespace

std::vector<ElementCurve> run_element_test(const ElementTest& test, const RveParameters& parameters, const std::vector<Packing>& packings,
                                           const FarmOptions& options, const std::function<void(double)>& progress) {
    Bench bench(test, parameters, packings, options);
    bench.make_ready();
    std::vector<ElementCurve> curves(packings.size());
    bench.record(curves, 0, 0.0);
    // Whole steps that end at the strain asked for; rows are evenly spaced.
    const double count = std::ceil(test.strain / (test.rate * test.step) * (1.0 - 1e-9));
    require(count <= 1e9, fmt::format("the strain of {:g} takes {:.3g} macro steps, more than 1e9", test.strain, count), "give a larger test.step or a higher test.rate");
    const long steps = std::max<long>(1, std::lround(count));
    const double increment = test.strain / (test.rate * static_cast<double>(steps));
    for (long k = 1; k <= steps; ++k) {
        bench.step(increment);
        const bool row = k * test.rows / steps != (k - 1) * test.rows / steps;
        if (row || k == steps) bench.record(curves, k, static_cast<double>(k) * increment);
        if (progress) progress(static_cast<double>(k) / static_cast<double>(steps));
    }
    return curves;
}

} // namespace talik::farm
