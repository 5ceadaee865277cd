#include "mpm-driver/output/checkpoint.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "common/base/version.hpp"
#include "common/io/hdf5_file.hpp"
#include "common/io/text_file.hpp"
#include "exchange/sealed_file.hpp"
#include "mpm-driver/points/soundness.hpp"

namespace talik::driver {
namespace {

namespace fs = std::filesystem;
constexpr const char* format = "talik-driver-checkpoint 3";
const std::string prefix = "checkpoint-", half = ".part";

std::vector<fs::path> whole_checkpoints(const fs::path& folder) {
    std::vector<fs::path> found;
    for (const auto& entry : fs::directory_iterator(folder)) {
        if (entry.is_directory() && is_checkpoint_name(entry.path().filename().string())) found.push_back(entry.path());
    }
    std::sort(found.begin(), found.end()); // steps are padded with zeros: the order of names is the order of steps
    return found;
}

// The columns of which every entry is a number; of walls and clocks some are not known at the start.
std::vector<StateColumn> numbers_of(Simulation& simulation) {
    std::vector<StateColumn> columns = simulation.state();
    std::erase_if(columns, [](const StateColumn& c) { return c.name.starts_with("walls/") || c.name == "heat/clock"; });
    return columns;
}

// A rename is on disk only once the folder that holds the name is.
void sync_folder(const fs::path& path) {
    const int folder = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder < 0) return;
    ::fsync(folder);
    ::close(folder);
}

void write_driver_state(Simulation& simulation, const fs::path& path) {
    Hdf5File file = Hdf5File::create(path.string(), "mpm-driver", format);
    file.set_attribute("/", "scene_hash", simulation.scene().hash);
    file.set_attribute("/", "build", build_facts("mpm-driver"));
    file.set_attribute("/", "step", simulation.steps_done());
    file.set_attribute("/", "time", simulation.time());
    for (const StateColumn& column : simulation.state()) {
        file.write("/" + column.name, std::span<const double>(column.data, column.size()), column.components.size());
        file.set_attribute("/" + column.name, "unit", column.unit);
    }
    file.close();
    exchange::seal(path);
}

void write_part(Simulation& simulation, const fs::path& part) {
    fs::remove_all(part);
    make_folder(part);
    for (const auto& [name, law] : simulation.laws()) {
        make_folder(part / name);
        law->checkpoint((part / name).string());
    }
    write_driver_state(simulation, part / "driver.h5");
}

// Where a checkpoint of the same step is there already (a run that went on from before it), the two change names in one
// go: at no moment is there none.
void put_in_place(const fs::path& part, const fs::path& target) {
    const unsigned int flags = fs::exists(target) ? RENAME_EXCHANGE : 0;
    if (::renameat2(AT_FDCWD, part.c_str(), AT_FDCWD, target.c_str(), flags) != 0) {
        if (flags == 0) fail_to_write(target, errno);
        fs::remove_all(target); // a file system without exchange
        if (::rename(part.c_str(), target.c_str()) != 0) fail_to_write(target, errno);
    }
    fs::remove_all(part);
}

} // namespace

bool is_checkpoint_name(const std::string& name) {
    return name.starts_with(prefix) && name.size() > prefix.size() && name.find_first_not_of("0123456789", prefix.size()) == std::string::npos;
}

Checkpoints::Checkpoints(fs::path output_folder, int keep) : folder_(std::move(output_folder)), keep_(keep) {
    std::vector<fs::path> halves; // of a run that was killed while it wrote
    for (const auto& entry : fs::directory_iterator(folder_)) {
        const std::string name = entry.path().filename().string();
        if (entry.is_directory() && name.ends_with(half) && is_checkpoint_name(name.substr(0, name.size() - half.size()))) halves.push_back(entry.path());
    }
    for (const fs::path& path : halves) fs::remove_all(path);
}

fs::path Checkpoints::write(Simulation& simulation) {
    if (const auto fault = first_not_finite(numbers_of(simulation))) // the one before stays: a good one
        fail(ExitCode::failed, fmt::format("no checkpoint of step {}: row {} of {}: its {}", simulation.steps_done(), fault->row, fault->column, fault->words()), "restart from the last checkpoint");
    const fs::path target = folder_ / fmt::format("{}{:09}", prefix, simulation.steps_done());
    const fs::path part = target.string() + half;
    try {
        write_part(simulation, part);
    } catch (...) { // a half takes the room that may be lacking, and is of no use; the checkpoint before it stays
        std::error_code ignored;
        fs::remove_all(part, ignored);
        throw;
    }
    put_in_place(part, target);
    sync_folder(folder_);
    newest_ = target;
    remove_older();
    return target;
}

void Checkpoints::remove_older() const {
    const auto found = whole_checkpoints(folder_);
    const auto mine = std::find(found.begin(), found.end(), newest_) - found.begin();
    for (std::ptrdiff_t i = 0; i + keep_ <= mine; ++i) fs::remove_all(found[static_cast<std::size_t>(i)]);
}

void restore_checkpoint(Simulation& simulation, const fs::path& checkpoint) {
    const fs::path path = checkpoint / "driver.h5";
    if (!fs::exists(path))
        throw Error(ExitCode::bad_input, checkpoint.string(), "is not a checkpoint (it holds no driver.h5)",
                    "give one of the folders checkpoint-* of an output folder to --restart");
    exchange::require_sealed(path);
    const Hdf5File file = Hdf5File::open(path.string());
    file.require_format(format);
    if (file.text_attribute("/", "scene_hash") != simulation.scene().hash)
        throw Error(ExitCode::bad_input, checkpoint.string(), "belongs to another scene, or to this one before it was changed",
                    "restart with the very scene (and --set options) that wrote it");
    if (file.text_attribute("/", "build") != build_facts("mpm-driver"))
        log::warn("{} was written by another build: the restart need not be the same to the bit", checkpoint.string());
    for (const auto& [name, law] : simulation.laws()) law->restore((checkpoint / name).string());
    for (const StateColumn& column : simulation.state()) {
        const auto array = file.read<double>("/" + column.name);
        if (array.values.size() != column.size())
            throw Error(ExitCode::bad_input, path.string(), "its column " + column.name + " has another length than the scene calls for",
                        "restart with the very scene that wrote it");
        std::copy(array.values.begin(), array.values.end(), column.data);
    }
    if (const auto fault = first_not_finite(numbers_of(simulation)))
        throw Error(ExitCode::bad_input, path.string(), fmt::format("row {} of {}: its {}", fault->row, fault->column, fault->words()), "restart from another checkpoint");
    simulation.restored();
}

} // namespace talik::driver
