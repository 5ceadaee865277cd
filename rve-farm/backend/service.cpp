#include "rve-farm/backend/service.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <numeric>
#include <string>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "common/base/stage_timer.hpp"
#include "common/io/byte_stream.hpp"
#include "common/io/hdf5_file.hpp"
#include "common/packing/farm_setup.hpp"
#include "common/physics/rve_columns.hpp"
#include "exchange/sealed_file.hpp"

namespace talik::farm {
namespace {

constexpr const char* format = "talik-farm-checkpoint 3";

std::string kernel_in_words(const Farm& farm) {
    return std::string(name_of(farm.kernel().precision)) + " precision, " + (farm.on_gpu() ? "cuda" : name_of(farm.kernel().level));
}

// The first column of an RVE that holds a NaN or an infinite number; empty where all are sound.
std::string what_is_no_number(const Assembly& rve) {
    std::string found;
    AssemblyView view = rve.view();
    for_each_column(view, rve.columns(), [&](const char* name, const char*, Extent extent, auto*& column, bool present) {
        if (!present || !found.empty()) return;
        double sum = 0;
        for (int i = 0; i < entries(rve.numbers(), extent); ++i) sum += 0.0 * static_cast<double>(column[i]);
        if (!(sum == 0)) found = name;
    });
    const AssemblyNumbers& n = rve.numbers();
    const double cell = n.cell_xx * n.cell_yy - n.cell_xy * n.cell_yx;
    if (found.empty() && !(std::isfinite(cell + n.frame_angle + n.skin + n.work) && cell > 0)) found = "cell";
    return found;
}

using Reader = double (*)(const Answer&, const AssemblyNumbers&);

// How each column the farm offers is read from an answer: one row per column, one reader per component.
const std::map<std::string, std::vector<Reader>>& readers() {
    static const std::map<std::string, std::vector<Reader>> table = {
        {"stress", {[](const Answer& a, const AssemblyNumbers&) { return a.stress[0]; }, [](const Answer& a, const AssemblyNumbers&) { return a.stress[1]; }, [](const Answer& a, const AssemblyNumbers&) { return a.stress[2]; }}},
        {"status", {[](const Answer& a, const AssemblyNumbers&) { return static_cast<double>(a.status); }}},
        {"stiffness", {[](const Answer& a, const AssemblyNumbers&) { return a.stiffness; }}},
        {"coordination_number", {[](const Answer& a, const AssemblyNumbers&) { return a.coordination_number; }}},
        {"broken_bonds", {[](const Answer& a, const AssemblyNumbers&) { return static_cast<double>(a.broken_bonds); }}},
        {"bonds", {[](const Answer& a, const AssemblyNumbers&) { return static_cast<double>(a.bonds); }}},
        {"stored_energy", {[](const Answer& a, const AssemblyNumbers&) { return a.stored_energy; }}},
        {"kinetic_energy", {[](const Answer& a, const AssemblyNumbers&) { return a.kinetic_energy; }}},
        {"friction_dissipation", {[](const Answer& a, const AssemblyNumbers&) { return a.friction_dissipation; }}},
        {"damping_dissipation", {[](const Answer& a, const AssemblyNumbers&) { return a.damping_dissipation; }}},
        {"bond_dissipation", {[](const Answer& a, const AssemblyNumbers&) { return a.bond_dissipation; }}},
        {"work", {[](const Answer& a, const AssemblyNumbers&) { return a.work; }}},
        {"cell_area", {[](const Answer& a, const AssemblyNumbers&) { return a.cell_area; }}},
        {"void_ratio", {[](const Answer& a, const AssemblyNumbers&) { return a.void_ratio; }}},
        {"split_steps", {[](const Answer& a, const AssemblyNumbers&) { return static_cast<double>(a.split_steps); }}},
        {"retaken_chunks", {[](const Answer&, const AssemblyNumbers& n) { return static_cast<double>(n.retaken_chunks); }}},
    };
    return table;
}

} // namespace

std::vector<Column> Service::understands() const { return rve_columns::requests(); }
std::vector<Column> Service::offers() const { return rve_columns::answers(); }

void Service::agreed(const exchange::Hello& driver) {
    request_columns_ = exchange::ColumnTable(driver.request_columns);
    answer_columns_ = exchange::ColumnTable(driver.answer_columns);
    readers_.clear();
    books_energies_ = false;
    for (const char* energy : {"friction_dissipation", "damping_dissipation", "bond_dissipation", "work"})
        books_energies_ = books_energies_ || answer_columns_.index(energy) >= 0; // nobody asks: nothing is booked
    for (const Column& column : answer_columns_.columns())
        for (Reader reader : readers().at(column.name)) readers_.push_back(reader);
}

std::vector<std::byte> Service::configure(std::span<const std::byte> payload, exchange::Channel& progress) {
    const FarmSetup setup = decode_farm_setup(payload);
    progress_ = &progress;
    FarmOptions options = options_;
    options.ledger = books_energies_;
    options.on_rve_done = [this] {
        if (progress_) progress_->advance_progress(farm_->rves_done(), progress_total_);
    };
    farm_.emplace(setup.parameters, setup.packings, setup.packing_of_rve, options);
    if (farm_->on_gpu()) log::info("{} RVEs on {}", farm_->size(), farm_->backend_in_words());
    memory_ = exchange::AnswerMemory(farm_->size(), answer_columns_);
    run_ids_ = setup.ids;
    if (run_ids_.empty()) run_ids_.resize(setup.packing_of_rve.size()), std::iota(run_ids_.begin(), run_ids_.end(), 0u);
    costs_.assign(run_ids_.size(), 0.0);

    const auto count = static_cast<std::size_t>(farm_->size());
    std::vector<double> initial(readers_.size() * count);
    for (std::size_t id = 0; id < count; ++id) {
        const Answer now = farm_->measure(static_cast<int>(id));
        for (std::size_t component = 0; component < readers_.size(); ++component)
            initial[component * count + id] = readers_[component](now, farm_->numbers(static_cast<int>(id)));
        progress.advance_progress(id + 1, count);
    }
    ByteWriter out;
    out.array(initial);
    return out.take();
}

Farm& Service::farm() {
    require(farm_.has_value(), "the farm was asked before it was set up", "send `configure` first");
    return *farm_;
}

void Service::answer(const exchange::Batch& request, exchange::Batch& answer, exchange::Channel& progress) {
    memory_.recall(request, answer, rows_);
    const int gradient = request_columns_.index("displacement_gradient_increment");
    const int ice = request_columns_.index("ice_saturation");
    const std::size_t count = rows_.size();
    ids_.resize(count);
    increments_.resize(4 * count);
    ice_.resize(ice < 0 ? 0 : count);
    answers_.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
        const auto row = static_cast<std::size_t>(rows_[i]);
        ids_[i] = request.ids()[row];
        for (int c = 0; c < 4; ++c) increments_[4 * i + static_cast<std::size_t>(c)] = request.component(gradient, c)[row];
        if (ice >= 0) ice_[i] = request.component(ice, 0)[row];
    }
    progress_ = &progress;
    progress_total_ = farm().rves_done() + count;
    const auto& clock = request.header();
    double seconds = 0.0; // of all rows together: a backend may compute them at once
    {
        const StageTimer::Scope timing(seconds);
        farm().advance(ids_, increments_, ice_, clock.time_increment, static_cast<int>(clock.substeps), answers_);
    }
    for (const std::uint32_t id : ids_) costs_[id] += seconds / static_cast<double>(count);
    for (std::size_t component = 0; component < readers_.size(); ++component) {
        const auto column = answer.component(static_cast<int>(component));
        for (std::size_t i = 0; i < count; ++i) column[static_cast<std::size_t>(rows_[i])] = readers_[component](answers_[i], farm().numbers(static_cast<int>(ids_[i])));
    }
    memory_.remember(request, answer, rows_);
}

