#include "mpm-driver/app/laws.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "common/base/version.hpp"
#include "exchange/record_file.hpp"
#include "mpm-driver/app/output_folder.hpp"
#include "mpm-driver/app/packings.hpp"
#include "mpm-driver/app/scene_schema.hpp"
#include "mpm-driver/app/scene_tables.hpp"
#include "mpm-driver/constitutive/elastic.hpp"
#include "mpm-driver/points/overburden.hpp"

namespace talik::driver {

double bulk_density(const std::vector<Packing>& packings, double grain_density) {
    double sum = 0.0;
    for (const Packing& packing : packings) sum += grain_density / (1.0 + packing.void_ratio());
    return sum / static_cast<double>(packings.size());
}

std::vector<std::string> packing_warnings(const Scene& scene, const std::vector<Packing>& packings) {
    std::vector<std::string> warnings;
    double pressure = 0.0; // Pa, mean over the packings
    if (!packings.empty() && packings.front().vertical_stress > 0.0) return warnings; // at the stress of depth: level by level
    for (const Packing& packing : packings) pressure += packing.pressure / static_cast<double>(packings.size());
    if (scene.confining_pressure > 0.0 && pressure > 0.0 && std::abs(pressure - scene.confining_pressure) > 0.01 * scene.confining_pressure)
        warnings.push_back(fmt::format("the packings were prepared at {:.4g} Pa, the confining pressure is {:.4g} Pa: the run starts with a shock",
                                       pressure, scene.confining_pressure));
    return warnings;
}

namespace {

exchange::FarmGroup group_of(FarmPartner& partner, const ExchangeSpec& spec, const std::filesystem::path& output) {
    exchange::FarmGroup farms(partner.channels());
    if (spec.replace_farm == 0) return farms;
    if (!partner.may_be_replaced()) {
        log::warn("exchange.replace_farm is of no use in an MPI job, which ends with any of its processes: start it with tools/run-mpi, which restarts it");
        return farms;
    }
    farms.replace_lost_farms({spec.replace_farm, [&partner](int farm) -> exchange::Channel& { return partner.another(farm); }, output / "recovery", spec.replace_interval});
    return farms;
}

std::vector<std::string> replay_arguments(const RunOptions& options) {
    std::vector<std::string> arguments;
    if (options.replay.empty()) return arguments;
    arguments.push_back(std::filesystem::absolute(options.replay).string());
    if (options.loose) arguments.push_back("--loose");
    if (options.tolerance) arguments.insert(arguments.end(), {"--tolerance", fmt::format("{}", *options.tolerance)});
    return arguments;
}

void check_recording(const Scene& scene, const RunOptions& options, const std::filesystem::path& output) {
    require(options.replay.empty() || options.exchange.empty(), "--replay and --exchange are both given", "start `rve-farm replay` at that exchange by hand, or leave --exchange out");
    require(options.replay.empty() || std::filesystem::exists(options.replay), options.replay + ": no such recording", "record one: mpm-driver run SCENE --record FILE");
    if (!options.replay.empty()) exchange::Record{options.replay}; // what is no recording is said here, before a farm is started
    std::error_code none;
    require(options.record.empty() || options.replay.empty() || !std::filesystem::equivalent(options.record, options.replay, none), "--record would overwrite the recording that --replay reads",
            "name another file");
    require(options.replay.empty() || options.farms <= 1, "--replay and --farms are both given", "leave --farms out: one recording answers for all");
    require(!options.replay.empty() || !(options.loose || options.tolerance), "--loose and --tolerance are for --replay", "give --replay FILE as well, or leave them out");
    require(scene.rve.has_value() || (options.record.empty() && options.replay.empty()), "the scene has no RVEs: there is nothing to record or replay", "leave --record and --replay out");
    require(scene.rve.has_value() || options.exchange.empty(), "--exchange " + options.exchange + ": the scene has no RVEs for a farm to answer", "leave --exchange out");
    if (options.record.empty()) return;
    require(!is_written_by_run(output, options.record), "--record " + options.record + ": the run writes that file itself", "name another file, record.h5 for one");
    exchange::check_place_of_record(options.record);
}

} // namespace

SceneLaws make_laws(Scene& scene, const RunOptions& options, const std::filesystem::path& output) {
    check_recording(scene, options, output);
    SceneLaws out;
    out.warnings_ = seeding_warnings(scene);
    for (const std::string& warning : out.warnings_) log::warn("{}", warning);
    if (scene.elastic) out.laws_["elastic"] = std::make_unique<ElasticLaw>(*scene.elastic);
    if (scene.rve) {
        FarmSetup setup;
        setup.parameters = scene.rve->parameters;
        complete_k0_range(scene);
        setup.packings = obtain_packings(*scene.rve, options.threads, options.quiet);
        for (BodySpec& body : scene.bodies)
            if (body.law == "rve" && !body.density) body.density = bulk_density(setup.packings, setup.parameters.grain_density);
        for (const Packing& p : setup.packings) out.packings_.push_back({p.seed, p.void_ratio(), p.pressure, p.vertical_stress, p.lateral_stress});
        for (const std::string& warning : packing_warnings(scene, setup.packings)) log::warn("{}", warning), out.warnings_.push_back(warning);
        out.partner_ = std::make_unique<FarmPartner>(
            PartnerOptions{options.exchange, options.backend, replay_arguments(options), options.farms, options.threads, options.stall_seconds, options.attach_seconds, options.quiet});
        exchange::Hello hello;
        hello.program = "mpm-driver " + version();
        hello.run_id = out.partner_->run_id();
        hello.scene_hash = scene.hash;
        auto law = std::make_unique<FarmLaw>(group_of(*out.partner_, read_exchange(options.scene, options.set), output), hello, std::move(setup), scene.seed);
        law->start_at_depth(Overburden(scene));
        law->record(options.record);
        out.farm_ = law.get();
        out.laws_["rve"] = std::move(law);
    }
    return out;
}

RunFacts SceneLaws::facts() const {
    RunFacts facts;
    facts.warnings = warnings_;
    facts.packings = packings_;
    if (!farm_) return facts;
    facts.farm = farm_->farm_program();
    facts.rves = farm_->rves();
    facts.evaluations_asked = facts.evaluations_done = farm_->evaluations();
    facts.split_steps = farm_->split_steps();
    facts.dem_time = farm_->dem_time();
    facts.dem_time_step = farm_->dem_time_step();
    facts.rves_without_contacts = farm_->rves_without_contacts();
    if (facts.rves_without_contacts > 0)
        facts.warnings.push_back(fmt::format("{} of {} RVEs carry no contact force at the end: opened by tension, or by stresses that ring inside a cell (docs/method.md, limits)",
                                             facts.rves_without_contacts, facts.rves));
    facts.waiting_driver = farm_->farms().waiting_seconds();
    facts.farms = farm_->farms().farms();
    facts.farms_replaced = farm_->farms().replaced();
    facts.seconds_lost = farm_->farms().seconds_lost();
    facts.rves_moved = farm_->farms().moves();
    if (farm_times_) facts.waiting_farm = farm_times_->waiting;
    facts.farm_times = farm_times_;
    facts.driver_times = {0.0, farm_->copying_seconds(), farm_->waiting_seconds()}; // computing: the rest, once all is known
    if (farm_->recording_seconds() > 0.0) facts.recording_seconds = farm_->recording_seconds(), facts.recording_packing_seconds = farm_->packing_seconds();
    return facts;
}

void SceneLaws::bye() {
    if (!farm_) return;
    farm_times_ = farm_->farm_times();
    farm_->bye();
    partner_->wait_for_their_end(); // then their CPU time can be counted
}

} // namespace talik::driver
