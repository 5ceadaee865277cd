// What the safeguards of a step cost on the shipped scenes: two runs of one scene, step by step in turn, one with them and one without.
// They change parts every other step: where a run's arrays happen to lie in memory makes it some per cent faster or slower than its twin.
// Hidden: tools/hard-cases --cost runs it.
#include <time.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "mpm-driver/constitutive/elastic.hpp"
#include "tests/hard/hard_case.hpp"
#include "tests/lockstep/in_process.hpp"

using namespace talik;
using namespace talik::driver;

namespace {

double cpu_seconds() { // of both ends: the other pair waits meanwhile
    timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Side {
    Side(const lockstep::Prepared* prepared, const Scene& scene) {
        omp_set_num_threads(1);
        if (prepared) {
            farm = std::make_unique<lockstep::FarmInThread>("loopback", 1);
            coupled = std::make_unique<lockstep::Coupled>(*prepared, *farm);
            simulation = coupled->simulation.get();
        } else {
            Simulation::Laws laws;
            if (scene.elastic) laws["elastic"] = std::make_unique<ElasticLaw>(*scene.elastic);
            own = std::make_unique<Simulation>(scene, std::move(laws));
            simulation = own.get();
        }
    }
    double step(bool safeguards) {
        simulation->leave_out_safeguards(!safeguards);
        if (coupled) coupled->law->leave_out_checks(!safeguards);
        const double begin = cpu_seconds();
        simulation->step(simulation->next_step());
        return cpu_seconds() - begin;
    }
    std::unique_ptr<lockstep::FarmInThread> farm;
    std::unique_ptr<lockstep::Coupled> coupled;
    std::unique_ptr<Simulation> own;
    Simulation* simulation;
};

} // namespace

TEST_CASE("the safeguards cost less than two per cent of the shipped scenes", "[.cost]") {
    hard::HardCase hard("cost", "safeguards on the shipped scenes", "what is checked in every step slows every run");
    for (const auto& [file, steps] : {std::pair{"cases/biaxial/dense.toml", 80}, std::pair{"cases/thaw-slope/quick.toml", 80}, std::pair{"cases/neumann/soil.toml", 2000}}) {
        const std::string path = std::string(TALIK_SOURCE_DIR) + "/" + file;
        const Scene scene = read_scene(path);
        const char* cache = std::getenv("TALIK_CACHE");
        std::optional<lockstep::Prepared> prepared;
        if (scene.rve) prepared = lockstep::prepare(path, cache ? cache : std::string(TALIK_BINARY_DIR) + "/cost-cache");
        Side one(prepared ? &*prepared : nullptr, scene), other(prepared ? &*prepared : nullptr, scene);
        double sum_with = 0.0, sum_without = 0.0;
        std::vector<double> ratios;
        for (int k = 0; k < steps; k += 2) {
            double with = 0.0, without = 0.0;
            with += one.step(true), without += other.step(false);
            with += other.step(true), without += one.step(false);
            sum_with += with, sum_without += without;
            ratios.push_back(with / without);
        }
        std::sort(ratios.begin(), ratios.end());
        std::printf("cost\t%s\t%d steps\tsum %.4f\tmedian %.4f\n", file, steps, sum_with / sum_without - 1.0, ratios[ratios.size() / 2] - 1.0);
        hard.holds({"CPU time with over without, median of the steps, less 1", 0.02, "a fiftieth of a run is a price for never computing with nonsense"}, ratios[ratios.size() / 2] - 1.0, file);
        if (one.coupled) one.coupled->law->bye(), other.coupled->law->bye();
    }
}
