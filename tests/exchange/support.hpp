#pragma once
// What the exchange tests share: pairs of channels of either kind, a farm with a memory, and partners to be killed.
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <functional>
#include <memory>
#include <string>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/base/error.hpp"
#include "common/physics/rve_columns.hpp"
#include "exchange/answer_memory.hpp"
#include "exchange/driver_end.hpp"
#include "exchange/farm_end.hpp"
#include "exchange/file_channel.hpp"
#include "exchange/loopback_channel.hpp"
#include "exchange/mpi_channel.hpp"
#include "exchange/shm_channel.hpp"

namespace talik::exchange::test {

using Clock = std::chrono::steady_clock;
inline double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

// No two tests, and no two runs of the tests side by side, share a name.
inline std::string unique_name(const std::string& what) {
    static int count = 0;
    return fmt::format("test-{}-{}-{}", what, getpid(), count++);
}
inline bool in_dev_shm(const std::string& name) { return std::filesystem::exists("/dev/shm/talik-" + name); }

// Every transport has to pass the same suite (tests/exchange/conformance).
inline std::vector<std::string> transports() {
    std::vector<std::string> kinds = {"loopback", "shm", "file"};
    if (built_with_mpi()) kinds.push_back("mpi");
    return kinds;
}
// Those between two processes that a test can start and kill; an MPI job ends as a whole (tests/lockstep/mpi_test.cpp).
inline std::vector<std::string> transports_between_processes() { return {"shm", "file"}; }

inline std::string exchange_folder(const std::string& name) { return (std::filesystem::temp_directory_path() / ("talik-" + name)).string(); }

// capacity: bytes under way each way before a writer waits.
inline std::unique_ptr<Channel> driver_channel(const std::string& kind, const std::string& name, std::size_t capacity, const WaitLimits& limits = {}) {
    if (kind == "file") return make_file_channel(exchange_folder(name), limits, {capacity});
    ShmOptions options;
    options.ring_bytes = capacity;
    return make_shm_channel(name, limits, options);
}
inline std::unique_ptr<Channel> farm_channel(const std::string& kind, const std::string& name, std::size_t capacity, const WaitLimits& limits = {}) {
    if (kind == "file") return join_file_channel(exchange_folder(name), limits, {capacity});
    return join_shm_channel(name, limits);
}
// Removes the folder of an exchange with this object.
struct FolderOf {
    std::string path;
    explicit FolderOf(const std::string& name) : path(exchange_folder(name)) {}
    ~FolderOf() { std::error_code ignored; std::filesystem::remove_all(path, ignored); }
};

struct Pair {
    std::unique_ptr<FolderOf> folder; // outlives the ends
    std::unique_ptr<Channel> driver, farm;
};

// Both ends in this process.
inline Pair connected_pair(const std::string& kind, std::size_t ring_bytes, const WaitLimits& limits = {}) {
    Pair pair;
    if (kind == "loopback") {
        std::tie(pair.driver, pair.farm) = loopback_pair(ring_bytes, limits);
    } else if (kind == "mpi") {
        std::tie(pair.driver, pair.farm) = mpi_pair(ring_bytes, limits);
    } else {
        const std::string name = unique_name("pair");
        pair.folder = std::make_unique<FolderOf>(name);
#ifdef __SANITIZE_THREAD__ // two mappings of one memory would hide every race from it
        if (kind == "shm") {
            ShmOptions options;
            options.ring_bytes = ring_bytes;
            std::tie(pair.driver, pair.farm) = shm_channels_of_one_mapping(name, limits, options);
            return pair;
        }
#endif
        pair.driver = driver_channel(kind, name, ring_bytes, limits);
        pair.farm = farm_channel(kind, name, ring_bytes, limits);
    }
    return pair;
}

inline bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

inline std::string error_text(const std::function<void()>& body, ExitCode* code = nullptr) {
    try {
        body();
    } catch (const Error& error) {
        if (code) *code = error.code();
        return error.what();
    }
    return "no error";
}

inline Hello driver_hello() {
    Hello hello;
    hello.program = "test-driver";
    hello.run_id = 0x5eed;
    hello.epoch = 3;
    hello.scene_hash = "abc";
    hello.request_columns = {rve_columns::displacement_gradient_increment};
    hello.answer_columns = {rve_columns::stress, rve_columns::status, rve_columns::work};
    return hello;
}

// A farm whose answer depends on all that came before: stress = sum over the steps of the increments times (1 + id), so
// that a step computed twice, or never, shows.
class SummingFarm : public FarmService {
public:
    std::vector<Column> understands() const override { return rve_columns::requests(); }
    std::vector<Column> offers() const override { return rve_columns::answers(); }
    void agreed(const Hello& driver) override { columns_ = ColumnTable(driver.answer_columns); }
    std::vector<std::byte> configure(std::span<const std::byte> payload, Channel&) override {
        on("configure");
        ByteReader in(payload, "configure");
        const auto count = in.get<std::int32_t>();
        configured_bytes = payload.size();
        start(count);
        ByteWriter out;
        out.put(count);
        return out.take();
    }
    void answer(const Batch& request, Batch& answer, Channel& progress) override {
        on("answer");
        memory_.recall(request, answer, rows_);
        for (int row : rows_) {
            const auto r = static_cast<std::size_t>(row);
            double* sum = &sums_[std::size_t(request.ids()[r]) * 4];
            for (int c = 0; c < 4; ++c) sum[c] += request.component(c)[r] * weight(request.ids()[r]);
            const double values[5] = {sum[0], sum[3], sum[1] + sum[2], 0.0, sum[0] * sum[0]};
            for (int c = 0; c < 5; ++c) answer.component(c)[r] = values[c];
            ++computed;
        }
        memory_.remember(request, answer, rows_);
        progress.advance_progress(static_cast<std::uint64_t>(computed), 0);
    }
    std::vector<std::byte> command(const std::string& name, std::span<const std::byte> payload) override {
        on("command");
        require(name == "echo", "no command '" + name + "'", "ask for 'echo'");
        return {payload.begin(), payload.end()};
    }
    void checkpoint(const std::string& path) override { on("checkpoint"), checkpointed = path; }
    void restore(const std::string& path) override { on("restore"), restored = path; }

