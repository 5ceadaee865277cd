#pragma once
// Driver and farm in one process: the driver's own classes on one side of a channel, the farm's service in a thread on
// the other.
#include <future>
#include <memory>
#include <string>
#include <vector>

#include <omp.h>

#include "common/base/error.hpp"
#include "exchange/loopback_channel.hpp"
#include "exchange/shm_channel.hpp"
#include "mpm-driver/app/laws.hpp"
#include "mpm-driver/app/packings.hpp"
#include "mpm-driver/app/scene_schema.hpp"
#include "mpm-driver/points/overburden.hpp"
#include "rve-farm/backend/service.hpp"
#include "tests/lockstep/support.hpp"

namespace talik::lockstep {

// Writes down the increments it is sent before it hands them to the farm.
class ListeningService : public farm::Service {
public:
    using farm::Service::Service;
    void answer(const exchange::Batch& request, exchange::Batch& answer, exchange::Channel& progress) override {
        for (std::size_t row = 0; row < request.ids().size(); ++row) {
            std::array<double, 4> increment{};
            for (int c = 0; c < 4; ++c) increment[static_cast<std::size_t>(c)] = request.component(c)[row];
            increments.push_back(increment);
        }
        farm::Service::answer(request, answer, progress);
    }
    std::vector<std::array<double, 4>> increments; // in the order asked
};

// The farm of a test, from the first hello to its bye.
class FarmInThread {
public:
    static farm::FarmOptions on_threads(int threads) {
        farm::FarmOptions options;
        options.threads = threads;
        return options;
    }
    // kind: "loopback" or "shm"
    FarmInThread(const std::string& kind, int threads) : service(on_threads(threads)) {
        if (kind == "loopback") {
            std::tie(driver_, farm_) = exchange::loopback_pair(std::size_t(1) << 20, {});
        } else {
            const std::string name = unique_exchange_name();
            driver_ = exchange::make_shm_channel(name, {});
            farm_ = exchange::join_shm_channel(name, {});
        }
        ended_ = std::async(std::launch::async, [this] {
            const auto own = std::move(farm_); // leaves with the thread, so that the driver never waits for nobody
            exchange::FarmEnd(*own, service, "rve-farm in a thread").serve();
        });
    }
    ~FarmInThread() { driver_.reset(); } // then the farm's wait ends, and with it the thread

    exchange::Channel& channel() { return *driver_; }
    void join() { ended_.get(); } // passes on what the farm threw

    ListeningService service;

private:
    std::unique_ptr<exchange::Channel> driver_, farm_;
    std::future<void> ended_;
};

// A scene with its packings, prepared once for all that is made from it.
struct Prepared {
    driver::Scene scene;
    FarmSetup setup;
};

inline Prepared prepare(const fs::path& scene_file, const fs::path& cache) {
    setenv("TALIK_CACHE", cache.c_str(), 1);
    Prepared made{driver::read_scene(scene_file.string()), {}};
    driver::complete_k0_range(made.scene);
    made.setup.parameters = made.scene.rve->parameters;
    made.setup.packings = driver::obtain_packings(*made.scene.rve, 1, true);
    if (!made.scene.bodies[0].density) made.scene.bodies[0].density = driver::bulk_density(made.setup.packings, made.setup.parameters.grain_density);
    return made;
}

inline std::unique_ptr<driver::FarmLaw> farm_law(const Prepared& prepared, exchange::Channel& channel) {
    exchange::Hello hello;
    hello.program = "test";
    hello.run_id = 1;
    hello.scene_hash = prepared.scene.hash;
    auto law = std::make_unique<driver::FarmLaw>(channel, hello, prepared.setup, prepared.scene.seed);
    law->start_at_depth(driver::Overburden(prepared.scene));
    return law;
}

// A simulation whose law "rve" speaks through the farm's channel.
struct Coupled {
    Coupled(const Prepared& prepared, FarmInThread& farm) {
        auto own = farm_law(prepared, farm.channel());
        law = own.get();
        driver::Simulation::Laws laws;
        laws["rve"] = std::move(own);
        simulation = std::make_unique<driver::Simulation>(prepared.scene, std::move(laws));
    }
    driver::FarmLaw* law;
    std::unique_ptr<driver::Simulation> simulation;
};

} // namespace talik::lockstep
