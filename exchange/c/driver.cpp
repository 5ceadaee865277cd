// talik_driver_...: a driver of one's own, in front of a farm of Talik (or of anybody).
#include <chrono>
#include <memory>
#include <new>
#include <unistd.h>

#include <fmt/format.h>

#include "common/base/version.hpp"
#include "common/io/byte_stream.hpp"
#include "common/packing/farm_setup.hpp"
#include "common/packing/packing_csv.hpp"
#include "common/packing/packing_file.hpp"
#include "common/scene/rve_tables.hpp"
#include "exchange/c/guard.hpp"
#include "exchange/driver_end.hpp"
#include "exchange/farm_end.hpp"
#include "exchange/run_board.hpp"
#include "exchange/transport.hpp"

using namespace talik;
using namespace talik::exchange;

struct talik_driver {
    std::unique_ptr<Channel> channel;
    std::unique_ptr<DriverEnd> farm;
    Hello hello;
    Batch request, answer;
    std::size_t rves = 0;
};

namespace {

struct Specification {
    RveSpec rve;
};

RveSpec read_specification(const std::string& file) {
    const scene::Value document = scene::read_document(file);
    scene::Table<Specification> table("The RVEs of a driver of one's own.");
    table.table<RveSpec>("rve", &Specification::rve, scene::rve_table()).check([](const Specification& spec, const scene::Place& at) {
        if (!at.has("rve")) return at.fault("rve", "is missing", "add the tables [rve.packing] and [rve.contact]");
        if (spec.rve.packing.by_specification())
            at.fault("rve.packing.file", "is missing", "prepare a packing (rve-farm pack THIS.toml -o packing.h5), then name it there instead of void_ratio");
    });
    Specification spec;
    scene::Faults faults;
    table.read(document, "", spec, faults);
    if (const scene::Value* rve = document.find("rve")) scene::resolve_packing_files(spec.rve.packing, file, scene::Place{*rve, "rve", faults});
    scene::throw_if_any(faults, "mend this one first");
    return spec.rve;
}

// The calls below: a handle that is there, and nothing thrown.
template <class Body>
int with(talik_driver* driver, Body&& body) {
    return c::guarded([&] {
        require(driver != nullptr && driver->farm != nullptr, "no driver is open", "call talik_driver_open() first");
        with_cause(*driver->channel, body);
    });
}

} // namespace

extern "C" {

int talik_driver_open(talik_driver** out, const char* exchange, const talik_driver_options* options) {
    return c::guarded([&] {
        require(out != nullptr, "there is no place for the handle", "give the address of a talik_driver*");
        *out = nullptr;
        c::require_known(options, "talik_driver_options");
        auto driver = std::make_unique<talik_driver>();
        driver->hello.program = options->program ? options->program : "a driver";
        driver->hello.request_columns = c::columns_of(options->request, options->request_columns);
        driver->hello.answer_columns = c::columns_of(options->answer, options->answer_columns);
        const auto now = static_cast<std::uint64_t>(std::chrono::system_clock::now().time_since_epoch().count());
        driver->hello.run_id = (now << 16) ^ static_cast<std::uint64_t>(::getpid());
        WaitLimits limits;
        if (options->attach_seconds > 0.0) limits.attach_seconds = options->attach_seconds;
        if (options->stall_seconds > 0.0) limits.stall_seconds = options->stall_seconds;
        driver->channel = make_exchange(c::address(exchange), limits);
        run_board().run_id = driver->hello.run_id;
        driver->farm = std::make_unique<DriverEnd>(*driver->channel);
        with_cause(*driver->channel, [&] { driver->farm->connect(driver->hello); });
        *out = driver.release();
    });
}

int talik_driver_configure(talik_driver* driver, const char* specification, size_t rves, double* initial) {
    return with(driver, [&] {
        require(specification != nullptr && rves > 0 && rves <= 1000000000, "no specification or no RVEs", "give a TOML file and the number of RVEs");
        const RveSpec spec = read_specification(specification);
        FarmSetup setup;
        setup.parameters = spec.parameters;
        setup.packings = spec.packing.particles.empty() ? read_packings(spec.packing.file) : std::vector<Packing>{read_packing_csv(spec.packing.particles, spec.packing.contacts)};
        for (std::size_t i = 0; i < rves; ++i) setup.packing_of_rve.push_back(static_cast<int>(i % setup.packings.size()));
        const auto said = driver->farm->configure(encode(setup));
        ByteReader in(said, "the answer to configure");
        const auto values = in.array<double>();
        driver->request = driver->farm->make_request(static_cast<int>(rves));
        driver->answer = driver->farm->make_answer(static_cast<int>(rves));
        require(values.size() == rves * static_cast<std::size_t>(driver->answer.columns().components()), "the farm was set up with another number of RVEs", "use library and farm of one version");
        driver->rves = rves;
        if (initial) std::copy(values.begin(), values.end(), initial);
    });
}

int talik_driver_step(talik_driver* driver, uint64_t step, double time_increment, uint32_t substeps, size_t rows, const uint32_t* ids, const double* request, double* answer) {
    return with(driver, [&] {
        require(driver->rves > 0, "the RVEs are not configured", "call talik_driver_configure() first");
        require(rows <= driver->rves && ids && request && answer, "a step asks for more RVEs than there are, or without arrays", "give ids, request and answer of `rows` rows");
        require(step > 0 && time_increment > 0.0, "a step has no number or no time", "count steps from 1, and give a time increment above 0 s");
        BatchHeader header;
        header.count = static_cast<std::uint32_t>(rows);
        driver->request.start(header);
        std::copy(ids, ids + rows, driver->request.ids().begin());
        for (int c = 0; c < driver->request.columns().components(); ++c) {
            const double* from = request + static_cast<std::size_t>(c) * rows;
            std::copy(from, from + rows, driver->request.component(c).begin());
        }
        driver->farm->step({step, time_increment, substeps}, driver->request, driver->answer);
        for (int c = 0; c < driver->answer.columns().components(); ++c) {
            const auto values = driver->answer.component(c);
            std::copy(values.begin(), values.end(), answer + static_cast<std::size_t>(c) * rows);
        }
        run_board().step = step;
    });
}

int talik_driver_command(talik_driver* driver, const char* name) {
    return with(driver, [&] { driver->farm->command(name ? name : ""); });
}

int talik_driver_checkpoint(talik_driver* driver, const char* path) {
    return with(driver, [&] { driver->farm->checkpoint(path ? path : ""); });
}

int talik_driver_restore(talik_driver* driver, const char* path) {
    return with(driver, [&] { driver->farm->restore(path ? path : ""); });
}

int talik_driver_times(talik_driver* driver, double own_waiting[1], double farm[3]) {
    return with(driver, [&] {
        const auto said = driver->farm->command("times");
        ByteReader in(said, "the answer to \"times\"");
        const auto times = in.get<LockstepTimes>();
        if (own_waiting) own_waiting[0] = driver->channel->waiting_seconds();
        if (farm) farm[0] = times.computing, farm[1] = times.copying, farm[2] = times.waiting;
    });
}

int talik_driver_bye(talik_driver* driver) {
    return with(driver, [&] { driver->farm->bye(); });
}

void talik_driver_close(talik_driver* driver) { delete driver; }

} // extern "C"
