#include "common/packing/packing_csv.hpp"

#include <cmath>
#include <map>

#include <fmt/format.h>

#include "common/io/csv_table.hpp"

namespace talik {
namespace {

std::map<long, int> index_of_id(const CsvTable& table) {
    std::map<long, int> index;
    const bool numbered = table.has("id");
    const std::size_t id = numbered ? table.column("id") : 0;
    for (std::size_t row = 0; row < table.rows.size(); ++row) {
        const long key = numbered ? std::lround(table.rows[row][id]) : static_cast<long>(row);
        if (!index.emplace(key, static_cast<int>(row)).second)
            throw table.fault(row, fmt::format("id {} appears twice", key), "give every disc its own id");
    }
    return index;
}

// Such a pair, or images of it, has no direction to push along.
void refuse_discs_at_one_place(const CsvTable& table, const Packing& packing) {
    constexpr double grid = 1e9; // places told apart, along a side of the cell
    const auto wrapped = [&](double reduced) { return std::lround((reduced - std::floor(reduced)) * grid) % std::lround(grid); };
    const auto inverse = packing.cell.inverse().eval();
    std::map<std::pair<long, long>, std::size_t> row_at;
    for (std::size_t row = 0; row < table.rows.size(); ++row) {
        const Vector reduced = inverse * Vector(packing.x[row], packing.y[row]);
        const auto [there, is_new] = row_at.emplace(std::pair(wrapped(reduced[0]), wrapped(reduced[1])), row);
        if (!is_new) throw table.fault(row, fmt::format("the disc lies where that of line {} lies", table.lines[there->second]), "give every disc a place of its own");
    }
}

void read_cell(const CsvTable& table, Packing& packing) {
    const double thickness = packing.thickness, density = packing.grain_density;
    packing.cell << table.comment_value("cell_h00"), table.comment_value("cell_h01"), table.comment_value("cell_h10"),
        table.comment_value("cell_h11");
    packing.thickness = table.comment_value("thickness", &thickness);
    packing.grain_density = table.comment_value("rho", &density);
    const std::string file = table.file + ": ";
    require(packing.cell.determinant() > 0.0, file + "the cell's area is not positive", "give the cell's vectors counter-clockwise");
    require(packing.thickness > 0.0, file + "the thickness is not positive", "give it in m");
    require(packing.grain_density > 0.0, file + "the density rho is not positive", "give it in kg/m^3");
}

int disc_of(const CsvTable& table, const std::map<long, int>& index, std::size_t row, const char* column) {
    const long id = std::lround(table.rows[row][table.column(column)]);
    const auto found = index.find(id);
    if (found == index.end()) throw table.fault(row, fmt::format("{} = {} is no disc of the packing", column, id), "use the ids of the file of discs");
    return found->second;
}

// The image k with x_second + H k - x_first = (r_first + r_second - overlap) n: exact up to the rounding of the text.
std::array<int, 2> image_of(const CsvTable& table, std::size_t row, const Packing& p, int first, int second, const Vector& normal,
                            double overlap) {
    const auto a = static_cast<std::size_t>(first), b = static_cast<std::size_t>(second);
    const Vector branch = (p.radius[a] + p.radius[b] - overlap) * normal;
    const Vector apart(p.x[b] - p.x[a], p.y[b] - p.y[a]);
    const Vector shift = p.cell.inverse() * (branch - apart);
    const std::array<int, 2> image = {static_cast<int>(std::lround(shift[0])), static_cast<int>(std::lround(shift[1]))};
    const Vector rest = apart + p.cell * Vector(image[0], image[1]) - branch;
    if (rest.norm() > 1e-3 * (p.radius[a] + p.radius[b])) // far above the text's rounding, far below a disc
        throw table.fault(row, "normal and overlap do not fit the positions of the two discs", "take discs and contacts from the same state");
    return image;
}

// Also sets the pressure p = sum(f_n |b|) / (2 A t) where the normal forces are given: for information only.
void read_contacts(const CsvTable& table, const std::map<long, int>& index, Packing& packing) {
    const std::size_t nx = table.column("nx"), ny = table.column("ny"), overlap = table.column("overlap");
    const std::size_t ftx = table.column("ftx"), fty = table.column("fty");
    const bool has_force = table.has("fn");
    double force_times_branch = 0.0; // N m
    for (std::size_t row = 0; row < table.rows.size(); ++row) {
        const auto& values = table.rows[row];
        const Vector normal(values[nx], values[ny]);
        if (std::abs(normal.norm() - 1.0) > 1e-6) throw table.fault(row, "the normal's length is not 1", "give a unit normal from id1 to id2");
        PackedContact c;
        c.first = disc_of(table, index, row, "id1");
        c.second = disc_of(table, index, row, "id2");
        c.image = image_of(table, row, packing, c.first, c.second, normal, values[overlap]);
        c.tangential_force = -values[ftx] * normal[1] + values[fty] * normal[0]; // component along t = (-n_y, n_x)
        packing.contacts.push_back(c);
        const double branch = packing.radius[static_cast<std::size_t>(c.first)] + packing.radius[static_cast<std::size_t>(c.second)] - values[overlap];
        if (has_force) force_times_branch += values[table.column("fn")] * branch;
    }
    packing.pressure = force_times_branch / (2.0 * packing.cell.determinant() * packing.thickness);
}

} // namespace

Packing read_packing_csv(const std::string& particles, const std::string& contacts) {
    const CsvTable discs = read_finite_csv(particles);
    Packing packing;
    read_cell(discs, packing);
    packing.x = discs.values("x");
    packing.y = discs.values("y");
    packing.radius = discs.values("radius");
    require(packing.disc_count() > 0, particles + ": holds no disc", "give one row for each disc");
    for (std::size_t row = 0; row < discs.rows.size(); ++row)
        if (!(packing.radius[row] > 0.0)) throw discs.fault(row, "the radius is not positive", "give it in m");
    refuse_discs_at_one_place(discs, packing);
    if (discs.has("vx") && discs.has("vy") && discs.has("wz")) {
        packing.velocity_x = discs.values("vx");
        packing.velocity_y = discs.values("vy");
        packing.spin = discs.values("wz");
    }
    const auto index = index_of_id(discs);
    if (!contacts.empty()) read_contacts(read_finite_csv(contacts), index, packing);
    return packing;
}

} // namespace talik