std::vector<std::byte> Service::command(const std::string& name, std::span<const std::byte> payload) {
    if (name == "activate bonds") {
        require(farm().parameters().bond.has_value(), "bonds cannot be activated: the RVEs have no bond law", "add [rve.bond] to the scene");
        if (payload.empty()) {
            farm().activate_bonds();
            return {};
        }
        ByteReader in(payload, "activate bonds");
        const auto ids = in.array<std::uint32_t>();
        in.finish();
        for (const std::uint32_t id : ids) {
            require(id < static_cast<std::uint32_t>(farm().size()), "bonds are to be activated in an RVE that the farm does not have", "use mpm-driver and rve-farm of one version");
            farm().activate_bonds(static_cast<int>(id));
        }
        return {};
    }
    if (name == "costs") {
        ByteWriter out;
        out.array(costs_);
        std::fill(costs_.begin(), costs_.end(), 0.0);
        return out.take();
    }
    fail(ExitCode::bad_input, "the farm knows no command \"" + name + "\"", "it knows: activate bonds, costs, times");
}

void Service::checkpoint(const std::string& path) {
    const std::string part = path + ".part";
    Hdf5File file = Hdf5File::create(part, "rve-farm", format);
    std::vector<std::byte> bytes;
    std::vector<std::int64_t> ends; // of each RVE's bytes
    for (int id = 0; id < farm().size(); ++id) {
        farm().save(id, bytes);
        ends.push_back(static_cast<std::int64_t>(bytes.size()));
    }
    ByteWriter memory;
    memory_.save(memory);
    const auto plain = [](std::span<const std::byte> b) {
        return std::span<const std::uint8_t>(reinterpret_cast<const std::uint8_t*>(b.data()), b.size());
    };
    file.write("/rves/ids", run_ids_);
    file.write("/rves/bytes", plain(bytes));
    file.write("/rves/ends", ends);
    file.write("/answers", plain(memory.bytes()));
    file.write_text("/kernel", kernel_in_words(farm()));
    file.close();
    exchange::seal(part);
    std::filesystem::rename(part, path);
}

