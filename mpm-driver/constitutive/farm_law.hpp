#pragma once
// The law whose stresses come from a farm of RVEs behind the exchange: one RVE for each of its points.
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/packing/farm_setup.hpp"
#include "exchange/farm_end.hpp"
#include "exchange/farm_group.hpp"
#include "exchange/recorder.hpp"
#include "mpm-driver/constitutive/law.hpp"

namespace talik::driver {

// Numbers that travel for an RVE in a step, there and back: what a recording holds. ice: S_i is sent as well.
int exchanged_components(bool ice);

class FarmLaw : public Law {
public:
    // setup.packing_of_rve is filled at begin(): packings are dealt out to the points in an order drawn from `seed`.
    FarmLaw(exchange::FarmGroup farms, exchange::Hello hello, FarmSetup setup, std::uint64_t seed);

    // Where the packings are snapshots of K0 paths: the vertical stress of the ground above a place, Pa, compression positive.
    void start_at_depth(std::function<double(const Vector&)> vertical_stress) { vertical_stress_ = std::move(vertical_stress); }

    // Before begin(): every request and answer is written there.
    void record(const std::string& file) { record_file_ = file; }

    std::string name() const override { return "rve"; }
    void begin(std::span<const std::uint32_t> ids, const Points& points, LawAnswer initial) override;
    void submit(const LawRequest& request, LawAnswer answer) override;
    void collect() override;
    std::span<const LawEvent> events() const override { return events_; }
    void leave_out_checks(bool out = true) { checks_ = !out; } // of answers: only for measuring what they cost
    bool activate(const std::string& effect, std::span<const std::uint32_t> points) override;
    void checkpoint(const std::string& folder) override;
    void restore(const std::string& folder) override;
    std::vector<StateColumn> columns() override;

    void bye();
    void keep_up() { farms_.keep_up(); } // between two steps
    const exchange::FarmGroup& farms() const { return farms_; }
    double recording_seconds() const { return recorder_ ? recorder_->seconds() : 0.0; } // of this thread
    double packing_seconds() const { return recorder_ ? recorder_->packing_seconds() : 0.0; } // of the recorder's, CPU
    exchange::LockstepTimes farm_times(); // asked of the farms: their mean
    double copying_seconds() const { return copying_; } // of this side, in steps, s
    double waiting_seconds() const { return waiting_; }
    double dem_time() const { return time_; } // that the RVEs have lived through, s
    double dem_time_step() const;  // dt / n of the latest macro step, s; 0 before the first
    const std::string& farm_program() const { return farm_program_; }
    std::int64_t rves() const { return static_cast<std::int64_t>(point_of_rve_.size()); }
    std::int64_t evaluations() const { return evaluations_; }
    std::int64_t rves_without_contacts() const; // that carry no contact force now
    std::int64_t split_steps() const; // over all RVEs, since the start

private:
    // Where each quantity stands among the components of the agreed answer columns.
    struct Components {
        int stress, status, stiffness, stored, kinetic, friction, damping, bond;
    };
    std::vector<std::byte> setup_for(std::span<const std::uint32_t> rves) const;
    void fill(std::span<const std::uint32_t> rows, exchange::Batch& chunk);
    void start_recording(const std::vector<double>& initial);
    class Timing;
    void take(std::uint32_t rve, const double* answer, LawAnswer out);
    void check_status(std::uint32_t rve, double status) const;
    void check_numbers(std::uint32_t rve, const double* answer) const;
    void watch(std::uint32_t point, const double* answer);

    exchange::FarmGroup farms_;
    exchange::Hello hello_;
    FarmSetup setup_;
    std::uint64_t seed_;
    std::string farm_program_;
    bool sends_ice_ = false; // bonds that thaw: S_i is a column of the requests
    std::function<double(const Vector&)> vertical_stress_;
    exchange::ColumnTable answer_columns_;
    Components at_{};

    std::vector<std::uint32_t> point_of_rve_, rve_of_point_;
    std::vector<double> scale_; // a point's initial volume over its RVE's, by RVE: energies of the RVE times this are the point's

    std::string record_file_;
    std::unique_ptr<exchange::Recorder> recorder_; // null where nothing is recorded

    // Of the step in flight.
    LawRequest request_;
    LawAnswer out_;
    exchange::FarmGroup::Fill fill_ = [this](std::span<const std::uint32_t> rows, exchange::Batch& chunk) { fill(rows, chunk); };
    std::vector<std::uint32_t> asked_rves_, chunk_rves_;
    std::uint64_t step_ = 0;
    double time_ = 0.0;                // s, simulated by the RVEs
    double latest_time_increment_ = 0.0; // s
    std::vector<double> row_;

    // The latest of what is only reported: by point of the scene, one column after the other.
    std::vector<std::vector<double>> reported_;
    std::int64_t evaluations_ = 0;
    std::vector<LawEvent> events_; // room for all that a step can bring
    bool checks_ = true;
    double copying_ = 0.0, waiting_ = 0.0; // s, of submit() and collect()
};

} // namespace talik::driver
