#include "rve-farm/element/element_output.hpp"

#include <cmath>

#include <fmt/format.h>

#include "common/base/error.hpp"
#include "common/base/version.hpp"
#include "common/io/csv_table.hpp"
#include "common/io/hdf5_file.hpp"
#include "common/io/text_file.hpp"

namespace talik::farm {
namespace {

struct Column {
    const char* name;
    double (*value)(const ElementRow&);
};

constexpr Column columns[] = {
    {"step", [](const ElementRow& r) { return static_cast<double>(r.step); }},
    {"time_s", [](const ElementRow& r) { return r.time; }},
    {"log_strain_xx_compression", [](const ElementRow& r) { return -r.strain_xx; }},
    {"log_strain_yy_compression", [](const ElementRow& r) { return -r.strain_yy; }},
    {"gamma_xy", [](const ElementRow& r) { return r.gamma; }}, // positive with sxy of the tension-positive convention
    {"volume_strain_compression", [](const ElementRow& r) { return -(r.strain_xx + r.strain_yy); }},
    {"stress_xx_compression_Pa", [](const ElementRow& r) { return -r.answer.stress[0]; }},
    {"stress_yy_compression_Pa", [](const ElementRow& r) { return -r.answer.stress[1]; }},
    {"stress_xy_tension_positive_Pa", [](const ElementRow& r) { return r.answer.stress[2]; }},
    {"stress_ratio_yy_to_xx", [](const ElementRow& r) { return r.answer.stress[0] != 0.0 ? r.answer.stress[1] / r.answer.stress[0] : 0.0; }},
    {"void_ratio", [](const ElementRow& r) { return r.answer.void_ratio; }},
    {"coordination_number", [](const ElementRow& r) { return r.answer.coordination_number; }},
    {"bonds", [](const ElementRow& r) { return static_cast<double>(r.answer.bonds); }},
    {"broken_bonds", [](const ElementRow& r) { return static_cast<double>(r.answer.broken_bonds); }},
    {"unbalanced_force_ratio", [](const ElementRow& r) { return r.answer.unbalanced_force; }},
    {"work_J", [](const ElementRow& r) { return r.answer.work; }},
    {"stored_energy_J", [](const ElementRow& r) { return r.answer.stored_energy; }},
    {"kinetic_energy_J", [](const ElementRow& r) { return r.answer.kinetic_energy; }},
    {"friction_dissipation_J", [](const ElementRow& r) { return r.answer.friction_dissipation; }},
    {"damping_dissipation_J", [](const ElementRow& r) { return r.answer.damping_dissipation; }},
    {"bond_dissipation_J", [](const ElementRow& r) { return r.answer.bond_dissipation; }},
};

using Rows = std::vector<std::vector<double>>;

Rows rows_of(const ElementCurve& curve) {
    Rows rows;
    for (const ElementRow& row : curve) rows.push_back(element_values(row));
    return rows;
}

// Mean and standard deviation (n - 1; 0 for one curve) over the curves, row by row.
void statistics(const std::vector<Rows>& all, Rows& mean, Rows& deviation) {
    const auto count = static_cast<double>(all.size());
    mean = deviation = Rows(all[0].size(), std::vector<double>(all[0][0].size(), 0.0));
    for (const Rows& rows : all)
        for (std::size_t r = 0; r < rows.size(); ++r)
            for (std::size_t c = 0; c < rows[r].size(); ++c) mean[r][c] += rows[r][c] / count;
    for (const Rows& rows : all)
        for (std::size_t r = 0; r < rows.size(); ++r)
            for (std::size_t c = 0; c < rows[r].size(); ++c) deviation[r][c] += std::pow(rows[r][c] - mean[r][c], 2) / std::max(1.0, count - 1.0);
    for (auto& row : deviation)
        for (double& value : row) value = std::sqrt(value);
}

// Curves of an earlier test with more RVEs would pass for ones of this.
void remove_old_curves(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> old;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        const std::string name = entry.path().filename().string();
        if (name.starts_with("rve-") && name.ends_with(".csv") && name.find_first_not_of("0123456789", 4) == name.size() - 4) old.push_back(entry.path());
    }
    for (const auto& path : old) std::filesystem::remove(path);
}

void write_group(Hdf5File& file, const std::string& group, const Rows& rows) {
    std::vector<double> values(rows.size());
    for (std::size_t c = 0; c < std::size(columns); ++c) {
        for (std::size_t r = 0; r < rows.size(); ++r) values[r] = rows[r][c];
        file.write(group + "/" + columns[c].name, values);
    }
}

} // namespace

const std::vector<std::string>& element_columns() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> made;
        for (const Column& column : columns) made.emplace_back(column.name);
        return made;
    }();
    return names;
}

std::vector<double> element_values(const ElementRow& row) {
    std::vector<double> values;
    for (const Column& column : columns) values.push_back(column.value(row));
    return values;
}

void write_element_curves(const std::filesystem::path& folder, const std::string& title, const std::string& specification,
                          const std::vector<ElementCurve>& curves) {
    ensure(!curves.empty());
    make_folder(folder);
    remove_old_curves(folder);
    const std::string by = "rve-farm " + version() + ": " + title;
    Hdf5File file = Hdf5File::create((folder / "curves.h5").string(), "rve-farm", "talik-element 1");
    file.set_attribute("/", "title", title);
    file.write_text("/specification", specification);
    std::vector<Rows> all;
    for (std::size_t i = 0; i < curves.size(); ++i) {
        all.push_back(rows_of(curves[i]));
        write_csv((folder / fmt::format("rve-{:04}.csv", i)).string(), {by}, element_columns(), all.back());
        write_group(file, fmt::format("/rve/{:04}", i), all.back());
    }
    Rows mean, deviation;
    statistics(all, mean, deviation);
    write_group(file, "/mean", mean);
    write_group(file, "/sd", deviation);
    file.close();
    std::vector<std::string> names = element_columns();
    for (const std::string& name : element_columns()) names.push_back(name + "_sd");
    for (std::size_t r = 0; r < mean.size(); ++r) mean[r].insert(mean[r].end(), deviation[r].begin(), deviation[r].end());
    write_csv((folder / "mean.csv").string(), {by, fmt::format("mean and standard deviation (_sd) over {} RVEs", curves.size())}, names, mean);
}

} // namespace talik::farm
