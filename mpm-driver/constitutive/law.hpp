#pragma once
// The law that answers strain increments with stresses: elastic, or a farm of RVEs behind the exchange.
// A step asks in two halves, so that a farm can have its batches in flight while the driver goes on: submit() hands over
// the increments and may return at once; collect() returns when every answer has been written.
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "mpm-driver/points/self_help.hpp"
#include "mpm-driver/points/points.hpp"

namespace talik::driver {

// What the driver asks. Columns are indexed by point id, and stay valid and unchanged until collect() has returned.
struct LawRequest {
    std::uint64_t step = 0;                                     // number of the macro step, from 1
    double time_increment = 0.0;                                // dt, s
    std::span<const std::uint32_t> ids;                         // the points asked for: any subset of the law's own
    const Matrix* displacement_gradient_increment = nullptr;    // dt grad v, -
    const double* volume = nullptr;                             // V_p at the start of the step, m^3
    const double* initial_volume = nullptr;                     // V_p^0, m^3
    const double* ice_saturation = nullptr;                     // S_i of Eq. (8), -; null where the scene has no heat
};

// Where the answers go. Columns are indexed by point id; a law writes the rows it was asked for and no others.
struct LawAnswer {
    Stress* stress = nullptr;         // in: at the start of the step; out: at its end. Pa, tension positive
    double* p_wave_modulus = nullptr; // M, Pa: wave speed sqrt(M/rho) of the step limit, Eq. (42)
    LawEnergy* energy = nullptr;      // J of the point (an RVE's energies times the point's initial volume over its own)
};

// Something rough that a law met in the step just collected, and what it did about it (self_help.hpp).
struct LawEvent {
    Help help;
    std::uint32_t point;
    double amount;
};

class Law {
public:
    virtual ~Law() = default;
    virtual std::string name() const = 0;

    // Once, before the first step: the law learns which points are its own and writes their initial answers.
    virtual void begin(std::span<const std::uint32_t> ids, const Points& points, LawAnswer initial) = 0;

    virtual void submit(const LawRequest& request, LawAnswer answer) = 0;
    virtual void collect() = 0;
    virtual std::span<const LawEvent> events() const { return {}; } // of the step collected last

    // A named effect of the scene's stages, such as "bonds", in those of `points` that are the law's own. False where the
    // law has no effect of that name.
    virtual bool activate(const std::string& /*effect*/, std::span<const std::uint32_t> /*points*/) { return false; }

    // State that the law keeps itself, in a folder of its own (a farm writes its files there).
    virtual void checkpoint(const std::string& /*folder*/) {}
    virtual void restore(const std::string& /*folder*/) {}

    // Further columns for output (coordination number, broken bonds, ...): a row per point of the scene, in id order;
    // rows of points with another law are 0.
    virtual std::vector<StateColumn> columns() { return {}; }
};

} // namespace talik::driver
