#include "rve-farm/assembly/neighbours.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "rve-farm/assembly/lattice_reduction.hpp"

namespace talik::farm {
namespace {

constexpr double farthest_image = 1e6; // in cells; discs are wrapped at every rebuild, so an honest one is next door

struct Candidate {
    std::int32_t first, second, image_x, image_y;
    std::int32_t old_slot; // -1: new to the list
};

bool before(const Candidate& a, const Candidate& b) {
    if (a.second != b.second) return a.second < b.second;
    if (a.image_y != b.image_y) return a.image_y < b.image_y;
    return a.image_x < b.image_x;
}

struct Scratch {
    std::vector<std::int32_t> wrap_x, wrap_y;       // of each disc, in multiples of the cell's columns
    std::vector<std::int32_t> bin_of, bin_begin, bin_discs; // linked cells
    std::vector<Candidate> candidates;
    std::vector<std::byte> column;                   // one column, while it is reordered
};

// A disc and its own image touch in both directions: one of them is the canonical one.
bool is_canonical_own_image(int image_x, int image_y) { return image_y > 0 || (image_y == 0 && image_x > 0); }

struct Cell {
    double xx, xy, yx, yy;   // H'
    double area;             // |det H'|, m^2
    double height_x, height_y; // distance of opposite sides, m

