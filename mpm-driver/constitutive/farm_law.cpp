#include "mpm-driver/constitutive/farm_law.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numeric>

#include "common/base/error.hpp"
#include "common/base/stage_timer.hpp"
#include "common/io/byte_stream.hpp"
#include "common/io/hdf5_file.hpp"
#include "common/physics/clock.hpp"
#include "common/physics/rve_columns.hpp"
#include "exchange/checksum.hpp"
#include "exchange/sealed_file.hpp"
#include "mpm-driver/constitutive/packing_choice.hpp"
#include "mpm-driver/points/soundness.hpp"

namespace talik::driver {
namespace {

namespace columns_of = rve_columns;

constexpr const char* checkpoint_format = "talik-farm-law-checkpoint 1";

// Answers that the driver only passes on to its output.
const std::array<Column, 7> reported_columns = {columns_of::coordination_number, columns_of::void_ratio, columns_of::bonds,
                                                columns_of::broken_bonds, columns_of::work, columns_of::split_steps, columns_of::retaken_chunks};
constexpr std::size_t coordination_column = 0, split_steps_column = 5, retaken_chunks_column = 6;

std::vector<Column> asked_for() {
    std::vector<Column> asked = {columns_of::stress, columns_of::status, columns_of::stiffness, columns_of::stored_energy,
                                 columns_of::kinetic_energy, columns_of::friction_dissipation, columns_of::damping_dissipation,
                                 columns_of::bond_dissipation};
    asked.insert(asked.end(), reported_columns.begin(), reported_columns.end());
    return asked;
}

} // namespace

int exchanged_components(bool ice) {
    return exchange::ColumnTable(asked_for()).components() + columns_of::displacement_gradient_increment.components + (ice ? columns_of::ice_saturation.components : 0);
}

FarmLaw::FarmLaw(exchange::FarmGroup farms, exchange::Hello hello, FarmSetup setup, std::uint64_t seed)
    : farms_(std::move(farms)), hello_(std::move(hello)), setup_(std::move(setup)), seed_(seed) {
    hello_.role = exchange::Role::driver;
    hello_.request_columns = {columns_of::displacement_gradient_increment};
    hello_.answer_columns = asked_for();
    answer_columns_ = exchange::ColumnTable(hello_.answer_columns);
    const auto at = [&](const Column& column) { return answer_columns_.first_component(answer_columns_.index(column.name)); };
    at_ = {at(columns_of::stress), at(columns_of::status), at(columns_of::stiffness), at(columns_of::stored_energy), at(columns_of::kinetic_energy),
           at(columns_of::friction_dissipation), at(columns_of::damping_dissipation), at(columns_of::bond_dissipation)};
    row_.resize(static_cast<std::size_t>(answer_columns_.components()));
}

void FarmLaw::begin(std::span<const std::uint32_t> ids, const Points& points, LawAnswer initial) {
    point_of_rve_.assign(ids.begin(), ids.end());
    rve_of_point_.assign(points.count(), 0);
    reported_.assign(reported_columns.size(), std::vector<double>(points.count(), 0.0));
    const auto count = static_cast<std::uint32_t>(ids.size());
    for (std::uint32_t rve = 0; rve < count; ++rve) rve_of_point_[ids[rve]] = rve;
    if (vertical_stress_ && k0_levels(setup_.packings) > 1) {
        std::vector<double> vertical; // Pa, of each RVE
        for (const std::uint32_t id : ids) vertical.push_back(vertical_stress_(points.position[id]));
        setup_.packing_of_rve = deal_packings_by_depth(setup_.packings, vertical, seed_);
    } else {
        setup_.packing_of_rve = deal_packings(static_cast<int>(count), static_cast<int>(setup_.packings.size()), seed_);
    }
    for (std::uint32_t rve = 0; rve < count; ++rve) {
        const Packing& packing = setup_.packings[static_cast<std::size_t>(setup_.packing_of_rve[rve])];
        const double rve_volume = std::abs(packing.cell.determinant()) * setup_.parameters.thickness;
        scale_.push_back(points.initial_volume[ids[rve]] / rve_volume);
    }

    sends_ice_ = setup_.parameters.bond && !points.ice_saturation.empty();
    if (sends_ice_) hello_.request_columns.push_back(columns_of::ice_saturation);
    farm_program_ = farms_.connect(hello_).program;
    const auto& said = farms_.configure(static_cast<int>(count), [this](std::span<const std::uint32_t> rves) { return setup_for(rves); });
    std::vector<double> recorded(record_file_.empty() ? 0 : row_.size() * count); // [component][rve]
    for (int farm = 0; farm < farms_.farms(); ++farm) {
        const auto rves = farms_.rves(farm);
        ByteReader in(said[static_cast<std::size_t>(farm)], "the answer to configure");
        const auto values = in.array<double>();
        require(values.size() == row_.size() * rves.size(), "the farm was set up with another number of RVEs", "use mpm-driver and rve-farm of one version");
        for (std::size_t i = 0; i < rves.size(); ++i) {
            for (std::size_t component = 0; component < row_.size(); ++component) row_[component] = values[component * rves.size() + i];
            if (!record_file_.empty())
                for (std::size_t component = 0; component < row_.size(); ++component) recorded[component * count + rves[i]] = row_[component];
            check_numbers(rves[i], row_.data());
            take(rves[i], row_.data(), initial);
        }
    }
    asked_rves_.reserve(count);
    events_.reserve(3 * static_cast<std::size_t>(count));
    if (!record_file_.empty()) start_recording(recorded);
}

// Packings stay here: another farm may need them, and so may an RVE that changes hands.
std::vector<std::byte> FarmLaw::setup_for(std::span<const std::uint32_t> rves) const {
    FarmSetup own;
    own.parameters = setup_.parameters;
    own.packings = setup_.packings;
    own.ids.assign(rves.begin(), rves.end());
    for (const std::uint32_t rve : rves) own.packing_of_rve.push_back(setup_.packing_of_rve[rve]);
    return encode(own);
}

// What one farm would be told that has them all: a recording answers for any number of farms.
void FarmLaw::start_recording(const std::vector<double>& initial) {
    std::vector<std::uint32_t> all(point_of_rve_.size());
    std::iota(all.begin(), all.end(), 0u);
    recorder_ = std::make_unique<exchange::Recorder>(record_file_, exchange::RecordFacts{hello_.program, farm_program_, hello_.scene_hash, fmt::format("{:016x}", exchange::checksum(setup_for(all))),
                                                                                         hello_.request_columns, hello_.answer_columns, all.size(), initial});
}

void FarmLaw::bye() {
    if (recorder_) recorder_->close();
    farms_.bye();
}

// Of a scope: what of its time was waiting for the farm, and what was copying; recording has its own account.
class FarmLaw::Timing {
public:
    explicit Timing(FarmLaw& law) : law_(law), waited_(law.farms_.waiting_seconds()), recorded_(law.recording_seconds()), begin_(StageTimer::Clock::now()) {}
    ~Timing() {
        const double elapsed = std::chrono::duration<double>(StageTimer::Clock::now() - begin_).count();
        const double waiting = law_.farms_.waiting_seconds() - waited_;
        law_.waiting_ += waiting;
        law_.copying_ += std::max(0.0, elapsed - waiting - (law_.recording_seconds() - recorded_));
    }
    Timing(const Timing&) = delete;
    Timing& operator=(const Timing&) = delete;

private:
    FarmLaw& law_;
    double waited_, recorded_;
    StageTimer::Clock::time_point begin_;
};

void FarmLaw::submit(const LawRequest& request, LawAnswer answer) {
    const Timing timing(*this);
    request_ = request;
    out_ = answer;
    events_.clear();
    step_ = request.step;
    time_ += request.time_increment;
    latest_time_increment_ = request.time_increment;
    asked_rves_.clear();
    for (const std::uint32_t point : request.ids) asked_rves_.push_back(rve_of_point_[point]);
    const exchange::StepClock clock{request.step, request.time_increment, static_cast<std::uint32_t>(setup_.parameters.substeps)};
    if (recorder_) recorder_->begin_step(clock);
    farms_.begin_step(clock, asked_rves_, fill_);
}

void FarmLaw::fill(std::span<const std::uint32_t> rows, exchange::Batch& chunk) {
    const std::array<std::span<double>, 4> gradient = {chunk.component(0), chunk.component(1), chunk.component(2), chunk.component(3)};
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const std::uint32_t point = request_.ids[rows[i]];
        const Matrix& increment = request_.displacement_gradient_increment[point];
        gradient[0][i] = increment(0, 0);
        gradient[1][i] = increment(0, 1);
        gradient[2][i] = increment(1, 0);
        gradient[3][i] = increment(1, 1);
        if (sends_ice_) chunk.component(4)[i] = request_.ice_saturation[point];
    }
    if (!recorder_) return;
    chunk_rves_.clear();
    for (const std::uint32_t row : rows) chunk_rves_.push_back(asked_rves_[row]);
    recorder_->request(chunk, chunk_rves_);
}

