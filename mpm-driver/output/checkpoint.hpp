#pragma once
// Checkpoints of driver and farms belong together: one folder holds the driver's state and the laws' own files of one
// step. It is written under a temporary name and renamed once whole, so that a half-written set is never used.
#include <filesystem>
#include <string>

#include "mpm-driver/mechanics/simulation.hpp"

namespace talik::driver {

// "checkpoint-000001200": folders of other names are the user's, and are not touched.
bool is_checkpoint_name(const std::string& name);

class Checkpoints {
public:
    // keep: how many of the newest stay.
    explicit Checkpoints(std::filesystem::path output_folder, int keep = 2);

    // "OUTPUT/checkpoint-000001200"
    std::filesystem::path write(Simulation& simulation);
    // The newest whole one of this run; empty where there is none yet.
    const std::filesystem::path& newest() const { return newest_; }

private:
    void remove_older() const;
    std::filesystem::path folder_, newest_;
    int keep_;
};

// Brings a simulation made from the same scene to the state of a checkpoint, bit by bit.
void restore_checkpoint(Simulation& simulation, const std::filesystem::path& checkpoint);

} // namespace talik::driver
