#pragma once
// The laws a scene calls for, and nothing else: elastic where a body asks for it, a farm where RVEs are asked for.
#include <filesystem>
#include <memory>
#include <optional>

#include "mpm-driver/app/farm_partner.hpp"
#include "mpm-driver/app/run.hpp"
#include "mpm-driver/constitutive/farm_law.hpp"
#include "mpm-driver/mechanics/simulation.hpp"
#include "mpm-driver/output/summary.hpp"

namespace talik::driver {

class SceneLaws {
public:
    SceneLaws(SceneLaws&&) = default;
    Simulation::Laws take() { return std::move(laws_); } // for the simulation, once
    RunFacts facts() const;                              // of the farm
    std::int64_t rves() const { return farm_ ? farm_->rves() : 0; }
    const FarmLaw* farm() const { return farm_; } // null where there is none
    bool farm_wishes_to_end() const { return farm_ && partner_->wishes_to_end(); }
    void keep_up() { if (farm_) farm_->keep_up(); } // between two steps: what a lost farm would cost stays bounded
    void bye(); // the farm says how long it waited, and ends

    // Should the body end by an exception, the farms learn why.
    template <class Body>
    auto with_cause(Body&& body) {
        try {
            return body();
        } catch (const std::exception& error) {
            if (partner_) partner_->state_cause(error.what());
            throw;
        }
    }

private:
    friend SceneLaws make_laws(Scene& scene, const RunOptions& options, const std::filesystem::path& output);
    SceneLaws() = default;
    std::unique_ptr<FarmPartner> partner_; // outlives the law that speaks through it
    Simulation::Laws laws_;
    FarmLaw* farm_ = nullptr;
    std::vector<std::string> warnings_;
    std::vector<PackingFact> packings_;
    std::optional<exchange::LockstepTimes> farm_times_; // empty until the farm has said so
};

// Starts the farm where there is one; sets the bulk density of bodies whose scene leaves it to the RVEs.
SceneLaws make_laws(Scene& scene, const RunOptions& options, const std::filesystem::path& output);

// What a user should know before packings and scene are put together; empty where they fit.
std::vector<std::string> packing_warnings(const Scene& scene, const std::vector<Packing>& packings);

// Bulk density of a packing's discs, kg/m^3: grain density / (1 + e); the mean over the packings.
double bulk_density(const std::vector<Packing>& packings, double grain_density);

} // namespace talik::driver
