#pragma once
// What the tests of two processes share: folders of their own, programs that are started, watched and signalled, a tiny
// scene, and eyes for what a run leaves behind.
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <sys/types.h>
#include <vector>

namespace talik::lockstep {

namespace fs = std::filesystem;

// A fresh folder below the build folder, gone with this object.
class TemporaryFolder {
public:
    TemporaryFolder();
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    const fs::path& path() const { return path_; }
    fs::path operator/(const std::string& name) const { return path_ / name; }

private:
    fs::path path_;
};

fs::path binary(const std::string& name); // BUILD/bin/NAME

// How a process ended.
struct End {
    int code = -1;   // of exit; -1 where a signal ended it
    int signal = 0;
    double seconds = 0.0; // from the latest start() or signal of the program until it was seen to have ended
};

// A program with its descendants in a process group of their own. stdout and stderr go to one file. Orphans of the group
// become children of this process, so that their ends are seen, too. Whatever still runs is killed with this object.
class Program {
public:
    // arguments[0]: name of an executable of Talik. cache: its TALIK_CACHE.
    Program(std::vector<std::string> arguments, const fs::path& cache);
    ~Program();
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;

    pid_t pid() const { return pid_; }
    bool running();
    void send(int signal);                        // to the program
    End wait(double seconds);                     // fails the test where it still runs then
    std::vector<End> orphans(double seconds);     // of the group, once the program has ended: all of them, ended; else fails
    std::optional<pid_t> child();                 // the process it launched, while both live
    std::string text() const;                     // what program and descendants have said
    std::vector<std::string> errors() const;      // their lines "error: ..."

private:
    void reap(int status);
    pid_t pid_ = -1;
    fs::path log_;
    std::optional<End> end_;
    double since_ = 0.0;
};

// Runs to the end, within 60 s.
struct Finished {
    End end;
    std::string text;
    std::vector<std::string> errors;
};
Finished run_to_end(std::vector<std::string> arguments, const fs::path& cache);

// A few steps on from a checkpoint of the tiny or endless scene, into `output`.
Finished restart(const fs::path& scene, const fs::path& checkpoint, const fs::path& output, const fs::path& cache);

// 16 RVEs of 30 discs under a moving plate, 60 steps of 0.67 ms: about a quarter of a second. `replace`: lines of it that
// read otherwise, by their beginning ("duration" -> "duration = \"1 s\""); an empty replacement takes the line out.
std::string tiny_scene(const std::map<std::string, std::string>& replace = {});
fs::path write_tiny_scene(const TemporaryFolder& folder, const std::map<std::string, std::string>& replace = {});
// What makes its ground frozen, and thaw from a warm side: bonds fail with the ice, and heat has a state of its own.
std::map<std::string, std::string> thawing();
// The same without end, with a checkpoint about every ten steps.
fs::path write_endless_scene(const TemporaryFolder& folder, const std::string& fields_interval = "50 ms", bool thaws = false);

std::string content(const fs::path& file);
bool appears(const fs::path& path, double seconds); // within that time
std::vector<fs::path> checkpoints(const fs::path& output); // whole ones, oldest first
std::vector<fs::path> halves(const fs::path& folder);      // everything named *.part, at any depth

// Names of segments in /dev/shm whose maker is this process, alive or dead.
std::vector<std::string> segments_made_by(pid_t pid);
std::string unique_exchange_name();

// The arrays and numbers in which two HDF5 files differ, by path; empty = the same bits.
std::vector<std::string> differences(const fs::path& a, const fs::path& b);

double now(); // s, monotonic
void pause(double seconds);

} // namespace talik::lockstep