    explicit Cell(const AssemblyNumbers& n) : xx(n.cell_xx), xy(n.cell_xy), yx(n.cell_yx), yy(n.cell_yy) {
        determinant = xx * yy - xy * yx;
        area = std::abs(determinant);
        height_x = area / std::hypot(xy, yy);
        height_y = area / std::hypot(xx, yx);
    }
    double reduced_x(double x, double y) const { return (yy * x - xy * y) / determinant; }
    double reduced_y(double x, double y) const { return (xx * y - yx * x) / determinant; }
    double determinant;
};

void reduce_and_remap(AssemblyView& s) {
    AssemblyNumbers& n = *s.numbers;
    const BasisChange change = reduce_basis(n.cell_xx, n.cell_xy, n.cell_yx, n.cell_yy);
    if (change.identity()) return;
    n.lost_xx = n.lost_xy = n.lost_yx = n.lost_yy = 0; // belongs to the old basis
    for (int c = 0; c < s.contact_count(); ++c) {
        const auto image = change.image(s.image_x[c], s.image_y[c]);
        s.image_x[c] = static_cast<std::int32_t>(image[0]);
        s.image_y[c] = static_cast<std::int32_t>(image[1]);
    }
}

// x <- x - H w; the image of a contact takes up the difference, so that its branch stays what it was.
// False where a disc is not a number, or so far away that its image is none.
bool wrap_into_the_cell(AssemblyView& s, Scratch& scratch) {
    const Cell cell(*s.numbers);
    const int discs = s.disc_count();
    scratch.wrap_x.resize(static_cast<std::size_t>(discs));
    scratch.wrap_y.resize(static_cast<std::size_t>(discs));
    for (int i = 0; i < discs; ++i) {
        const double wx = std::floor(cell.reduced_x(s.x[i], s.y[i])), wy = std::floor(cell.reduced_y(s.x[i], s.y[i]));
        if (!(std::abs(wx) < farthest_image && std::abs(wy) < farthest_image)) return false;
        scratch.wrap_x[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(wx);
        scratch.wrap_y[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(wy);
        if (wx == 0 && wy == 0) continue;
        s.x[i] -= cell.xx * wx + cell.xy * wy;
        s.y[i] -= cell.yx * wx + cell.yy * wy;
    }
    for (int c = 0; c < s.contact_count(); ++c) {
        const auto i = static_cast<std::size_t>(s.first[c]), j = static_cast<std::size_t>(s.second[c]);
        s.image_x[c] += scratch.wrap_x[j] - scratch.wrap_x[i];
        s.image_y[c] += scratch.wrap_y[j] - scratch.wrap_y[i];
    }
    return true;
}

// A reduction may turn the image of a self-contact to the other side: then its two ends swap. f_t stays, since force and t
// both turn.
void keep_own_images_canonical(AssemblyView& s) {
    for (int c = 0; c < s.contact_count(); ++c) {
        if (s.first[c] != s.second[c] || is_canonical_own_image(s.image_x[c], s.image_y[c])) continue;
        s.image_x[c] = -s.image_x[c];
        s.image_y[c] = -s.image_y[c];
    }
}

bool within_skin(const AssemblyView& s, const Cell& cell, int i, int j, int image_x, int image_y) {
    const double bx = s.x[j] - s.x[i] + (cell.xx * image_x + cell.xy * image_y);
    const double by = s.y[j] - s.y[i] + (cell.yx * image_x + cell.yy * image_y);
    const double reach = s.radius[i] + s.radius[j] + s.numbers->skin;
    return bx * bx + by * by < reach * reach;
}

// All images that could be in reach of a disc: reduced coordinates differ by less than 1.
void find_by_brute_force(const AssemblyView& s, const Cell& cell, int i, double reach, std::vector<Candidate>& found) {
    const int range_x = static_cast<int>(reach / cell.height_x) + 1, range_y = static_cast<int>(reach / cell.height_y) + 1;
    for (int j = i; j < s.disc_count(); ++j)
        for (int image_y = -range_y; image_y <= range_y; ++image_y)
            for (int image_x = -range_x; image_x <= range_x; ++image_x) {
                if (j == i && !is_canonical_own_image(image_x, image_y)) continue;
                if (within_skin(s, cell, i, j, image_x, image_y)) found.push_back({i, j, image_x, image_y, -1});
            }
}

// Bins in reduced coordinates, each at least `reach` wide; three or more along each axis, so that the nine bins around a
// disc are different ones and each pair is met once.
struct Bins {
    int along_x, along_y;
    Bins(const Cell& cell, double reach)
        : along_x(static_cast<int>(std::min(cell.height_x / reach, 1e3))),
          along_y(static_cast<int>(std::min(cell.height_y / reach, 1e3))) {}
    bool usable() const { return along_x >= 3 && along_y >= 3; }
    static int clamp(double reduced, int along) { return std::clamp(static_cast<int>(reduced * along), 0, along - 1); }
    int count() const { return along_x * along_y; }
};

void fill_bins(const AssemblyView& s, const Cell& cell, const Bins& bins, Scratch& scratch) {
    const int discs = s.disc_count();
    scratch.bin_of.resize(static_cast<std::size_t>(discs));
    scratch.bin_discs.resize(static_cast<std::size_t>(discs));
    scratch.bin_begin.assign(static_cast<std::size_t>(bins.count()) + 1, 0);
    for (int i = 0; i < discs; ++i) {
        const int bin = Bins::clamp(cell.reduced_x(s.x[i], s.y[i]), bins.along_x) +
                        Bins::clamp(cell.reduced_y(s.x[i], s.y[i]), bins.along_y) * bins.along_x;
        scratch.bin_of[static_cast<std::size_t>(i)] = bin;
        ++scratch.bin_begin[static_cast<std::size_t>(bin) + 1];
    }
    for (std::size_t b = 0; b + 1 < scratch.bin_begin.size(); ++b) scratch.bin_begin[b + 1] += scratch.bin_begin[b];
    for (int i = discs - 1; i >= 0; --i) { // from behind: offsets end as begins, discs ascend within a bin
        auto& end = scratch.bin_begin[static_cast<std::size_t>(scratch.bin_of[static_cast<std::size_t>(i)]) + 1];
        scratch.bin_discs[static_cast<std::size_t>(--end)] = i;
    }
    // After the loop entry b + 1 holds the begin of bin b: shift by one.
    for (std::size_t b = 0; b + 1 < scratch.bin_begin.size(); ++b) scratch.bin_begin[b] = scratch.bin_begin[b + 1];
    scratch.bin_begin.back() = discs;
}

void find_by_bins(const AssemblyView& s, const Cell& cell, const Bins& bins, const Scratch& scratch, int i,
                  std::vector<Candidate>& found) {
    const int own = scratch.bin_of[static_cast<std::size_t>(i)];
    const int own_x = own % bins.along_x, own_y = own / bins.along_x;
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
            int bin_x = own_x + dx, bin_y = own_y + dy, image_x = 0, image_y = 0;
            if (bin_x < 0) bin_x += bins.along_x, image_x = -1;
            if (bin_x >= bins.along_x) bin_x -= bins.along_x, image_x = 1;
            if (bin_y < 0) bin_y += bins.along_y, image_y = -1;
            if (bin_y >= bins.along_y) bin_y -= bins.along_y, image_y = 1;
            const auto bin = static_cast<std::size_t>(bin_y * bins.along_x + bin_x);
            for (int k = scratch.bin_begin[bin]; k < scratch.bin_begin[bin + 1]; ++k) {
                const int j = scratch.bin_discs[static_cast<std::size_t>(k)];
                if (j > i && within_skin(s, cell, i, j, image_x, image_y)) found.push_back({i, j, image_x, image_y, -1});
            }
        }
}

bool remembers(const AssemblyView& s, const ColumnChoice& columns, int c) {
    return s.tangential_force[c] != 0 || (columns.bond && s.bonded[c] != 0);
}

// Ties the new candidates of disc i to their old slots; a bonded pair that has left the skin is added again.
void find_old_slots(const AssemblyView& s, const ColumnChoice& columns, int i, std::size_t begin,
                    std::vector<Candidate>& found) {
    for (int c = s.owned_begin[i]; c < s.owned_begin[i + 1]; ++c) {
        if (!remembers(s, columns, c)) continue;
        const Candidate old{i, s.second[c], s.image_x[c], s.image_y[c], c};
        bool listed = false;
        for (std::size_t k = begin; k < found.size() && !listed; ++k) {
            if (found[k].second != old.second || found[k].image_x != old.image_x || found[k].image_y != old.image_y) continue;
            found[k].old_slot = c;
            listed = true;
        }
        if (!listed && columns.bond && s.bonded[c] != 0) found.push_back(old);
    }
}

// Every contact column in the new order; what is new to the list starts at zero.
void reorder_contacts(AssemblyView& s, const ColumnChoice& columns, Scratch& scratch) {
    const std::vector<Candidate>& list = scratch.candidates;
    for_each_column(s, columns, [&](const char*, const char*, Extent extent, auto*& column, bool present) {
        if (!present || extent != Extent::contacts) return;
        using Entry = std::remove_reference_t<decltype(*column)>;
        const auto old_count = static_cast<std::size_t>(s.contact_count());
        scratch.column.resize(std::max<std::size_t>(1, old_count * sizeof(Entry)));
        std::memcpy(scratch.column.data(), column, old_count * sizeof(Entry));
        const Entry* old = reinterpret_cast<const Entry*>(scratch.column.data());
        for (std::size_t c = 0; c < list.size(); ++c) column[c] = list[c].old_slot < 0 ? Entry{} : old[list[c].old_slot];
    });
    for (std::size_t c = 0; c < list.size(); ++c) {
        s.first[c] = list[c].first;
        s.second[c] = list[c].second;
        s.image_x[c] = list[c].image_x;
        s.image_y[c] = list[c].image_y;
    }
    s.numbers->contact_count = static_cast<std::int64_t>(list.size());
}

// All pairs within the skin, in canonical order; false where there is no room for them.
bool find_candidates(const AssemblyView& s, const ColumnChoice& columns, Search search, Scratch& scratch) {
    const AssemblyNumbers& n = *s.numbers;
    const Cell cell(n);
    const double reach = 2 * n.largest_radius + n.skin;
    const Bins bins(cell, reach);
    const bool linked = search != Search::brute_force && bins.usable();
    if (linked) fill_bins(s, cell, bins, scratch);
    scratch.candidates.clear();
    for (int i = 0; i < s.disc_count(); ++i) {
        const std::size_t begin = scratch.candidates.size();
        if (linked) find_by_bins(s, cell, bins, scratch, i, scratch.candidates);
        else find_by_brute_force(s, cell, i, reach, scratch.candidates);
        find_old_slots(s, columns, i, begin, scratch.candidates);
        std::sort(scratch.candidates.begin() + static_cast<std::ptrdiff_t>(begin), scratch.candidates.end(), before);
        if (scratch.candidates.size() > static_cast<std::size_t>(n.contact_capacity)) return false;
    }
    return true;
}

} // namespace

void index_owned(AssemblyView& s) {
    int c = 0;
    for (int i = 0; i <= s.disc_count(); ++i) {
        while (c < s.contact_count() && s.first[c] < i) ++c;
        s.owned_begin[i] = c;
    }
}

double displacement_left(const AssemblyNumbers& n, double strain) {
    const double reach = 2 * n.largest_radius;
    const double gap = std::exp(-(n.strain_bound + strain)) * (reach + n.skin) - reach; // m
    return gap / 2 - n.displacement_bound * (1 + 1.001 * strain);
}

// A wide skin is walked in every sub-step, a narrow one is soon spent. With c the part of the skin that a sub-step spends
// and r the mean radius, a sub-step costs 1 + a skin/r + R c/skin of one without skin, R the cost of a rebuild in sub-steps:
// least at skin = sqrt(R/a c r). R/a was measured, docs/performance.md; the optimum is flat, a factor of two costs little.
void choose_skin(AssemblyNumbers& n) {
    constexpr double rebuild_over_width = 40;
    if (!(n.narrowest_skin < n.widest_skin) || !(n.list_substeps > 0)) return;
    const double spent = 2 * n.displacement_bound - std::expm1(-n.strain_bound) * (2 * n.largest_radius + n.skin); // m
    const double best = std::sqrt(rebuild_over_width * n.mean_radius * spent / n.list_substeps);
    n.skin = std::clamp(best, n.narrowest_skin, n.widest_skin);
}

Status rebuild_neighbours(AssemblyView& s, const ColumnChoice& columns, Search search) {
    thread_local Scratch scratch;
    const double old_skin = s.numbers->skin; // m
    choose_skin(*s.numbers);
    reduce_and_remap(s);
    if (!wrap_into_the_cell(s, scratch)) return Status::not_finite;
    keep_own_images_canonical(s);

    AssemblyNumbers& n = *s.numbers;
    while (!find_candidates(s, columns, search, scratch)) { // small discs crowded among large ones: less skin, sooner spent
        if (n.skin <= n.narrowest_skin) {
            n.skin = old_skin; // of the list that stays
            return Status::contact_list_full;
        }
        n.skin = std::max(n.skin / 2, n.narrowest_skin);
    }
    reorder_contacts(s, columns, scratch);
    index_owned(s);
    std::fill_n(s.drift_x, s.disc_count(), 0.0);
    std::fill_n(s.drift_y, s.disc_count(), 0.0);
    n.displacement_bound = n.strain_bound = n.list_substeps = 0;
    n.omega_squared_bound = -1; // of another list: to be found again when it is asked for
    ++n.rebuilds;
    return Status::ok;
}

} // namespace talik::farm
