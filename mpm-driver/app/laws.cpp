#include "mpm-driver/app/laws.hpp"

#include <fmt/format.h>

#include <cmath>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "common/base/version.hpp"
#include "mpm-driver/app/packings.hpp"
#include "mpm-driver/app/scene_schema.hpp"
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

} // namespace

SceneLaws make_laws(Scene& scene, const RunOptions& options, const std::filesystem::path& output) {
    SceneLaws out;
    if (scene.elastic) out.laws_["elastic"] = std::make_unique<ElasticLaw>(*scene.elastic);
    if (scene.rve) {
        FarmSetup setup;
        setup.parameters = scene.rve->parameters;
        complete_k0_range(scene);
        setup.packings = obtain_packings(*scene.rve, options.threads, options.quiet);
        for (BodySpec& body : scene.bodies)
            if (body.law == "rve" && !body.density) body.density = bulk_density(setup.packings, setup.parameters.grain_density);
        out.warnings_ = packing_warnings(scene, setup.packings);
        for (const Packing& p : setup.packings) out.packings_.push_back({p.seed, p.void_ratio(), p.pressure, p.vertical_stress, p.lateral_stress});
        for (const std::string& warning : out.warnings_) log::warn("{}", warning);
        out.partner_ = std::make_unique<FarmPartner>(PartnerOptions{options.exchange, options.backend, options.farms, options.threads, options.stall_seconds, options.attach_seconds, options.quiet});
        exchange::Hello hello;
        hello.program = "mpm-driver " + version();
        hello.run_id = out.partner_->run_id();
        hello.scene_hash = scene.hash;
        auto law = std::make_unique<FarmLaw>(group_of(*out.partner_, read_exchange(options.scene, options.set), output), hello, std::move(setup), scene.seed);
        law->start_at_depth(Overburden(scene));
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
    facts.waiting_farm = farm_waited_;
    return facts;
}

void SceneLaws::bye() {
    if (!farm_) return;
    farm_waited_ = farm_->farm_waiting_seconds();
    farm_->bye();
}

} // namespace talik::driver