void FarmLaw::collect() {
    const Timing timing(*this);
    farms_.finish_step();
    for (int farm = 0; farm < farms_.farms(); ++farm) {
        const exchange::Batch& answer = farms_.answer(farm);
        const auto ids = answer.ids();
        if (recorder_) recorder_->answer(answer, farms_.rves(farm));
        for (std::size_t row = 0; row < ids.size(); ++row) {
            const std::uint32_t rve = farms_.rves(farm)[ids[row]];
            for (std::size_t component = 0; component < row_.size(); ++component) row_[component] = answer.component(static_cast<int>(component))[row];
            check_status(rve, row_[static_cast<std::size_t>(at_.status)]);
            if (checks_) check_numbers(rve, row_.data());
            if (checks_) watch(point_of_rve_[rve], row_.data());
            take(rve, row_.data(), out_);
        }
    }
    if (recorder_) recorder_->end_step();
    evaluations_ += static_cast<std::int64_t>(asked_rves_.size());
}

void FarmLaw::take(std::uint32_t rve, const double* answer, LawAnswer out) {
    const std::uint32_t point = point_of_rve_[rve];
    const double scale = scale_[rve];
    out.stress[point] = {answer[at_.stress], answer[at_.stress + 1], answer[at_.stress + 2]};
    out.p_wave_modulus[point] = answer[at_.stiffness];
    out.energy[point] = {scale * answer[at_.stored], scale * answer[at_.kinetic], scale * answer[at_.friction],
                         scale * answer[at_.damping], scale * answer[at_.bond]};
    const double* reported = answer + answer_columns_.components() - reported_columns.size(); // the last that were asked for, a number each
    for (std::size_t i = 0; i < reported_columns.size(); ++i) reported_[i][point] = reported[i];
}

