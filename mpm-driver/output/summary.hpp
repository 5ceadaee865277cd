#pragma once
// summary.json: what a run was, what it cost, and how well its balances close.
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "exchange/farm_end.hpp"
#include "mpm-driver/mechanics/simulation.hpp"

namespace talik::driver {

struct Effects {
    std::vector<std::string> on, off; // each with its reason: "bonds: [rve.bond] is in the scene"
};
Effects effects_of(const Scene& scene);

// A packing that RVEs start from, and the stress that it starts with.
struct PackingFact {
    std::uint64_t seed = 0;
    double void_ratio = 0.0;                             // area based, -
    double pressure = 0.0;                               // Pa, isotropic, compression positive
    double vertical_stress = 0.0, lateral_stress = 0.0;  // Pa, of a snapshot along a K0 path; 0 = isotropic
};

// What a run adds to what the simulation itself knows.
struct RunFacts {
    std::string farm;                        // "rve-farm 0.1.0, 2 threads"; empty where no RVE is called for
    std::int64_t rves = 0;
    std::vector<PackingFact> packings;
    std::int64_t evaluations_asked = 0, evaluations_done = 0;
    std::int64_t rves_without_contacts = 0;  // at the end
    std::int64_t split_steps = 0;            // RVE steps that took more sub-steps than asked for
    double dem_time = 0.0;                   // s, that the RVEs have lived through
    double dem_time_step = 0.0;              // s, of the last macro step; 0 where no RVE is called for
    double wall_seconds = 0.0, cpu_seconds = 0.0;
    std::vector<std::pair<std::string, double>> stage_seconds;
    int farms = 0, farms_replaced = 0;   // that answered side by side; that took over from one that was lost
    double seconds_lost = 0.0;           // s, with farms that were lost
    int rves_moved = 0;                  // times that RVEs changed hands between farms
    double waiting_driver = 0.0;         // s
    std::optional<double> waiting_farm;  // s; empty where the farm was lost before it could tell
    exchange::LockstepTimes driver_times;                // in steps
    std::optional<exchange::LockstepTimes> farm_times;   // empty as above
    std::optional<double> recording_seconds;             // of the driver's thread; empty where nothing was recorded
    double recording_packing_seconds = 0.0;              // CPU time of compressing, by another thread
    std::vector<std::string> warnings;
    int exit = 0;
    std::string cause;                       // of the end, where it was not the scene's
};

void write_summary(const std::filesystem::path& path, const Simulation& simulation, const RunFacts& facts);

// The side that the other one waits for, and what it spends most of its time on: "farm: computing". Empty without a farm.
std::string bottleneck(const RunFacts& facts);

// The short table a run ends with.
std::string summary_table(const Simulation& simulation, const RunFacts& facts);

} // namespace talik::driver
