#include "tests/lockstep/support.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>
#include <thread>

#include "common/base/error.hpp"
#include "common/io/hdf5_file.hpp"
#include "exchange/stale_segment.hpp"
#include "tests/support/catch.hpp"

namespace talik::lockstep {
namespace {

std::string unique_number() {
    static int count = 0;
    return fmt::format("{}-{}", getpid(), count++);
}

End end_of(int status, double since) {
    const bool exited = WIFEXITED(status);
    return {exited ? WEXITSTATUS(status) : -1, exited ? 0 : WTERMSIG(status), now() - since};
}

// In the child, between fork and exec.
[[noreturn]] void become(const std::vector<char*>& arguments, const char* log, const char* cache) {
    setpgid(0, 0);
    prctl(PR_SET_PDEATHSIG, SIGKILL); // a test that crashes leaves nothing behind
    const int file = open(log, O_WRONLY | O_CREAT | O_TRUNC | O_APPEND, 0600);
    dup2(file, STDOUT_FILENO);
    dup2(file, STDERR_FILENO);
    setenv("TALIK_CACHE", cache, 1);
    setenv("OMP_NUM_THREADS", "1", 0);
    execv(arguments[0], arguments.data());
    _exit(127);
}

} // namespace

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }
void pause(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

TemporaryFolder::TemporaryFolder() : path_(fs::path(TALIK_BINARY_DIR) / "lockstep-tests" / unique_number()) {
    fs::remove_all(path_);
    fs::create_directories(path_);
}
TemporaryFolder::~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
}

fs::path binary(const std::string& name) { return fs::path(TALIK_BINARY_DIR) / "bin" / name; }

Program::Program(std::vector<std::string> arguments, const fs::path& cache) {
    prctl(PR_SET_CHILD_SUBREAPER, 1);
    fs::create_directories(cache);
    log_ = cache / (arguments[0] + "-" + unique_number() + ".log");
    arguments[0] = binary(arguments[0]).string();
    std::vector<char*> pointers;
    for (std::string& argument : arguments) pointers.push_back(argument.data());
    pointers.push_back(nullptr);
    const std::string log = log_.string(), folder = cache.string();
    since_ = now();
    pid_ = fork();
    if (pid_ == 0) become(pointers, log.c_str(), folder.c_str());
    setpgid(pid_, pid_); // by whichever of the two comes first
}

Program::~Program() {
    kill(-pid_, SIGKILL);
    if (!end_) waitpid(pid_, nullptr, 0);
    for (int i = 0; i < 500; ++i) {
        const pid_t got = waitpid(-pid_, nullptr, WNOHANG);
        if (got < 0) break;
        if (got == 0) pause(0.002);
    }
}

bool Program::running() {
    if (end_) return false;
    int status = 0;
    if (waitpid(pid_, &status, WNOHANG) != pid_) return true;
    end_ = end_of(status, since_);
    return false;
}

void Program::send(int signal) {
    since_ = now();
    kill(pid_, signal);
}

End Program::wait(double seconds) {
    const double until = now() + seconds;
    while (running()) {
        if (now() > until) {
            INFO(text());
            FAIL("process " << pid_ << " still runs after " << seconds << " s");
        }
        pause(0.001);
    }
    return *end_;
}

std::vector<End> Program::orphans(double seconds) {
    std::vector<End> ends;
    for (const double begin = now();;) {
        int status = 0;
        const pid_t got = waitpid(-pid_, &status, WNOHANG);
        if (got < 0) return ends; // nobody of the group is left
        if (got > 0) ends.push_back(end_of(status, since_));
        if (got == 0 && now() - begin > seconds) {
            INFO(text());
            FAIL("the group of process " << pid_ << " still runs after " << seconds << " s");
        }
        if (got == 0) pause(0.001);
    }
}

std::optional<pid_t> Program::child() {
    std::ifstream in(fmt::format("/proc/{0}/task/{0}/children", pid_));
    pid_t pid = 0;
    if (in >> pid) return pid;
    return std::nullopt;
}

std::string Program::text() const { return content(log_); }

std::vector<std::string> Program::errors() const {
    std::vector<std::string> found;
    std::istringstream in(text());
    for (std::string line; std::getline(in, line);)
        if (line.starts_with("error: ")) found.push_back(line);
    return found;
}

Finished run_to_end(std::vector<std::string> arguments, const fs::path& cache) {
    Program program(std::move(arguments), cache);
    const End end = program.wait(60);
    program.orphans(10);
    return {end, program.text(), program.errors()};
}

Finished restart(const fs::path& scene, const fs::path& checkpoint, const fs::path& output, const fs::path& cache) {
    const std::string name = checkpoint.filename().string();
    const double step = std::stod(name.substr(name.rfind('-') + 1)), step_length = 6.7e-4; // s
    return run_to_end({"mpm-driver", "run", scene.string(), "--output", output.string(), "--quiet", "--threads", "1", "--restart", checkpoint.string(),
                       "--until", fmt::format("{}", step_length * (step + 5))},
                      cache);
}