namespace {

[[noreturn]] void fail_other_rves(const std::string& path) {
    throw Error(ExitCode::bad_input, path, "holds other RVEs than the scene calls for", "restart with the very scene that wrote it");
}

} // namespace

void Service::restore(const std::string& path) {
    std::vector<std::string> files;
    if (std::filesystem::is_directory(path)) {
        for (const auto& entry : std::filesystem::directory_iterator(path))
            if (entry.path().filename().string().starts_with("farm") && entry.path().extension() == ".h5") files.push_back(entry.path().string());
        std::sort(files.begin(), files.end());
    }
    if (files.empty()) files.push_back(std::filesystem::is_directory(path) ? (std::filesystem::path(path) / "farm.h5").string() : path); // not there: the reader says so
    std::vector<std::uint8_t> found(run_ids_.size(), 0);
    std::size_t taken = 0;
    for (const std::string& file : files) taken += restore_from(file, found);
    if (taken != run_ids_.size()) fail_other_rves(path);
}

std::size_t Service::restore_from(const std::string& path, std::vector<std::uint8_t>& found) {
    exchange::require_sealed(path);
    const Hdf5File file = Hdf5File::open(path);
    file.require_format(format);
    const std::string then = file.read_text("/kernel"), now = kernel_in_words(farm());
    if (then != now) log::warn("{} was written by kernels of {}, these are of {}: the run goes on, but not to the same bits", path, then, now);
    const auto ids = file.read<std::uint32_t>("/rves/ids").values;
    const auto bytes = file.read<std::uint8_t>("/rves/bytes").values;
    const auto ends = file.read<std::int64_t>("/rves/ends").values;
    const auto answers = file.read<std::uint8_t>("/answers").values;
    const auto sound = [&](bool holds) {
        if (!holds) fail_other_rves(path);
    };
    sound(ends.size() == ids.size());
    exchange::AnswerMemory remembered(static_cast<int>(ids.size()), answer_columns_);
    ByteReader memory({reinterpret_cast<const std::byte*>(answers.data()), answers.size()}, path);
    remembered.load(memory);
    std::map<std::uint32_t, std::size_t> place; // of an RVE of this farm, by its id in the run
    for (std::size_t own = 0; own < run_ids_.size(); ++own) place[run_ids_[own]] = own;
    std::size_t begin = 0, taken = 0;
    for (std::size_t there = 0; there < ids.size(); ++there) {
        const auto end = static_cast<std::size_t>(ends[there]);
        sound(begin <= end && end <= bytes.size());
        const std::span<const std::byte> state(reinterpret_cast<const std::byte*>(bytes.data()) + begin, end - begin);
        begin = end;
        const auto own = place.find(ids[there]);
        if (own == place.end()) continue; // another farm's
        sound(found[own->second] == 0);
        found[own->second] = 1;
        sound(farm().load(static_cast<int>(own->second), state) == state.size());
        const std::string column = what_is_no_number(std::as_const(farm()).assembly(static_cast<int>(own->second)));
        if (!column.empty()) throw Error(ExitCode::bad_input, path, "the RVE " + std::to_string(ids[there]) + " holds a number that is none, in its column " + column, "restart from another checkpoint");
        memory_.take(static_cast<std::uint32_t>(own->second), remembered, static_cast<std::uint32_t>(there));
        ++taken;
    }
    return taken;
}

} // namespace talik::farm
