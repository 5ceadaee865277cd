// rve-farm bench: the speed of this machine, on RVEs sheared to and fro at constant area.
#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/option_ranges.hpp"
#include "common/packing/packing_csv.hpp"
#include "common/packing/packing_file.hpp"
#include "rve-farm/app/commands.hpp"
#include "rve-farm/backend/farm.hpp"
#include "rve-farm/packing/prepare.hpp"

namespace talik::farm {
namespace {

struct BenchOptions {
    std::vector<int> rves, discs = {400}, threads = {1};
    std::vector<double> rates = {0.01, 0.1, 1.0}; // 1/s
    std::vector<std::string> precisions = {"single", "double"}, levels = {"auto"}, bonds = {"off", "on"}, ledger = {"off"};
    std::string backend = "cpu", packing, particles, contacts;
    int substeps = 100, windows = 15;
    double window_seconds = 0.05, skin = 0;
    bool json = false;
};

// What one row of the table is measured on.
struct BenchCase {
    int rves, threads;
    double rate; // 1/s
    Precision precision;
    Level level;
    bool bonds, ledger;
    bool cuda = false;
    int cores() const { return cuda ? 1 : threads; } // that a sub-step's time is divided by
    const char* computer() const { return cuda ? "cuda" : name_of(level); }
};

struct BenchRow {
    int contacts = 0;
    std::vector<double> whole, inner;  // of each window, us per sub-step, RVE and thread
    StageSeconds stages;               // over all windows
    double substeps_per_second = 0;    // of all RVEs, median window
    double rebuild_interval = 0;       // sub-steps
    double share(double seconds) const { return seconds / (stages.load + stages.inner + stages.close + stages.rebuild); }
};

constexpr double sub_step = 1e-5; // s

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}
double least(const std::vector<double>& values) { return *std::min_element(values.begin(), values.end()); }

Packing packing_of(const BenchOptions& options, int discs) {
    if (!options.packing.empty()) return read_packings(options.packing).at(0);
    if (!options.particles.empty()) return read_packing_csv(options.particles, options.contacts);
    RveSpec spec;
    spec.packing.discs = discs;
    spec.packing.void_ratio = 0.2;
    return prepare_packing(spec, spec.packing.seed);
}

class Shear {
public:
    Shear(const BenchOptions& options, const BenchCase& chosen, const Packing& packing)
        : options_(options), case_(chosen),
          farm_(parameters(options, chosen), {packing}, std::vector<int>(static_cast<std::size_t>(chosen.rves), 0), farm_options(chosen)),
          ids_(static_cast<std::size_t>(chosen.rves)), increments_(4 * ids_.size()), answers_(ids_.size()) {
        std::iota(ids_.begin(), ids_.end(), 0u);
        if (chosen.bonds) farm_.activate_bonds();
    }

    // Windows of macro steps, forth and back in turn; the first tell how many steps a window takes, and are not counted.
    BenchRow measure() {
        window(1); // lists, and what is done once
        int steps = 1;
        while (window(steps) < options_.window_seconds) steps *= 2;
        BenchRow row;
        const StageSeconds before = farm_.stages();
        const std::int64_t rebuilds = farm_.numbers(0).rebuilds;
        for (int k = 0; k < options_.windows; ++k) {
            const double inner = farm_.stages().inner;
            const double substeps = static_cast<double>(steps) * options_.substeps * case_.rves;
            row.whole.push_back(1e6 * window(steps) * case_.cores() / substeps);
            row.inner.push_back(1e6 * (farm_.stages().inner - inner) / substeps);
        }
        const StageSeconds after = farm_.stages();
        row.stages = {after.load - before.load, after.inner - before.inner, after.close - before.close, after.rebuild - before.rebuild};
        const auto rebuilt = static_cast<double>(farm_.numbers(0).rebuilds - rebuilds);
        row.rebuild_interval = static_cast<double>(steps) * options_.substeps * options_.windows / std::max(1.0, rebuilt);
        row.substeps_per_second = 1e6 * case_.cores() / median(row.whole);
        row.contacts = answers_[0].contacts;
        return row;
    }

private:
    static RveParameters parameters(const BenchOptions& options, const BenchCase& chosen) {
        RveParameters p;
        p.time_step = sub_step;
        p.skin = options.skin;
        if (chosen.bonds) p.bond = BondParameters{};
        return p;
    }
    static FarmOptions farm_options(const BenchCase& chosen) {
        FarmOptions o;
        o.backend = chosen.cuda ? Backend::cuda : Backend::cpu;
        o.threads = chosen.threads;
        o.level = chosen.level;
        o.precision = chosen.precision;
        o.ledger = chosen.ledger;
        o.time_stages = true;
        return o;
    }