    std::function<void(const std::string&)> on = [](const std::string&) {}; // called with the name of what is asked
    long computed = 0;
    std::size_t configured_bytes = 0;
    std::string checkpointed, restored;

protected:
    void start(int count) {
        memory_ = AnswerMemory(count, columns_);
        sums_.assign(static_cast<std::size_t>(count) * 4, 0.0);
    }
    virtual double weight(std::uint32_t id) const { return 1.0 + id; }

    ColumnTable columns_;
    AnswerMemory memory_;
    std::vector<double> sums_; // four of each RVE

private:
    std::vector<int> rows_;
};

inline std::vector<std::byte> setup_for(std::int32_t rve_count, std::size_t padding = 0) {
    ByteWriter out;
    out.put(rve_count);
    out.array(std::vector<std::byte>(padding, std::byte{7}));
    return out.take();
}

inline void fill(Batch& request, int count, double seed) {
    BatchHeader header;
    header.count = static_cast<std::uint32_t>(count);
    request.start(header);
    for (int i = 0; i < count; ++i) {
        const auto row = static_cast<std::size_t>(i);
        request.ids()[row] = static_cast<std::uint32_t>(count - 1 - i); // any order will do
        for (int c = 0; c < 4; ++c) request.component(c)[row] = seed * (c + 1) / (i + 3.0);
    }
}

// A process that runs `body` and ends; killed and reaped at the latest when this object goes.
class Child {
public:
    explicit Child(const std::function<void()>& body) {
        std::fflush(nullptr); // else what is buffered would be printed by both
        pid_ = fork();
        if (pid_ != 0) return;
        int code = 0;
        try {
            body();
        } catch (const Error& error) {
            code = static_cast<int>(error.code());
        } catch (...) {
            code = 99;
        }
        _exit(code);
    }
    ~Child() {
        if (reaped_) return;
        kill(pid_, SIGKILL);
        waitpid(pid_, nullptr, 0);
    }
    int pid() const { return pid_; }
    int exit_code() { // -1: ended by a signal
        int status = 0;
        waitpid(pid_, &status, 0);
        reaped_ = true;
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }

private:
    pid_t pid_ = -1;
    bool reaped_ = false;
};

// A time both processes can see: when the partner came to its end.
class SharedInstant {
public:
    SharedInstant()
        : time_(new (mmap(nullptr, sizeof(Time), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0)) Time(0)) {}
    ~SharedInstant() { munmap(time_, sizeof(Time)); }
    void set() { *time_ = Clock::now().time_since_epoch().count(); } // CLOCK_MONOTONIC is one for all processes
    bool is_set() const { return *time_ != 0; }
    double seconds_ago() const {
        return std::chrono::duration<double>(Clock::now().time_since_epoch() - Clock::duration(time_->load())).count();
    }

private:
    using Time = std::atomic<Clock::rep>;
    Time* time_;
};

} // namespace talik::exchange::test
