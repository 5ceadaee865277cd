// exchange-soak STEPS RVES CHUNK: a driver and a farm that computes nothing, two processes over shared memory, for a very long
// time. Resident memory and the distribution of latencies are printed for each tenth of the run: both must stay as they are.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

#include "common/base/program.hpp"
#include "common/physics/rve_columns.hpp"
#include "exchange/driver_end.hpp"
#include "exchange/farm_end.hpp"
#include "exchange/shm_channel.hpp"

using namespace talik;
using namespace talik::exchange;

namespace {

class NullFarm : public FarmService {
public:
    std::vector<Column> understands() const override { return rve_columns::requests(); }
    std::vector<Column> offers() const override { return rve_columns::answers(); }
    void agreed(const Hello&) override {}
    std::vector<std::byte> configure(std::span<const std::byte>, Channel&) override { return {}; }
    void answer(const Batch&, Batch& answer, Channel&) override {
        for (int c = 0; c < answer.columns().components(); ++c) std::fill(answer.component(c).begin(), answer.component(c).end(), 0.0);
    }
    std::vector<std::byte> command(const std::string&, std::span<const std::byte>) override { return {}; }
    void checkpoint(const std::string&) override {}
    void restore(const std::string&) override {}
};

long resident_kib(pid_t pid) {
    std::ifstream in("/proc/" + std::to_string(pid) + "/statm");
    long total = 0, resident = 0;
    in >> total >> resident;
    return resident * (sysconf(_SC_PAGESIZE) / 1024);
}

// Latencies of one tenth, in classes a tenth of an octave wide: no memory grows with the run.
class Histogram {
public:
    void add(double microseconds) {
        int bin = 0;
        for (double top = 0.1; bin + 1 < size && microseconds > top; ++bin) top *= 1.0717734625362931; // 2^(1/10)
        ++bins_[static_cast<std::size_t>(bin)], ++count_, most_ = std::max(most_, microseconds);
    }
    double quantile(double part) const {
        double top = 0.1;
        std::uint64_t sum = 0;
        for (int bin = 0; bin < size; ++bin, top *= 1.0717734625362931)
            if ((sum += bins_[static_cast<std::size_t>(bin)]) >= part * static_cast<double>(count_)) return top;
        return top;
    }
    double most() const { return most_; }

private:
    static constexpr int size = 300;
    std::array<std::uint64_t, size> bins_{};
    std::uint64_t count_ = 0;
    double most_ = 0.0;
};

int soak(long steps, int rves, int chunk) {
    const std::string name = "soak-" + std::to_string(getpid());
    std::fflush(nullptr);
    const pid_t child = fork();
    if (child == 0) _exit(run_program([&] {
        NullFarm farm;
        const auto channel = join_shm_channel(name, {});
        FarmEnd(*channel, farm, "null farm").serve();
        return 0;
    }));
    const auto channel = make_shm_channel(name, {});
    DriverEnd driver(*channel, chunk);
    Hello hello;
    hello.program = "soak";
    hello.run_id = 1;
    hello.request_columns = {rve_columns::displacement_gradient_increment};
    hello.answer_columns = {rve_columns::stress, rve_columns::status};
    driver.connect(hello);
    driver.configure({});
    Batch request = driver.make_request(rves), answer = driver.make_answer(rves);
    BatchHeader header;
    header.count = static_cast<std::uint32_t>(rves);
    request.start(header);
    for (int i = 0; i < rves; ++i) request.ids()[static_cast<std::size_t>(i)] = static_cast<std::uint32_t>(i);
    for (int c = 0; c < 4; ++c) std::fill(request.component(c).begin(), request.component(c).end(), 1e-6);

    std::printf("%12s %9s %9s %9s %9s %12s %12s\n", "steps", "p50 us", "p99 us", "p99.9 us", "max us", "driver KiB", "farm KiB");
    long first_driver = 0, first_farm = 0, last_driver = 0, last_farm = 0;
    std::vector<double> medians;
    std::uint64_t step = 0;
    for (int tenth = 1; tenth <= 10; ++tenth) {
        Histogram latencies;
        for (const auto end = static_cast<std::uint64_t>(steps * tenth / 10); step < end;) {
            const auto begin = std::chrono::steady_clock::now();
            driver.step({++step, 1e-3, 0}, request, answer);
            latencies.add(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count());
        }
        last_driver = resident_kib(getpid()), last_farm = resident_kib(child);
        if (tenth == 1) first_driver = last_driver, first_farm = last_farm;
        medians.push_back(latencies.quantile(0.5));
        std::printf("%12llu %9.1f %9.1f %9.1f %9.0f %12ld %12ld\n", static_cast<unsigned long long>(step), latencies.quantile(0.5), latencies.quantile(0.99), latencies.quantile(0.999), latencies.most(), last_driver, last_farm);
        std::fflush(stdout);
    }
    driver.bye();
    int status = 0;
    waitpid(child, &status, 0);
    const bool flat = last_driver <= first_driver + 64 && last_farm <= first_farm + 64; // a few pages that were not touched before
    std::printf("memory %s: driver %+ld KiB, farm %+ld KiB between the first tenth and the last\n", flat ? "flat" : "GREW", last_driver - first_driver, last_farm - first_farm);
    std::printf("median of the last tenth over that of the first: %.2f\n", medians.back() / medians.front());
    return flat && WIFEXITED(status) && WEXITSTATUS(status) == 0 ? 0 : 1;
}

} // namespace

int main(int argc, char** argv) {
    return run_program([&] {
        const auto number = [&](int i, long otherwise) { return argc > i ? std::atol(argv[i]) : otherwise; };
        return soak(std::max(10L, number(1, 1000000)), static_cast<int>(std::max(1L, number(2, 1024))), static_cast<int>(std::max(1L, number(3, 512))));
    });
}
