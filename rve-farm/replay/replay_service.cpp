#include "rve-farm/replay/replay_service.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "common/io/byte_stream.hpp"
#include "common/packing/farm_setup.hpp"
#include "exchange/checksum.hpp"
#include "exchange/sealed_file.hpp"

namespace talik::farm {
namespace {

// Where each component of `wanted` stands among those of `found`.
std::vector<int> components_from(const std::vector<Column>& wanted, const std::vector<Column>& found) {
    const exchange::ColumnTable table(found);
    std::vector<int> from;
    for (const Column& column : wanted) {
        const int index = table.index(column.name);
        ensure(index >= 0);
        for (int c = 0; c < column.components; ++c) from.push_back(table.first_component(index) + c);
    }
    return from;
}

} // namespace

ReplayService::ReplayService(const std::string& file, ReplayOptions options)
    : record_(file), options_(options), rves_(record_.facts().rves) {
    const exchange::RecordFacts& facts = record_.facts();
    if (record_.steps().empty()) throw Error(ExitCode::bad_input, file, "holds no step", "record a run with mpm-driver run SCENE --record " + file);
    request_.resize(rves_ * static_cast<std::size_t>(exchange::ColumnTable(facts.request_columns).components()));
    answer_.resize(rves_ * static_cast<std::size_t>(exchange::ColumnTable(facts.answer_columns).components()));
    asked_.resize(rves_);
    if (options_.loose) nearest_.emplace(record_);
}

void ReplayService::agreed(const exchange::Hello& driver) {
    request_from_ = components_from(driver.request_columns, record_.facts().request_columns);
    answer_from_ = components_from(driver.answer_columns, record_.facts().answer_columns);
    scale_.assign(request_from_.size(), 0.0);
    if (request_from_.size() != request_.size() / rves_)
        throw Error(ExitCode::bad_input, record_.file(), "was recorded of a driver that sent other columns", "replay the scene that was recorded");
    if (driver.scene_hash != record_.facts().scene_hash)
        log::warn("{}: was recorded of another scene (hash {}, here {})", record_.file(), record_.facts().scene_hash, driver.scene_hash);
}

std::vector<std::byte> ReplayService::configure(std::span<const std::byte> payload, exchange::Channel&) {
    const std::size_t wanted = decode_farm_setup(payload).packing_of_rve.size();
    if (wanted != rves_)
        throw Error(ExitCode::bad_input, record_.file(), fmt::format("holds {} RVEs, the scene has {}", rves_, wanted), "replay the scene that was recorded");
    if (fmt::format("{:016x}", exchange::checksum(payload)) != record_.facts().setup_checksum)
        log::warn("{}: the RVEs that were recorded had other packings or parameters than the scene's", record_.file());
    std::vector<double> initial;
    for (const int from : answer_from_) {
        const auto begin = record_.facts().initial.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(from) * rves_);
        initial.insert(initial.end(), begin, begin + static_cast<std::ptrdiff_t>(rves_));
    }
    ByteWriter out;
    out.array(initial);
    return out.take();
}

std::string ReplayService::component_name(int flat) const {
    int first = 0;
    for (const Column& column : record_.facts().request_columns) {
        if (flat < first + column.components) return column.components == 1 ? column.name : fmt::format("{}[{}]", column.name, flat - first);
        first += column.components;
    }
    return "?";
}

void ReplayService::load(std::uint64_t step) {
    if (step == loaded_step_) return;
    // Steps mostly follow each other.
    const auto& steps = record_.steps();
    const bool next = loaded_step_ > 0 && place_ + 1 < steps.size() && steps[place_ + 1].step == static_cast<std::int64_t>(step);
    const auto found = next ? std::optional(place_ + 1) : record_.find(step);
    if (!found)
        throw Error(ExitCode::failed, record_.file(), fmt::format("step {} was asked for: it holds steps {} to {}", step, steps.front().step, steps.back().step),
                    "end the run there with --until, or replay with --loose");
    place_ = *found;
    record_.read_request(place_, request_);
    record_.read_answer(place_, answer_);
    record_.read_asked(place_, asked_);
    for (std::size_t c = 0; c < scale_.size(); ++c) {
        const double* values = &request_[static_cast<std::size_t>(request_from_[c]) * rves_];
        scale_[c] = 0.0;
        for (std::size_t rve = 0; rve < rves_; ++rve)
            if (asked_[rve]) scale_[c] = std::max(scale_[c], std::abs(values[rve]));
    }
    loaded_step_ = step;
    ++steps_;
}

