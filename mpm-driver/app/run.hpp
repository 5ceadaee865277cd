#pragma once
// mpm-driver run: a scene from start to end, or on from a checkpoint.
#include <optional>
#include <string>
#include <vector>

namespace talik::driver {

struct RunOptions {
    std::string scene;
    std::string output;               // empty = out/<scene's name>
    std::string exchange;             // empty = launch a farm
    std::string restart;              // a checkpoint's folder
    std::string record;               // file for every request and answer; empty = none
    std::string replay;               // recording that answers instead of a farm; empty = none
    bool loose = false;               // replay: nearest recorded answers
    std::optional<double> tolerance;  // replay: of a request
    std::string backend = "auto";
    std::optional<double> until;      // s
    std::vector<std::string> set;     // key=value
    int threads = 0;                  // of farm and driver; 0 = all
    int farms = 0;                    // that share the RVEs; 0 = one, or as many as an MPI job has
    double stall_seconds = 120.0;     // for a farm that does not move
    double attach_seconds = 60.0;     // for a farm to come to the exchange
    bool quiet = false;
};

int run(const RunOptions& options);

} // namespace talik::driver