    double window(int steps) { // seconds
        sense_ = -sense_;
        const double dt = sub_step * options_.substeps, strain = sense_ * case_.rate * dt;
        for (std::size_t i = 0; i < ids_.size(); ++i) increments_[4 * i] = strain, increments_[4 * i + 3] = -strain;
        const auto begin = std::chrono::steady_clock::now();
        for (int k = 0; k < steps; ++k) {
            farm_.advance(ids_, increments_, {}, dt, options_.substeps, answers_);
            for (const Answer& answer : answers_)
                require(answer.status == Status::ok, std::string("the RVE of the benchmark is ") + name_of(answer.status), "lower the rate");
        }
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    }

    const BenchOptions& options_;
    BenchCase case_;
    Farm farm_;
    std::vector<std::uint32_t> ids_;
    std::vector<double> increments_;
    std::vector<Answer> answers_;
    double sense_ = 1;
};

nlohmann::ordered_json in_json(const BenchCase& c, const BenchOptions& options, int discs, const BenchRow& row) {
    nlohmann::ordered_json json;
    json["backend"] = c.cuda ? "cuda" : "cpu";
    json["simd"] = c.computer();
    json["precision"] = name_of(c.precision);
    json["threads"] = c.threads;
    json["rves"] = c.rves;
    json["discs"] = discs;
    json["contacts"] = row.contacts;
    json["bonded"] = c.bonds;
    json["ledger"] = c.ledger;
    json["rate"] = c.rate;
    json["substeps"] = options.substeps;
    json["us_per_substep"] = {{"median", median(row.whole)}, {"min", least(row.whole)}};
    // On a GPU load, sub-steps and store are one launch: there is no telling them apart.
    if (!c.cuda) json["us_per_substep_inner"] = {{"median", median(row.inner)}, {"min", least(row.inner)}};
    if (!c.cuda) json["share"] = {{"load", row.share(row.stages.load)}, {"inner", row.share(row.stages.inner)}, {"store", row.share(row.stages.close)}, {"rebuild", row.share(row.stages.rebuild)}};
    json["substeps_between_rebuilds"] = row.rebuild_interval;
    json["rve_substeps_per_s"] = row.substeps_per_second;
    json["particle_steps_per_s"] = row.substeps_per_second * discs;
    return json;
}

void print_head() {
    fmt::print("                                                                | us per sub-step |   inner loop    |    share in %      | RVE sub-\n"
               "simd    prec.   threads  RVEs  discs contacts bonds ledger  1/s |  median     min |  median     min | load store rebuild |  steps/s\n");
}

void print(const BenchCase& c, int discs, const BenchRow& row) {
    fmt::print("{:<7} {:<7} {:>7} {:>5} {:>6} {:>8} {:>5} {:>6} {:>4} | {:>7.3f} {:>7.3f} | ", c.computer(), name_of(c.precision), c.threads, c.rves, discs, row.contacts,
               c.bonds ? "on" : "off", c.ledger ? "on" : "off", c.rate, median(row.whole), least(row.whole));
    if (c.cuda) fmt::print("      -       - |    -     -       - | {:>8.3g}\n", row.substeps_per_second);
    else
        fmt::print("{:>7.3f} {:>7.3f} | {:>4.1f} {:>5.1f} {:>7.1f} | {:>8.3g}\n", median(row.inner), least(row.inner), 100 * row.share(row.stages.load), 100 * row.share(row.stages.close),
                   100 * row.share(row.stages.rebuild), row.substeps_per_second);
    std::fflush(stdout);
}

std::vector<Level> levels_of(const std::vector<std::string>& names) {
    std::vector<Level> levels;
    for (const std::string& name : names) {
        if (name == "all") return levels_of_this_machine();
        levels.push_back(level_named(name).value_or(best_level()));
        kernel(levels.back(), Precision::double_); // refuses what this machine lacks
    }
    return levels;
}

bool on_gpu(const BenchOptions& o) {
    if (o.backend == "cuda") require_gpu(Backend::cuda);
    return o.backend == "cuda" || (o.backend == "auto" && !open_gpus().devices.empty());
}

std::vector<BenchCase> cases_of(const BenchOptions& o, bool cuda) {
    std::vector<BenchCase> cases;
    const std::vector<Level> levels = cuda ? std::vector<Level>{best_level()} : levels_of(o.levels);
    for (const Level level : levels)
        for (const std::string& precision : o.precisions)
            for (const std::string& bonds : o.bonds)
                for (const std::string& ledger : o.ledger)
                    for (const int threads : o.threads)
                        for (const int rves : o.rves)
                            for (const double rate : o.rates)
                                cases.push_back({std::max(rves, cuda ? 1 : threads), threads, rate, precision == "single" ? Precision::single_ : Precision::double_, level,
                                                 bonds == "on", ledger == "on", cuda});
    return cases;
}

void bench(BenchOptions options) {
    const bool cuda = on_gpu(options);
    if (options.rves.empty()) options.rves = cuda ? std::vector<int>{132, 1024, 10000} : std::vector<int>{8}; // 132: the multiprocessors of an H200
    const std::vector<BenchCase> cases = cases_of(options, cuda);
    if (!options.json) print_head();
    auto rows = nlohmann::ordered_json::array();
    for (const int discs : options.discs) {
        const Packing packing = packing_of(options, discs);
        for (const BenchCase& chosen : cases) {
            const BenchRow row = Shear(options, chosen, packing).measure();
            if (options.json) rows.push_back(in_json(chosen, options, packing.disc_count(), row));
            else print(chosen, packing.disc_count(), row);
        }
    }
    if (options.json) fmt::print("{}\n", rows.dump(1));
}

} // namespace