// The first departure is named: of the lowest RVE of the chunk.
void ReplayService::compare(const exchange::Batch& request) {
    const auto& clock = request.header();
    const exchange::RecordedStep& step = record_.steps()[place_];
    const auto departs = [&](const std::string& what) {
        throw Error(ExitCode::failed, record_.file(), fmt::format("step {}: {}", clock.step, what),
                    "the run is no longer the one that was recorded: look for what differs, give a larger --tolerance, or replay with --loose");
    };
    for (std::size_t row = 0; row < request.ids().size(); ++row) {
        const std::size_t rve = request.ids()[row];
        if (rve >= rves_ || !asked_[rve]) departs(fmt::format("RVE {} is asked for, which was not", rve));
        for (std::size_t c = 0; c < request_from_.size(); ++c) {
            const double now = request.component(static_cast<int>(c))[row];
            const double then = request_[static_cast<std::size_t>(request_from_[c]) * rves_ + rve];
            const double departure = std::abs(now - then);
            if (departure == 0.0) continue;
            if (!(departure <= options_.tolerance * scale_[c]))
                departs(fmt::format("RVE {}: {} = {:.17g} is asked for, {:.17g} was recorded", rve, component_name(request_from_[c]), now, then));
            largest_departure_ = std::max(largest_departure_, departure / scale_[c]);
        }
    }
    if (std::abs(clock.time_increment - step.time_increment) > options_.tolerance * std::abs(step.time_increment))
        departs(fmt::format("a time increment of {:.17g} s is asked for, {:.17g} s was recorded", clock.time_increment, step.time_increment));
}

void ReplayService::answer_strictly(const exchange::Batch& request, exchange::Batch& answer) {
    load(request.header().step);
    compare(request);
    const auto ids = request.ids();
    for (std::size_t c = 0; c < answer_from_.size(); ++c) {
        const double* from = &answer_[static_cast<std::size_t>(answer_from_[c]) * rves_];
        const auto out = answer.component(static_cast<int>(c));
        for (std::size_t row = 0; row < ids.size(); ++row) out[row] = from[ids[row]];
    }
}

void ReplayService::answer(const exchange::Batch& request, exchange::Batch& answer, exchange::Channel& progress) {
    last_step_ = request.header().step;
    if (!nearest_) {
        answer_strictly(request, answer);
    } else {
        std::vector<double> asked(request_from_.size()), found(answer_.size() / rves_);
        for (std::size_t row = 0; row < request.ids().size(); ++row) {
            const std::size_t rve = request.ids()[row];
            require(rve < rves_, "an RVE was asked for that the recording does not have", "replay the scene that was recorded");
            for (std::size_t c = 0; c < asked.size(); ++c) asked[static_cast<std::size_t>(request_from_[c])] = request.component(static_cast<int>(c))[row];
            nearest_->answer(rve, request.header().step, asked, found);
            for (std::size_t c = 0; c < answer_from_.size(); ++c) answer.component(static_cast<int>(c))[row] = found[static_cast<std::size_t>(answer_from_[c])];
        }
        if (request.header().chunk == 0) ++steps_;
    }
    answers_ += request.count();
    progress.advance_progress(static_cast<std::uint64_t>(answers_), 0);
}

std::vector<std::byte> ReplayService::command(const std::string& name, std::span<const std::byte> payload) {
    for (const exchange::RecordedCommand& command : record_.commands()) {
        const bool then = command.after_step == static_cast<std::int64_t>(last_step_);
        if (command.name == name && (options_.loose || (then && std::equal(payload.begin(), payload.end(), command.payload.begin(), command.payload.end()))))
            return command.reply;
    }
    if (options_.loose) return {};
    throw Error(ExitCode::failed, record_.file(), fmt::format("\"{}\" is commanded after step {}, which was not recorded there", name, last_step_),
                "the run is no longer the one that was recorded: look for what differs, or replay with --loose");
}

void ReplayService::checkpoint(const std::string& path) {
    Hdf5File file = Hdf5File::create(path, "rve-farm", "talik-replay-checkpoint 1");
    file.set_attribute("/", "record", record_.file());
    file.set_attribute("/", "step", static_cast<std::int64_t>(last_step_));
    file.close();
    exchange::seal(path);
}

void ReplayService::restore(const std::string& path) {
    exchange::require_sealed(path);
    if (nearest_) throw Error(ExitCode::bad_input, path, "a loose replay cannot go on from a checkpoint", "replay from the start, or strictly");
}

std::string ReplayService::report() const {
    if (nearest_)
        return fmt::format("replayed loosely: {} answers in {} steps, {} of them at another deformation than recorded, by up to {:.2g} (strain, ice)", answers_, steps_,
                           nearest_->answers_at_distance(), nearest_->largest_distance());
    if (largest_departure_ == 0.0) return fmt::format("replayed {} steps: every request was the recorded one to the bit", steps_);
    return fmt::format("replayed {} steps: requests departed from the recorded ones by up to {:.1e} of the largest of their kind", steps_, largest_departure_);
}

} // namespace talik::farm
