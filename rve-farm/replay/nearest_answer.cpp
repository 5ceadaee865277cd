#include "rve-farm/replay/nearest_answer.hpp"

#include <algorithm>
#include <cmath>

#include "common/physics/rve_columns.hpp"

namespace talik::farm {
namespace {

constexpr std::size_t cached_steps = 64;
constexpr double rounding = 1e-6; // of a path kept in single precision

} // namespace

NearestAnswer::NearestAnswer(const exchange::Record& record) : record_(record), rves_(record.facts().rves) {
    for (const Column& column : record.facts().request_columns)
        adds_up_.insert(adds_up_.end(), static_cast<std::size_t>(column.components), column == rve_columns::displacement_gradient_increment);
    request_components_ = adds_up_.size();
    answer_components_ = static_cast<std::size_t>(exchange::ColumnTable(record.facts().answer_columns).components());
    const std::size_t states = record.steps().size() + 1, width = request_components_ * rves_;
    path_.resize(states * width);
    std::vector<double> sum(width, 0.0), row(width);
    for (std::size_t place = 0; place + 1 < states; ++place) {
        record.read_request(place, row);
        for (std::size_t i = 0; i < width; ++i)
            if (!std::isnan(row[i])) sum[i] = adds_up_[i / rves_] ? sum[i] + row[i] : row[i];
        std::copy(sum.begin(), sum.end(), path_.begin() + static_cast<std::ptrdiff_t>((place + 1) * width));
        if (place == 0) // before the first step: undeformed, with the ice of that step
            for (std::size_t i = 0; i < width; ++i) path_[i] = adds_up_[i / rves_] ? 0.0f : static_cast<float>(sum[i]);
    }
    paths_.resize(rves_);
    for (Path& path : paths_) path.now.assign(request_components_, 0.0), path.before = path.now;
}

double NearestAnswer::distance(std::size_t rve, std::size_t state) const {
    double sum = 0.0;
    for (std::size_t c = 0; c < request_components_; ++c) {
        const double d = paths_[rve].now[c] - static_cast<double>(path_[(state * request_components_ + c) * rves_ + rve]);
        sum += d * d;
    }
    return std::sqrt(sum);
}

void NearestAnswer::answer(std::size_t rve, std::uint64_t step, std::span<const double> request, std::span<double> out) {
    Path& path = paths_[rve];
    if (step != path.step) path.before = path.now, path.step = step; // else the same step again
    for (std::size_t c = 0; c < request_components_; ++c) path.now[c] = adds_up_[c] ? path.before[c] + request[c] : request[c];
    const std::size_t states = record_.steps().size() + 1;
    std::size_t best = std::clamp<std::size_t>(path.nearest, 1, states - 1);
    double least = distance(rve, best);
    for (const int direction : {1, -1})
        for (std::size_t flat = 0, at = best; flat < 32;) { // over small bumps on the way
            if ((direction < 0 && at <= 1) || (direction > 0 && at + 1 >= states)) break;
            at = direction > 0 ? at + 1 : at - 1;
            const double d = distance(rve, at);
            ++flat;
            if (d < least) least = d, best = at, flat = 0;
        }
    path.nearest = best;
    largest_distance_ = std::max(largest_distance_, least);
    away_ += least > rounding;
    const std::vector<double>& answers = answers_of(best - 1);
    for (std::size_t c = 0; c < answer_components_; ++c) out[c] = answers[c * rves_ + rve];
}

const std::vector<double>& NearestAnswer::answers_of(std::size_t place) {
    if (const auto found = cache_.find(place); found != cache_.end()) return found->second;
    if (cache_.size() >= cached_steps) cache_.erase(cache_.begin()); // paths go forward: the earliest is done with first
    std::vector<double> row(answer_components_ * rves_);
    record_.read_answer(place, row);
    return cache_.emplace(place, std::move(row)).first->second;
}

} // namespace talik::farm
