// exchange-speed: what the exchange itself costs. A farm that computes nothing, or that keeps cores busy for a set time, answers
// a driver step after step; one line of JSON tells the times. Used by tools/exchange-speed.
#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <omp.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <thread>

#include "common/base/error.hpp"
#include "common/base/program.hpp"
#include "common/io/byte_stream.hpp"
#include "common/physics/rve_columns.hpp"
#include "exchange/driver_end.hpp"
#include "exchange/farm_end.hpp"
#include "exchange/mpi_channel.hpp"
#include "exchange/transport.hpp"

using namespace talik;
using namespace talik::exchange;

namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

struct Options {
    std::string exchange = "shm:exchange-speed", role = "both";
    int rves = 20203, steps = 500, threads = 0;
    bool sleep_driver = false; // through the farm's work of every second step, instead of waiting for it
    double sleep_ms = 0.0, work_ms = 0.0; // of the farm, per step
};

// Keeps every thread of the farm busy with the same arithmetic.
double work(long rounds, int threads) {
    double sum = 0.0;
#pragma omp parallel num_threads(threads) reduction(+ : sum)
    {
        double x = 1.0 + omp_get_thread_num();
        for (long i = 0; i < rounds; ++i) x = x * 0.999999 + 1e-7;
        sum += x;
    }
    return sum;
}

class NullFarm : public FarmService {
public:
    explicit NullFarm(const Options& options) : options_(options), threads_(options.threads > 0 ? options.threads : omp_get_num_procs()) {}
    std::vector<Column> understands() const override { return rve_columns::requests(); }
    std::vector<Column> offers() const override { return rve_columns::answers(); }
    void agreed(const Hello&) override {}
    std::vector<std::byte> configure(std::span<const std::byte>, Channel&) override {
        if (options_.work_ms <= 0.0) return {};
        rounds_ = 1 << 16;
        for (double took = 0.0; took < 1e-3 * options_.work_ms; rounds_ = rounds_ * 3 / 2) {
            const auto begin = Clock::now();
            sink_ = work(rounds_, threads_);
            took = seconds_since(begin);
        }
        return {};
    }
    void answer(const Batch& request, Batch& answer, Channel&) override {
        for (int c = 0; c < answer.columns().components(); ++c) std::fill(answer.component(c).begin(), answer.component(c).end(), 0.0);
        if (request.header().chunk != 0) return;
        if (options_.sleep_ms > 0.0) std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(options_.sleep_ms));
        if (rounds_ == 0) return;
        const auto begin = Clock::now();
        sink_ = work(rounds_, threads_);
        waited_for_.push_back(seconds_since(begin));
    }
    // How long the work took in each step, s.
    std::vector<std::byte> command(const std::string&, std::span<const std::byte>) override {
        ByteWriter out;
        out.array(waited_for_);
        waited_for_.clear();
        return out.take();
    }
    void checkpoint(const std::string&) override {}
    void restore(const std::string&) override {}
private:
    Options options_;
    int threads_;
    long rounds_ = 0;
    volatile double sink_ = 0.0;
    std::vector<double> waited_for_;
};

double cpu_seconds() {
    rusage use{};
    getrusage(RUSAGE_SELF, &use);
    const auto seconds = [](const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); };
    return seconds(use.ru_utime) + seconds(use.ru_stime);
}

// Asks, and looks for the answer only after a sleep.
void step_asleep(DriverEnd& driver, const StepClock& clock, const Batch& request, Batch& answer, double seconds) {
    driver.begin_step(clock, request.count(), answer);
    for (int sent = 0; sent < request.count();) {
        Batch& chunk = driver.next_chunk();
        const auto count = static_cast<std::size_t>(chunk.count()), first = static_cast<std::size_t>(sent);
        std::copy_n(request.ids().begin() + sent, count, chunk.ids().begin());
        for (int c = 0; c < request.columns().components(); ++c) {
            const auto rows = request.component(c).subspan(first, count);
            std::copy(rows.begin(), rows.end(), chunk.component(c).begin());
        }
        driver.send_chunk();
        sent += chunk.count();
    }
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
    driver.finish_step();
}

