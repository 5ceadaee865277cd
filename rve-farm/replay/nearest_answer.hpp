#pragma once
// For each RVE, the recorded step at whose end its deformation so far, the sum of its displacement-gradient increments, and
// its ice were nearest to the present ones. Sought from where it was last, downhill along the RVE's own path.
#include <map>
#include <span>
#include <vector>

#include "exchange/record_file.hpp"

namespace talik::farm {

class NearestAnswer {
public:
    explicit NearestAnswer(const exchange::Record& record);

    // The RVE goes on by a request (components in the order of the record); its answer, by component of the record.
    // repeated: the request of a step that was asked already is asked again.
    void answer(std::size_t rve, std::uint64_t step, std::span<const double> request, std::span<double> out);

    double largest_distance() const { return largest_distance_; } // -, of strain and ice
    std::int64_t answers_at_distance() const { return away_; }     // farther than rounding

private:
    struct Path {
        std::vector<double> now, before; // sums of the increments, and the ice
        std::uint64_t step = 0;
        std::size_t nearest = 0;         // 0 = before the first step, else place + 1
    };
    double distance(std::size_t rve, std::size_t state) const;
    const std::vector<double>& answers_of(std::size_t place);

    const exchange::Record& record_;
    std::size_t rves_, request_components_, answer_components_;
    std::vector<bool> adds_up_;         // by request component: an increment; else a state (ice)
    std::vector<float> path_;           // recorded, [state][component][rve], state 0 = before the first step
    std::vector<Path> paths_;
    std::map<std::size_t, std::vector<double>> cache_; // of recorded answers, by place; bounded
    double largest_distance_ = 0.0;
    std::int64_t away_ = 0;
};

} // namespace talik::farm
