#include "mpm-driver/app/run.hpp"

#include <fmt/format.h>
#include <omp.h>
#include <sys/resource.h>

#include <chrono>
#include <filesystem>

#include "common/base/error.hpp"
#include "common/base/interrupt.hpp"
#include "common/base/log.hpp"
#include "common/base/progress.hpp"
#include "common/base/version.hpp"
#include "common/io/text_file.hpp"
#include "common/physics/clock.hpp"
#include "exchange/mpi_channel.hpp"
#include "exchange/run_board.hpp"
#include "exchange/transport.hpp"
#include "mpm-driver/app/farm_partner.hpp"
#include "mpm-driver/app/laws.hpp"
#include "mpm-driver/app/output_folder.hpp"
#include "mpm-driver/app/scene_schema.hpp"
#include "mpm-driver/app/scene_tables.hpp"
#include "mpm-driver/output/checkpoint.hpp"
#include "mpm-driver/output/history.hpp"
#include "mpm-driver/output/quantities.hpp"
#include "mpm-driver/output/summary.hpp"

namespace talik::driver {
namespace {

namespace fs = std::filesystem;

double cpu_seconds() { // of this process and its ended children
    double sum = 0.0;
    for (const auto who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
        rusage usage{};
        getrusage(who, &usage);
        sum += static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) + 1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
    }
    return sum;
}

// Due at the first step on or after each multiple of the interval.
bool due(double interval, double before, double now) {
    if (interval <= 0.0) return false;
    const double slack = 1e-9; // of an interval: multiples of a decimal step are not exact
    return std::floor(now / interval + slack) > std::floor(before / interval + slack);
}

fs::path output_folder(const RunOptions& options) {
    const fs::path folder = options.output.empty() ? fs::path("out") / fs::path(options.scene).stem() : fs::path(options.output);
    make_folder(folder);
    return folder;
}

class Run {
public:
    Run(const RunOptions& options, const fs::path& output, const Scene& scene, SceneLaws& laws)
        : options_(options), scene_(scene), output_(output), laws_(laws), simulation_(scene_, laws_.take()) {
        if (!options.restart.empty()) restore_checkpoint(simulation_, options.restart);
    }

    // What an earlier run left in the folder goes only once nothing speaks against this one.
    void begin() {
        check_damping();
        if (options_.restart.empty()) simulation_.check_next_step();
        if (scene_.rve && !simulation_.finished()) substeps_of(scene_.rve->parameters, simulation_.next_step()); // too many are refused
        begun_ = true;
        checkpoints_.emplace(output_);
        if (options_.restart.empty())
            if (const int old = remove_checkpoints(output_)) log::info("removed {} checkpoint(s) of an earlier run from {}", old, output_.string());
        const std::int64_t keep = options_.restart.empty() ? -1 : simulation_.steps_done();
        std::vector<std::string> names;
        for (const HistoryValue& value : history_values(simulation_)) names.push_back(value.name);
        history_.emplace(output_ / "history.csv", names, keep);
        fields_.emplace(output_, keep);
        if (options_.restart.empty()) {
            write_history();
            write_fields();
        }
    }

    void announce() const {
        const Effects effects = effects_of(scene_);
        if (const HeatSolver* heat = simulation_.heat())
            for (const std::string& warning : heat->warnings()) log::warn("{}", warning);
        log::info("{}: {} points, {} RVEs; output in {}", scene_.title, simulation_.points().count(), laws_.rves(), output_.string());
        for (const auto& effect : effects.on) log::info("on   {}", effect);
        for (const auto& effect : effects.off) log::info("off  {}", effect);
        log::info("a step: {}", fmt::join(simulation_.schedule().table_of_contents(), " > "));
        log::info("largest stable step: {}", simulation_.describe_limits());
    }

    int go() {
        const double end = options_.until ? std::min(*options_.until, simulation_.end_time()) : simulation_.end_time();
        Progress progress(scene_.title.empty() ? scene_.file : scene_.title, options_.quiet);
        exchange::Board& board = exchange::run_board();
        board.first_step = board.step = static_cast<std::uint64_t>(simulation_.steps_done());
        board.first_fraction = board.fraction = simulation_.time() / end;
        board.began = exchange::monotonic_seconds();
        while (!simulation_.finished() && simulation_.time() < end * (1.0 - 1e-12)) {
            if (interrupted()) stop(fmt::format("stopped by {}", interrupt_name()));
            if (laws_.farm_wishes_to_end()) stop("stopped because the farm was asked to end");
            advance();
            laws_.keep_up();
            show_standing(board, simulation_.time() / end);
            progress.update(simulation_.time() / end, fmt::format("t = {:.4g} s, step {}", simulation_.time(), simulation_.steps_done()));
        }
        if (!written_fields_) write_fields();
        if (history_->last_step() != simulation_.steps_done()) write_history();
        write_checkpoint();
        laws_.bye();
        return 0;
    }

    // After the end of go(), however it ended. A run refused before it began leaves the summary of the one before it.
    void close(int exit, const std::string& cause) {
        if (!begun_ && fs::exists(output_ / "summary.json")) return;
        RunFacts facts = laws_.facts();
        for (const std::string& warning : simulation_.warnings()) facts.warnings.push_back(warning);
        if (const HeatSolver* heat = simulation_.heat())
            for (const std::string& warning : heat->warnings()) facts.warnings.push_back(warning);
        facts.wall_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
        facts.stage_seconds = simulation_.schedule().timer().rows();
        facts.stage_seconds.emplace_back("output", output_seconds_);
        facts.driver_times.computing = std::max(0.0, facts.wall_seconds - facts.driver_times.copying - facts.driver_times.waiting - facts.recording_seconds.value_or(0.0));
        facts.exit = exit;
        facts.cause = cause;
        facts.cpu_seconds = cpu_seconds();
        write_summary(output_ / "summary.json", simulation_, facts);
        if (!options_.quiet) fmt::print(stderr, "\n{}{}", summary_table(simulation_, facts), fmt::format("  {:<28}{}\n", "output", output_.string()));
    }

