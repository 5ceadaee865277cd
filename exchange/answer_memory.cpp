#include "exchange/answer_memory.hpp"

#include <algorithm>
#include <bit>
#include <fmt/format.h>

#include "common/base/error.hpp"

namespace talik::exchange {
namespace {

constexpr const char* restart = "restart both programs from the same checkpoint";

// Everything the answer depends on: increments, clock and sub-steps.
std::uint64_t fingerprint(const Batch& request, int row) {
    std::uint64_t sum = request.header().substeps;
    const auto absorb = [&](double value) {
        sum = std::rotl((sum ^ std::bit_cast<std::uint64_t>(value)) * 0x9e3779b97f4a7c15u, 29);
    };
    absorb(request.header().time_increment);
    for (int c = 0; c < request.columns().components(); ++c) absorb(request.component(c)[static_cast<std::size_t>(row)]);
    return sum;
}

} // namespace

AnswerMemory::AnswerMemory(int rve_count, const ColumnTable& answer_columns)
    : last_(static_cast<std::size_t>(rve_count)),
      answers_(static_cast<std::size_t>(rve_count) * static_cast<std::size_t>(answer_columns.components())),
      seen_(static_cast<std::size_t>(rve_count)), components_(answer_columns.components()) {}

void AnswerMemory::recall(const Batch& request, Batch& answer, std::vector<int>& rows) {
    ensure(answer.columns().components() == components_);
    rows.clear();
    ++calls_;
    const std::uint64_t step = request.header().step;
    const auto ids = request.ids();
    for (int row = 0; row < request.count(); ++row) {
        const std::uint32_t id = ids[static_cast<std::size_t>(row)];
        if (id >= last_.size())
            fail(ExitCode::failed, fmt::format("RVE {} was asked for; there are {}", id, last_.size()), restart);
        if (seen_[id] == calls_) fail(ExitCode::failed, fmt::format("RVE {} was asked for twice in one request", id), restart);
        seen_[id] = calls_;
        const Last& last = last_[id];
        if (step < last.step)
            fail(ExitCode::failed, fmt::format("RVE {} was asked for step {} after step {}", id, step, last.step), restart);
        if (step > last.step) {
            rows.push_back(row);
            continue;
        }
        if (last.request != fingerprint(request, row))
            fail(ExitCode::failed, fmt::format("RVE {} was asked for step {} again, but with another increment", id, step), restart);
        for (int c = 0; c < components_; ++c)
            answer.component(c)[static_cast<std::size_t>(row)] =
                answers_[std::size_t(id) * static_cast<std::size_t>(components_) + static_cast<std::size_t>(c)];
    }
}

void AnswerMemory::remember(const Batch& request, const Batch& answer, const std::vector<int>& rows) {
    for (int row : rows) {
        const std::uint32_t id = request.ids()[static_cast<std::size_t>(row)];
        last_[id] = {request.header().step, fingerprint(request, row)};
        for (int c = 0; c < components_; ++c)
            answers_[std::size_t(id) * static_cast<std::size_t>(components_) + static_cast<std::size_t>(c)] =
                answer.component(c)[static_cast<std::size_t>(row)];
    }
}

void AnswerMemory::save(ByteWriter& out) const {
    out.put(static_cast<std::int32_t>(components_));
    out.array(last_);
    out.array(answers_);
}

void AnswerMemory::load(ByteReader& in) {
    const auto components = in.get<std::int32_t>();
    auto last = in.array<Last>();
    auto answers = in.array<double>();
    require(components == components_ && last.size() == last_.size() && answers.size() == answers_.size(),
            fmt::format("the checkpoint remembers {} RVEs with {} columns of answers, this run has {} with {}", last.size(),
                        components, last_.size(), components_),
            "restart with the scene that the checkpoint is of");
    last_ = std::move(last);
    answers_ = std::move(answers);
}

void AnswerMemory::take(std::uint32_t id, const AnswerMemory& from, std::uint32_t id_there) {
    ensure(components_ == from.components_ && id < last_.size() && id_there < from.last_.size());
    last_[id] = from.last_[id_there];
    const auto row = [this](std::uint32_t of) { return static_cast<std::ptrdiff_t>(of) * components_; };
    std::copy_n(from.answers_.begin() + row(id_there), components_, answers_.begin() + row(id));
}

} // namespace talik::exchange
