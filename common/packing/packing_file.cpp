#include "common/packing/packing_file.hpp"

#include <filesystem>

#include <fmt/format.h>

#include "common/base/error.hpp"
#include "common/io/hdf5_file.hpp"

namespace talik {
namespace {

const std::string format = "talik-packing 1";

void write_contacts(Hdf5File& file, const std::string& group, const std::vector<PackedContact>& contacts) {
    std::vector<std::int64_t> discs, images;
    std::vector<double> forces;
    std::vector<std::uint8_t> bonded;
    for (const auto& c : contacts) {
        discs.insert(discs.end(), {c.first, c.second});
        images.insert(images.end(), {c.image[0], c.image[1]});
        forces.push_back(c.tangential_force);
        bonded.push_back(c.bonded);
    }
    file.write(group + "/contact_discs", discs, 2);
    file.write(group + "/contact_images", images, 2);
    file.write(group + "/contact_tangential_force_N", forces);
    file.write(group + "/contact_bonded", bonded);
}

void write_packing(Hdf5File& file, const std::string& group, const Packing& p) {
    file.make_group(group);
    file.write(group + "/cell_m", std::vector<double>{p.cell(0, 0), p.cell(0, 1), p.cell(1, 0), p.cell(1, 1)}, 2);
    file.set_attribute(group, "thickness_m", p.thickness);
    file.set_attribute(group, "grain_density_kg_m3", p.grain_density);
    file.set_attribute(group, "pressure_Pa", p.pressure);
    file.set_attribute(group, "vertical_stress_Pa", p.vertical_stress);
    file.set_attribute(group, "lateral_stress_Pa", p.lateral_stress);
    file.set_attribute(group, "void_ratio", p.void_ratio());
    file.set_attribute(group, "seed", static_cast<std::int64_t>(p.seed));
    file.set_attribute(group, "stiffness_Pa", p.stiffness);
    file.set_attribute(group, "stable_step_s", p.stable_step);
    file.write(group + "/x_m", p.x);
    file.write(group + "/y_m", p.y);
    file.write(group + "/radius_m", p.radius);
    file.write(group + "/velocity_x_m_s", p.velocity_x); // empty = at rest
    file.write(group + "/velocity_y_m_s", p.velocity_y);
    file.write(group + "/spin_1_s", p.spin);
    write_contacts(file, group, p.contacts);
}

// Faults of a file that was tampered with, or written by something else, before they become faults of memory.
void check(const std::string& place, const Packing& p) {
    const auto discs = p.radius.size();
    const auto fits = [&](const std::vector<double>& column, bool may_be_empty) {
        return column.size() == discs || (may_be_empty && column.empty());
    };
    const std::string mend = "prepare the packing anew with `rve-farm pack`";
    require(discs > 0, place + ": holds no disc", mend);
    require(fits(p.x, false) && fits(p.y, false) && fits(p.velocity_x, true) && fits(p.velocity_y, true) && fits(p.spin, true),
            place + ": columns of the discs differ in length", mend);
    require(p.velocity_x.size() == p.velocity_y.size() && p.velocity_x.size() == p.spin.size(), place + ": only some velocities are given", mend);
    require(p.cell.determinant() > 0.0, place + ": the cell's area is not positive", mend);
    for (const auto& c : p.contacts)
        require(c.first >= 0 && c.second >= 0 && c.first < p.disc_count() && c.second < p.disc_count(), place + ": a contact names a disc that is not there", mend);
}

void read_contacts(const Hdf5File& file, const std::string& group, Packing& p) {
    const auto discs = file.read<std::int64_t>(group + "/contact_discs").values;
    const auto images = file.read<std::int64_t>(group + "/contact_images").values;
    const auto forces = file.read<double>(group + "/contact_tangential_force_N").values;
    const auto bonded = file.read<std::uint8_t>(group + "/contact_bonded").values;
    require(discs.size() == 2 * forces.size() && images.size() == discs.size() && bonded.size() == forces.size(),
            file.name() + ": " + group + ": columns of the contacts differ in length", "prepare the packing anew with `rve-farm pack`");
    for (std::size_t c = 0; c < forces.size(); ++c)
        p.contacts.push_back({static_cast<int>(discs[2 * c]), static_cast<int>(discs[2 * c + 1]),
                              {static_cast<int>(images[2 * c]), static_cast<int>(images[2 * c + 1])}, forces[c], bonded[c] != 0});
}

Packing read_packing(const Hdf5File& file, const std::string& group) {
    Packing p;
    const auto cell = file.read<double>(group + "/cell_m").values;
    require(cell.size() == 4, file.name() + ": " + group + ": the cell is not 2 by 2", "prepare the packing anew with `rve-farm pack`");
    p.cell << cell[0], cell[1], cell[2], cell[3];
    p.thickness = file.number_attribute(group, "thickness_m");
    p.grain_density = file.number_attribute(group, "grain_density_kg_m3");
    p.pressure = file.number_attribute(group, "pressure_Pa");
    if (file.has_attribute(group, "vertical_stress_Pa")) { // not in files from before there were K0 paths
        p.vertical_stress = file.number_attribute(group, "vertical_stress_Pa");
        p.lateral_stress = file.number_attribute(group, "lateral_stress_Pa");
    }
    p.seed = static_cast<std::uint64_t>(file.integer_attribute(group, "seed"));
    p.stiffness = file.number_attribute(group, "stiffness_Pa");
    p.stable_step = file.number_attribute(group, "stable_step_s");
    p.x = file.read<double>(group + "/x_m").values;
    p.y = file.read<double>(group + "/y_m").values;
    p.radius = file.read<double>(group + "/radius_m").values;
    p.velocity_x = file.read<double>(group + "/velocity_x_m_s").values;
    p.velocity_y = file.read<double>(group + "/velocity_y_m_s").values;
    p.spin = file.read<double>(group + "/spin_1_s").values;
    read_contacts(file, group, p);
    check(file.name() + ": " + group, p);
    return p;
}

} // namespace

void check_place_of_packings(const std::string& file) { require_replaceable(file, format, "give -o another name"); }

void write_packings(const std::string& file, const std::string& program, const std::vector<Packing>& packings, const std::string& specification) {
    const std::string temporary = file + ".part";
    std::error_code why;
    try {
        Hdf5File out = Hdf5File::create(temporary, program, format);
        if (!specification.empty()) out.write_text("/specification", specification);
        for (std::size_t i = 0; i < packings.size(); ++i) write_packing(out, fmt::format("/packing/{:04}", i), packings[i]);
        out.close();
    } catch (...) { // a half takes the room that may be lacking, and is of no use
        std::filesystem::remove(temporary, why);
        throw;
    }
    std::filesystem::rename(temporary, file, why);
    if (why) throw Error(ExitCode::bad_input, file, "cannot be written: " + why.message(), "give -o the name of a file in a folder you may write to");
}

std::vector<Packing> read_packings(const std::string& file) {
    const Hdf5File in = Hdf5File::open(file);
    in.require_format(format);
    std::vector<Packing> packings;
    for (const auto& name : in.children("/packing")) packings.push_back(read_packing(in, "/packing/" + name));
    require(!packings.empty(), file + ": holds no packing", "prepare one with `rve-farm pack`");
    return packings;
}

} // namespace talik