std::string tiny_scene(const std::map<std::string, std::string>& replace) {
    const std::string scene = R"(title = "tiny"
seed = 3
confining_pressure = "100 kPa"
[domain]
origin = ["-0.1 m", "0 m"]
size = ["0.4 m", "0.3 m"]
cell = "0.1 m"
[[body]]
name = "sample"
box = [["0 m", "0 m"], ["0.2 m", "0.2 m"]]
law = "rve"
[rve]
time_step = "2e-5 s"
[rve.packing]
discs = 30
void_ratio = 0.2
void_ratio_tolerance = 0.02
count = 2
[rve.contact]
friction = 0.5
[[wall]]
name = "base"
side = "bottom"
position = "0 m"
[[wall]]
name = "plate"
side = "top"
position = "0.2 m"
velocity = "-0.1 m/s"
ramp = "0.01 s"
[step]
safety = 0.5
[[stage]]
name = "compression"
duration = "0.04 s"
moves = ["plate"]
pic = 0.001
[output]
history_interval = "1 ms"
fields_interval = "10 ms"
checkpoint_interval = "20 ms"
)";
    std::string text;
    std::size_t replaced = 0;
    std::istringstream in(scene);
    for (std::string line; std::getline(in, line);) {
        const auto other = std::find_if(replace.begin(), replace.end(), [&](const auto& pair) { return line.starts_with(pair.first); });
        if (other != replace.end()) ++replaced;
        text += (other == replace.end() ? line : other->second) + "\n";
    }
    REQUIRE(replaced == replace.size()); // a test that means to change a line, does
    return text;
}

fs::path write_tiny_scene(const TemporaryFolder& folder, const std::map<std::string, std::string>& replace) {
    const fs::path path = folder / "scene.toml";
    std::ofstream(path) << tiny_scene(replace);
    return path;
}

std::map<std::string, std::string> thawing() {
    return {{"law", "law = \"rve\"\nmaterial = \"sand\"\ntemperature = \"-1 degC\""},
            {"friction", "friction = 0.5\n[rve.bond]\nnormal_strength = \"2 MPa\"\ntangential_strength = \"2 MPa\""},
            {"moves", "moves = [\"plate\"]\nactivates = [\"bonds\"]"},
            {"[step]", R"([heat]
time_scale = 86400
[[heat.material]]
name = "sand"
porosity = 0.4
grain_heat_capacity = 850
grain_conductivity = 3
residual_temperature = "-0.5 degC"
[[heat.boundary]]
name = "warm"
side = "left"
value = 10
[step])"}};
}

fs::path write_endless_scene(const TemporaryFolder& folder, const std::string& fields_interval, bool thaws) {
    std::map<std::string, std::string> replace = {{"duration", "duration = \"1000 s\""},
                                                  {"velocity", "velocity = \"-0.1 mm/s\""},
                                                  {"fields_interval", "fields_interval = \"" + fields_interval + "\""},
                                                  {"checkpoint_interval", "checkpoint_interval = \"7 ms\""}};
    if (thaws) replace.merge(thawing());
    return write_tiny_scene(folder, replace);
}

std::string content(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}

bool appears(const fs::path& path, double seconds) {
    for (const double until = now() + seconds; !fs::exists(path); pause(0.001))
        if (now() > until) return false;
    return true;
}

std::vector<fs::path> checkpoints(const fs::path& output) {
    std::vector<fs::path> found;
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(output, none)) {
        const std::string name = entry.path().filename().string();
        if (name.starts_with("checkpoint-") && !name.ends_with(".part")) found.push_back(entry.path());
    }
    std::sort(found.begin(), found.end());
    return found;
}

std::vector<fs::path> halves(const fs::path& folder) {
    std::vector<fs::path> found;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (entry.path().filename().string().find(".part") != std::string::npos) found.push_back(entry.path());
    return found;
}

std::vector<std::string> segments_made_by(pid_t pid) {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator("/dev/shm")) {
        const std::string name = entry.path().filename().string();
        if (name.starts_with("talik-") && exchange::examine_segment(name).creator.pid == pid) names.push_back(name);
    }
    return names;
}

std::string unique_exchange_name() { return "lockstep-" + unique_number(); }

namespace {

void compare(const Hdf5File& a, const Hdf5File& b, const std::string& path, std::vector<std::string>& found) {
    for (const char* number : {"step", "time", "evaluations"})
        if (a.has_attribute(path, number) && a.number_attribute(path, number) != b.number_attribute(path, number))
            found.push_back(path + ": " + number);
    Hdf5Array<double> here, there;
    try {
        here = a.read<double>(path);
    } catch (const Error&) { // not an array: a group
        if (a.children(path) != b.children(path)) return found.push_back(path + ": its members");
        for (const auto& name : a.children(path)) compare(a, b, path == "/" ? path + name : path + "/" + name, found);
        return;
    }
    there = b.read<double>(path);
    const bool same = here.columns == there.columns && here.values.size() == there.values.size() &&
                      std::memcmp(here.values.data(), there.values.data(), here.values.size() * sizeof(double)) == 0;
    if (!same) found.push_back(path);
}

} // namespace

std::vector<std::string> differences(const fs::path& a, const fs::path& b) {
    std::vector<std::string> found;
    compare(Hdf5File::open(a.string()), Hdf5File::open(b.string()), "/", found);
    return found;
}

} // namespace talik::lockstep