void add_bench(CLI::App& app) {
    auto o = std::make_shared<BenchOptions>();
    CLI::App* command = app.add_subcommand("bench", "Measures the speed of this machine: every combination of the lists given, a row each");
    command->footer("Examples:\n"
                    "  rve-farm bench\n"
                    "  rve-farm bench --simd all --precision single --rate 0.01 --bonds off\n"
                    "  rve-farm bench --backend cuda --rves 132,10000 --discs 100,400,1000 --rate 0.01\n"
                    "  rve-farm bench --threads 1,2 --rves 64 --json > speed.json");
    const auto list = [&](const char* name, auto& values, const char* meaning) { return command->add_option(name, values, meaning)->delimiter(','); };
    list("--rves", o->rves, "RVEs in the farm; 8, on a GPU 132, 1024 and 10000")->check(CLI::Range(1, 1000000));
    list("--discs", o->discs, "in each RVE; packings are prepared at 100 kPa, void ratio 0.2")->check(CLI::Range(4, 100000));
    list("--threads", o->threads, "of the farm")->check(CLI::Range(1, 4096));
    list("--rate", o->rates, "strain rate, 1/s")->check(CLI::Range(0.0, 100.0));
    list("--precision", o->precisions, "single, double")->check(CLI::IsMember({"single", "double"}));
    list("--simd", o->levels, "auto, all, plain, sse4, avx2, avx512")->check(CLI::IsMember({"auto", "all", "plain", "sse4", "avx2", "avx512"}));
    list("--bonds", o->bonds, "off, on")->check(CLI::IsMember({"off", "on"}));
    list("--ledger", o->ledger, "off, on: work and dissipation booked")->check(CLI::IsMember({"off", "on"}));
    command->add_option("--backend", o->backend, "cpu, cuda, or auto: a GPU where there is one")->check(CLI::IsMember({"auto", "cpu", "cuda"}));
    command->add_option("--packing", o->packing, "HDF5 file of a packing to measure on")->check(CLI::ExistingFile);
    command->add_option("--particles", o->particles, "or CSV file of its discs")->check(CLI::ExistingFile);
    command->add_option("--contacts", o->contacts, "and CSV file of its contacts")->check(CLI::ExistingFile);
    command->add_option("--steps", o->substeps, "sub-steps in a macro step, of 1e-5 s")->check(CLI::Range(1, 1000000));
    command->add_option("--skin", o->skin, "of the neighbour list, m; 0 = chosen as it goes")->check(CLI::NonNegativeNumber);
    command->add_option("--windows", o->windows, "that are timed for each row")->check(CLI::Range(1, 100000));
    command->add_option("--window-seconds", o->window_seconds, "least length of each")->check(above_zero());
    command->add_flag("--json", o->json, "one object a row");
    command->callback([o] { bench(*o); });
}

} // namespace talik::farm
