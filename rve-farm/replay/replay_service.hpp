#pragma once
// A farm that computes nothing: it answers a driver from a recording. Strictly: a request must be the recorded one within a
// tolerance, and the first that is not ends the run, named by step, RVE and component. Loosely: each RVE is answered with what
// it answered where its deformation (and ice) was nearest, whatever the step; how near is said at the end.
#include <optional>

#include "exchange/farm_end.hpp"
#include "exchange/record_file.hpp"
#include "rve-farm/replay/nearest_answer.hpp"

namespace talik::farm {

struct ReplayOptions {
    bool loose = false;
    double tolerance = 1e-9; // of the largest recorded value of the component in the step; 0 = to the bit
};

class ReplayService : public exchange::FarmService {
public:
    ReplayService(const std::string& file, ReplayOptions options);

    std::vector<Column> understands() const override { return record_.facts().request_columns; }
    std::vector<Column> offers() const override { return record_.facts().answer_columns; }
    void agreed(const exchange::Hello& driver) override;
    std::vector<std::byte> configure(std::span<const std::byte> payload, exchange::Channel& progress) override;
    void answer(const exchange::Batch& request, exchange::Batch& answer, exchange::Channel& progress) override;
    std::vector<std::byte> command(const std::string& name, std::span<const std::byte> payload) override;
    // The recorded answers are the state: a checkpoint only says so; one of the farm that was recorded will do as well.
    void checkpoint(const std::string& path) override;
    void restore(const std::string& path) override;

    std::string report() const; // what was replayed, and how well it fitted

private:
    void load(std::uint64_t step);
    void compare(const exchange::Batch& request);
    void answer_strictly(const exchange::Batch& request, exchange::Batch& answer);
    std::string component_name(int flat) const;

    exchange::Record record_;
    ReplayOptions options_;
    std::size_t rves_;
    std::vector<int> request_from_, answer_from_; // flat component of the record, for each agreed one
    std::uint64_t loaded_step_ = 0, last_step_ = 0;
    std::size_t place_ = 0;                       // of the loaded step
    std::vector<double> request_, answer_;        // of it, [component][rve]
    std::vector<std::uint8_t> asked_;
    std::vector<double> scale_;                   // of each request component: the largest recorded value of the step
    std::optional<NearestAnswer> nearest_;        // loose
    std::int64_t steps_ = 0, answers_ = 0;
    double largest_departure_ = 0.0;              // of a request from the recorded one, over scale_
};

} // namespace talik::farm