void FarmLaw::check_status(std::uint32_t rve, double status) const {
    if (status == 0.0) return;
    static const std::array<const char*, 5> names = {"", "its state is no longer finite, or discs moved a good part of their radius in a sub-step",
                                                     "a disc has more neighbours than there is room for",
                                                     "the DEM sub-step is beyond the stable one of its contact network",
                                                     "it was asked for a strain or an ice saturation that is no number, or for more strain than a step can be"};
    const auto index = static_cast<std::size_t>(status);
    fail(ExitCode::failed,
         fmt::format("the RVE of point {} failed in step {} (after {:.6g} s): {}", point_of_rve_[rve], step_, time_, index < names.size() ? names[index] : "unknown status"),
         "take a smaller rve.time_step or step, or restart from the last checkpoint with gentler loading");
}

// Whoever answers may be another program: what is no number must not reach the grid.
void FarmLaw::check_numbers(std::uint32_t rve, const double* answer) const {
    const int used = answer_columns_.components() - static_cast<int>(reported_columns.size()); // a law may not know what is only reported
    double sum = 0.0;
    for (int k = 0; k < used; ++k) sum += poison(answer[k]);
    if (sum == 0.0) return;
    for (int column = 0; column < answer_columns_.size(); ++column)
        for (int k = answer_columns_.first_component(column), c = 0; c < answer_columns_.columns()[static_cast<std::size_t>(column)].components; ++k, ++c)
            if (k < used && !std::isfinite(answer[k]))
                fail(ExitCode::failed,
                     fmt::format("the RVE of point {} answered a {} (component {}) of {} in step {} (after {:.6g} s)", point_of_rve_[rve],
                                 answer_columns_.columns()[static_cast<std::size_t>(column)].name, c, answer[k], step_, time_),
                     "mend the program that answers; restart from the last checkpoint");
}

