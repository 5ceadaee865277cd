// What the safeguards of a step cost on the shipped scenes: two runs of one scene, with and without, step by step in turn.
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
    explicit Side(const lockstep::Prepared* prepared, const Scene& scene, bool safeguards) {
        omp_set_num_threads(1);
        if (prepared) {
            farm = std::make_unique<lockstep::FarmInThread>("loopback", 1);
            coupled = std::make_unique<lockstep::Coupled>(*prepared, *farm);
            if (!safeguards) coupled->law->leave_out_checks();
            simulation = coupled->simulation.get();
        } else {
            Simulation::Laws laws;
            if (scene.elastic) laws["elastic"] = std::make_unique<ElasticLaw>(*scene.elastic);
            own = std::make_unique<Simulation>(scene, std::move(laws));
            simulation = own.get();
        }
        if (!safeguards) simulation->leave_out_safeguards();
    }
    double step() {
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
    for (const auto& [file, steps] : {std::pair{"cases/biaxial/dense.toml", 40}, std::pair{"cases/thaw-slope/quick.toml", 40}, std::pair{"cases/neumann/soil.toml", 2000}}) {
        const std::string path = std::string(TALIK_SOURCE_DIR) + "/" + file;
        const Scene scene = read_scene(path);
        const char* cache = std::getenv("TALIK_CACHE");
        std::optional<lockstep::Prepared> prepared;
        if (scene.rve) prepared = lockstep::prepare(path, cache ? cache : std::string(TALIK_BINARY_DIR) + "/cost-cache");
        Side with(prepared ? &*prepared : nullptr, scene, true), without(prepared ? &*prepared : nullptr, scene, false);
        double sum_with = 0.0, sum_without = 0.0;
        std::vector<double> ratios;
        for (int k = 0; k < steps; ++k) { // first one, then the other
            const double first = k % 2 ? without.step() : with.step(), second = k % 2 ? with.step() : without.step();
            const double a = k % 2 ? second : first, b = k % 2 ? first : second;
            sum_with += a, sum_without += b;
            ratios.push_back(a / b);
        }
        std::sort(ratios.begin(), ratios.end());
        std::printf("cost\t%s\t%d steps\tsum %.4f\tmedian %.4f\n", file, steps, sum_with / sum_without - 1.0, ratios[ratios.size() / 2] - 1.0);
        hard.holds({"CPU time with over without, median of the steps, less 1", 0.02, "a fiftieth of a run is a price for never computing with nonsense"}, ratios[ratios.size() / 2] - 1.0, file);
        if (with.coupled) with.coupled->law->bye(), without.coupled->law->bye();
    }
}
