#include "mpm-driver/output/fields.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "common/io/hdf5_file.hpp"
#include "common/io/text_file.hpp"

namespace talik::driver {
namespace {

constexpr const char* format = "talik-fields 1";

std::string group_name(int index) { return fmt::format("/output_{:06}", index); }
std::string vtu_name(int index) { return fmt::format("fields/fields_{:06}.vtu", index); }

// Copies the attributes and arrays of one output; all is read before anything is written, so that a damaged one adds nothing.
void copy_output(const Hdf5File& from, Hdf5File& to, const std::string& group) {
    struct Copy {
        std::string path, unit;
        Hdf5Array<double> array;
    };
    const auto step = from.integer_attribute(group, "step");
    const double time = from.number_attribute(group, "time");
    std::vector<Copy> copies;
    for (const auto& name : from.children(group)) {
        const std::string path = group + "/" + name;
        copies.push_back({path, from.text_attribute(path, "unit"), from.read<double>(path)});
    }
    to.make_group(group);
    to.set_attribute(group, "step", step);
    to.set_attribute(group, "time", time);
    for (const Copy& copy : copies) {
        to.write(copy.path, copy.array.values, copy.array.columns);
        to.set_attribute(copy.path, "unit", copy.unit);
    }
}

} // namespace

FieldsWriter::FieldsWriter(std::filesystem::path folder, std::int64_t keep_through_step) : folder_(std::move(folder)) {
    make_folder(folder_ / "fields");
    const auto target = folder_ / "fields.h5", fresh = folder_ / "fields.h5.part";
    Hdf5File file = Hdf5File::create(fresh.string(), "mpm-driver", format);
    if (keep_through_step >= 0 && std::filesystem::exists(target)) keep_outputs(target, keep_through_step, file);
    file.close();
    std::filesystem::rename(fresh, target);
    for (int stale = next_; std::filesystem::remove(folder_ / vtu_name(stale)); ++stale) {} // of the run before
    write_pvd(folder_ / "fields.pvd", series_);
}

// A run killed while it wrote may leave a file that cannot be read to its end: what can be read stays, and the restart
// goes on, for its checkpoint is sound.
void FieldsWriter::keep_outputs(const std::filesystem::path& from, std::int64_t through_step, Hdf5File& to) {
    try {
        const Hdf5File old = Hdf5File::open(from.string());
        while (old.has(group_name(next_)) && old.integer_attribute(group_name(next_), "step") <= through_step) {
            copy_output(old, to, group_name(next_));
            series_.push_back({old.number_attribute(group_name(next_), "time"), vtu_name(next_)});
            ++next_;
        }
    } catch (const Error& error) {
        if (error.code() != ExitCode::bad_input) throw;
        log::warn("only {} outputs of the run before are kept: {}", next_, error.what());
    }
}

void FieldsWriter::write(std::int64_t step, double time, double thickness, const std::vector<FieldColumn>& columns) {
    Hdf5File file = Hdf5File::extend((folder_ / "fields.h5").string());
    const std::string group = group_name(next_);
    file.make_group(group);
    file.set_attribute(group, "step", step);
    file.set_attribute(group, "time", time);
    std::vector<double> position;
    std::vector<PointArray> arrays;
    for (const auto& column : columns) {
        const std::string path = group + "/" + column.name;
        file.write(path, column.data, static_cast<std::size_t>(column.components));
        file.set_attribute(path, "unit", column.unit);
        if (column.name == "position") {
            for (std::size_t i = 0; i + 1 < column.data.size(); i += 2)
                position.insert(position.end(), {column.data[i], column.data[i + 1], 0.0});
            continue;
        }
        arrays.push_back({fmt::format("{} ({})", column.name, column.unit), column.components, column.data});
    }
    file.write(group + "/thickness", std::vector<double>{thickness});
    file.set_attribute(group + "/thickness", "unit", "m");
    file.close();

    write_vtu(folder_ / vtu_name(next_), position, arrays);
    series_.push_back({time, vtu_name(next_)});
    write_pvd(folder_ / "fields.pvd", series_);
    ++next_;
}

} // namespace talik::driver