// Before the answer is taken: what has grown since the last one.
void FarmLaw::watch(std::uint32_t point, const double* answer) {
    const double* reported = answer + answer_columns_.components() - reported_columns.size(); // the last that were asked for, a number each
    const auto now = [&](std::size_t column) { return reported[column]; };
    const double splits = now(split_steps_column) - reported_[split_steps_column][point], retaken = now(retaken_chunks_column) - reported_[retaken_chunks_column][point];
    if (splits > 0.0) events_.push_back({Help::extra_sub_steps, point, splits});
    if (retaken > 0.0) events_.push_back({Help::retaken_chunks, point, retaken});
    if (now(coordination_column) == 0.0 && reported_[coordination_column][point] > 0.0) events_.push_back({Help::lost_contacts, point, 1.0});
}

std::int64_t FarmLaw::rves_without_contacts() const {
    std::int64_t count = 0;
    for (const std::uint32_t point : point_of_rve_) count += reported_[coordination_column][point] == 0.0;
    return count;
}

std::int64_t FarmLaw::split_steps() const {
    double sum = 0.0;
    if (!reported_.empty())
        for (double steps : reported_[split_steps_column]) sum += steps;
    return static_cast<std::int64_t>(sum);
}

exchange::LockstepTimes FarmLaw::farm_times() {
    exchange::LockstepTimes mean;
    for (const auto& said : farms_.command("times")) {
        ByteReader in(said, "the answer to \"times\"");
        const auto times = in.get<exchange::LockstepTimes>();
        mean.computing += times.computing / farms_.farms(), mean.copying += times.copying / farms_.farms(), mean.waiting += times.waiting / farms_.farms();
    }
    return mean;
}

double FarmLaw::dem_time_step() const {
    if (latest_time_increment_ <= 0.0) return 0.0;
    return latest_time_increment_ / substeps_of(setup_.parameters, latest_time_increment_);
}

bool FarmLaw::activate(const std::string& effect, std::span<const std::uint32_t> points) {
    if (effect != "bonds") return false;
    std::vector<std::uint32_t> rves;
    for (const std::uint32_t point : points)
        if (const std::uint32_t rve = rve_of_point_[point]; rve < point_of_rve_.size() && point_of_rve_[rve] == point) rves.push_back(rve);
    farms_.command_rves("activate bonds", rves);
    if (recorder_) {
        ByteWriter ids;
        ids.array(rves);
        recorder_->command("activate bonds", ids.bytes(), {});
    }
    return true;
}

void FarmLaw::checkpoint(const std::string& folder) {
    farms_.checkpoint(folder);
    Hdf5File file = Hdf5File::create((std::filesystem::path(folder) / "law.h5").string(), "mpm-driver", checkpoint_format);
    file.set_attribute("/", "evaluations", evaluations_);
    file.set_attribute("/", "time", time_);
    for (std::size_t i = 0; i < reported_columns.size(); ++i) file.write("/" + reported_columns[i].name, reported_[i]);
    file.close();
    exchange::seal(std::filesystem::path(folder) / "law.h5");
}

void FarmLaw::restore(const std::string& folder) {
    farms_.restore(folder);
    if (recorder_) recorder_->go_on();
    exchange::require_sealed(std::filesystem::path(folder) / "law.h5");
    const Hdf5File file = Hdf5File::open((std::filesystem::path(folder) / "law.h5").string());
    file.require_format(checkpoint_format);
    evaluations_ = file.integer_attribute("/", "evaluations");
    time_ = file.number_attribute("/", "time");
    for (std::size_t i = 0; i < reported_columns.size(); ++i) reported_[i] = file.read<double>("/" + reported_columns[i].name).values;
}

std::vector<StateColumn> FarmLaw::columns() {
    std::vector<StateColumn> out;
    for (std::size_t i = 0; i < reported_columns.size(); ++i)
        out.push_back({reported_columns[i].name, reported_columns[i].unit, reported_columns[i].meaning, {""}, reported_[i].data(), reported_[i].size()});
    return out;
}

} // namespace talik::driver