    std::string newest_checkpoint() const {
        return checkpoints_ && !checkpoints_->newest().empty() ? checkpoints_->newest().string() : options_.restart;
    }

private:
    // Of every stage against the first step: an automatic one is known only now.
    void check_damping() const {
        if (simulation_.finished()) return;
        const double step = simulation_.next_step();
        for (std::size_t i = 0; i < scene_.stages.size(); ++i)
            for (const DampingFault& fault : damping_faults(scene_.stages[i], step))
                throw Error(ExitCode::bad_input, fmt::format("{}: stage.{}.{}", scene_.file, i, fault.key), fault.problem, fault.remedy);
    }

    // For `rve-farm status`.
    void show_standing(exchange::Board& board, double fraction) const {
        board.step = static_cast<std::uint64_t>(simulation_.steps_done());
        board.time = simulation_.time();
        board.fraction = fraction;
        board.updated = exchange::monotonic_seconds();
        if (!laws_.farm()) return;
        board.copying = laws_.farm()->copying_seconds();
        board.waiting = laws_.farm()->waiting_seconds();
        board.computing = std::max(0.0, board.updated - board.began - board.copying - board.waiting);
    }

    void advance() {
        const double before = simulation_.time();
        const int stage = simulation_.stage();
        simulation_.step(simulation_.next_step());
        const auto timed = StageTimer::Scope(output_seconds_);
        const double now = simulation_.time();
        const bool turn = simulation_.stage() != stage;
        if (turn) warn_of_stages();
        if (turn && !simulation_.finished()) log::info("t = {:.4g} s: stage \"{}\"", now, scene_.stages[static_cast<std::size_t>(simulation_.stage())].name);
        if (scene_.output.history_interval <= 0.0 || due(scene_.output.history_interval, before, now)) write_history();
        written_fields_ = due(scene_.output.fields_interval, before, now);
        if (written_fields_) write_fields();
        if (due(scene_.output.checkpoint_interval, before, now)) write_checkpoint();
    }

    // Once for each, also for those of stages before a restart.
    void warn_of_stages() {
        const std::vector<std::string> warnings = simulation_.warnings();
        for (; warned_ < warnings.size(); ++warned_) log::warn("{}", warnings[warned_]);
    }

    void write_history() {
        std::vector<double> values;
        for (const HistoryValue& value : history_values(simulation_)) values.push_back(value.value);
        history_->row(simulation_.steps_done(), simulation_.time(), values);
    }
    void write_fields() { fields_->write(simulation_.steps_done(), simulation_.time(), simulation_.grid().thickness(), field_columns(simulation_)); }
    // Once per step: the end of a run may fall on a checkpoint that is due.
    void write_checkpoint() {
        if (checkpointed_step_ == simulation_.steps_done()) return;
        checkpoints_->write(simulation_);
        checkpointed_step_ = simulation_.steps_done();
    }

    // In order: the checkpoint first, then the farm's leave, so that it does not take our end for a death.
    [[noreturn]] void stop(const std::string& why) {
        write_checkpoint();
        laws_.bye();
        fail(ExitCode::failed, fmt::format("{} at t = {:.6g} s", why, simulation_.time()), "go on with --restart " + newest_checkpoint());
    }

    RunOptions options_;
    Scene scene_;
    fs::path output_;
    SceneLaws& laws_;
    Simulation simulation_;
    std::optional<Checkpoints> checkpoints_;
    std::optional<History> history_;
    std::optional<FieldsWriter> fields_;
    bool begun_ = false, written_fields_ = false;
    std::size_t warned_ = 0; // of the simulation's warnings, said
    std::int64_t checkpointed_step_ = -1;
    double output_seconds_ = 0.0;
    std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

// The run with its books closed at its end, whichever that is: the summary is written, and the error names the checkpoint.
int go_and_close(Run& run) {
    try {
        run.begin();
        const int exit = run.go();
        run.close(exit, "");
        return exit;
    } catch (const Error& error) {
        try {
            run.close(static_cast<int>(error.code()), error.what());
        } catch (const std::exception& second) { // a full disk, again: it must not hide what ended the run
            log::warn("no summary of this run: {}", second.what());
        }
        const std::string checkpoint = run.newest_checkpoint();
        const std::string last = checkpoint.empty() ? "no checkpoint was written yet" : "last good checkpoint: " + checkpoint;
        throw Error(error.code(), error.where(), error.problem(), error.remedy().find("--restart") == std::string::npos ? error.remedy() + "; " + last : error.remedy());
    }
}

} // namespace

int run(const RunOptions& options) {
    if (options.threads > 0) omp_set_num_threads(options.threads);
    Scene scene = read_scene(options.scene, options.set);
    const fs::path output = output_folder(options);
    const OutputLock lock(output);
    require_room_for_files(output);
    if (exchange::is_mpi(options.exchange)) {
        require(scene.rve.has_value(), "--exchange mpi: the scene has no RVEs for farms to answer", "run it without mpirun");
        exchange::begin_mpi(exchange::Role::driver); // before packings are prepared: farms may wait in it
    }
    exchange::publish_run_board(exchange::Role::driver, options.exchange, scene.title, fs::absolute(output).lexically_normal().string());
    SceneLaws laws = make_laws(scene, options, output); // outlives the run, so that the farm is told what ended it
    return laws.with_cause([&] {
        Run run(options, output, scene, laws);
        run.announce();
        return go_and_close(run);
    });
}

} // namespace talik::driver