double median(std::vector<double> values) {
    if (values.empty()) return 0.0;
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

void serve(const Options& options) {
    NullFarm farm(options);
    const auto channel = join_exchange(options.exchange, {});
    FarmEnd(*channel, farm, "null-farm").serve();
}

void drive(const Options& options) {
    const auto channels = make_exchange(options.exchange, 1, {});
    Channel& channel = *channels.front();
    pid_t child = -1;
    if (options.role == "both" && (child = fork()) == 0) {
        // The child's own end is the other one: the driver's stays with its parent.
        execl("/proc/self/exe", "exchange-speed", "--exchange", options.exchange.c_str(), "--role", "farm", "--threads", std::to_string(options.threads).c_str(), "--sleep-ms",
              std::to_string(options.sleep_ms).c_str(), "--work-ms", std::to_string(options.work_ms).c_str(), nullptr);
        _exit(127);
    }
    DriverEnd driver(channel);
    Hello hello;
    hello.program = "exchange-speed";
    hello.run_id = static_cast<std::uint64_t>(getpid());
    hello.request_columns = {rve_columns::displacement_gradient_increment};
    hello.answer_columns = {rve_columns::stress, rve_columns::status};
    driver.connect(hello);
    driver.configure({});
    Batch request = driver.make_request(options.rves), answer = driver.make_answer(options.rves);
    BatchHeader header;
    header.count = static_cast<std::uint32_t>(options.rves);
    request.start(header);
    for (int i = 0; i < options.rves; ++i) request.ids()[static_cast<std::size_t>(i)] = static_cast<std::uint32_t>(i);
    std::vector<double> microseconds;
    const double cpu = cpu_seconds(), waited = channel.waiting_seconds();
    const auto begin = Clock::now();
    for (int step = 1; step <= options.steps; ++step) {
        const auto start = Clock::now();
        if (options.sleep_driver && step % 2 == 0)
            step_asleep(driver, {static_cast<std::uint64_t>(step), 1e-3, 0}, request, answer, 1.5e-3 * options.work_ms);
        else
            driver.step({static_cast<std::uint64_t>(step), 1e-3, 0}, request, answer);
        microseconds.push_back(1e6 * seconds_since(start));
    }
    const double elapsed = seconds_since(begin), share = (cpu_seconds() - cpu) / elapsed;
    std::vector<double> busy;
    if (options.work_ms > 0.0) {
        const auto said = driver.command("work times");
        ByteReader in(said, "work times");
        busy = in.array<double>();
    }
    std::vector<double> waited_for, alone;
    for (std::size_t i = 0; i < busy.size(); ++i) (options.sleep_driver && i % 2 == 1 ? alone : waited_for).push_back(1e3 * busy[i]);
    const double waiting = channel.waiting_seconds() - waited;
    driver.bye();
    if (child > 0) waitpid(child, nullptr, 0);
    std::sort(microseconds.begin(), microseconds.end());
    fmt::print("{{\"exchange\": \"{}\", \"rves\": {}, \"steps\": {}, \"sleep_ms\": {}, \"work_ms\": {}, \"step_us\": {{\"min\": {:.1f}, \"median\": {:.1f}, \"p99\": {:.1f}}}, "
               "\"bytes_out\": {}, \"bytes_back\": {}, \"driver_cpu_share\": {:.4f}, \"waiting_share\": {:.4f}, \"farm_work_waited_ms\": {:.3f}, \"farm_work_alone_ms\": {:.3f}}}\n",
               options.exchange.substr(0, options.exchange.find(':')), options.rves, options.steps, options.sleep_ms, options.work_ms, microseconds.front(), microseconds[microseconds.size() / 2],
               microseconds[microseconds.size() * 99 / 100], request.rows().size(), answer.rows().size(), share, waiting / elapsed, median(waited_for), median(alone));
}

} // namespace

int main(int argc, char** argv) {
    CLI::App app("exchange-speed: what the exchange itself costs (see tools/exchange-speed)");
    Options options;
    app.add_option("--exchange", options.exchange, "shm:NAME, file:FOLDER or mpi");
    app.add_option("--role", options.role, "both, driver or farm")->check(CLI::IsMember({"both", "driver", "farm"}));
    app.add_option("--rves", options.rves, "per step")->check(CLI::Range(1, 100000000));
    app.add_option("--steps", options.steps, "to time")->check(CLI::Range(1, 100000000));
    app.add_option("--threads", options.threads, "that the farm keeps busy; 0 = all");
    app.add_option("--sleep-ms", options.sleep_ms, "that the farm sleeps in each step");
    app.add_flag("--sleep-driver", options.sleep_driver, "the driver sleeps through every second step's work");
    app.add_option("--work-ms", options.work_ms, "that the farm computes in each step, on all threads");
    const int code = run_program([&] {
        try {
            app.parse(argc, argv);
        } catch (const CLI::ParseError& error) {
            if (error.get_exit_code() == 0) return app.exit(error);
            fail(ExitCode::bad_input, error.what(), "see exchange-speed --help");
        }
        if (is_mpi(options.exchange)) begin_mpi(options.role == "farm" ? Role::farm : Role::driver);
        options.role == "farm" ? serve(options) : drive(options);
        return 0;
    });
    end_mpi(code == 0);
    return code;
}
