#include "rve-farm/assembly/neighbours.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>
#include <utility>
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

// A disc, or an image of one across a side of the cell, in its bin.
struct Binned {
    double x, y, radius; // m
    std::int32_t disc;
    std::int16_t image_x, image_y;
};

struct Scratch {
    std::vector<std::int32_t> wrap_x, wrap_y;  // of each disc, in multiples of the cell's columns
    std::vector<std::int32_t> bin_of, bin_end; // of each disc; of each bin
    std::vector<Binned> binned;                // bin by bin
    std::vector<std::int32_t> near;            // those of a row that are
    std::vector<Candidate> candidates;         // room for more than there are
    std::size_t found = 0;                     // candidates
    std::vector<std::byte> column;             // one column, while it is reordered
};

// A disc and its own image touch in both directions: one of them is the canonical one.
bool is_canonical_own_image(int image_x, int image_y) { return image_y > 0 || (image_y == 0 && image_x > 0); }

struct Cell {
    double xx, xy, yx, yy;   // H'
    double area;             // |det H'|, m^2
    double height_x, height_y; // distance of opposite sides, m

    explicit Cell(const AssemblyNumbers& n) : xx(n.cell_xx), xy(n.cell_xy), yx(n.cell_yx), yy(n.cell_yy) {
        const double determinant = xx * yy - xy * yx;
        area = std::abs(determinant);
        inverse = 1 / determinant;
        height_x = area / std::hypot(xy, yy);
        height_y = area / std::hypot(xx, yx);
    }
    double reduced_x(double x, double y) const { return (yy * x - xy * y) * inverse; }
    double reduced_y(double x, double y) const { return (xx * y - yx * x) * inverse; }
    double inverse;          // 1 / det H', 1/m^2
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

std::int32_t floor_of(double small) {
    const auto whole = static_cast<std::int32_t>(small);
    return whole - (small < whole);
}

// x <- x - H w; the image of a contact takes up the difference, so that its branch stays what it was.
// False where a disc is not a number, or so far away that its image is none.
bool wrap_into_the_cell(AssemblyView& s, Scratch& scratch) {
    const Cell cell(*s.numbers);
    const int discs = s.disc_count();
    scratch.wrap_x.resize(static_cast<std::size_t>(discs));
    scratch.wrap_y.resize(static_cast<std::size_t>(discs));
    for (int i = 0; i < discs; ++i) {
        const double reduced_x = cell.reduced_x(s.x[i], s.y[i]), reduced_y = cell.reduced_y(s.x[i], s.y[i]);
        if (!(std::abs(reduced_x) < farthest_image && std::abs(reduced_y) < farthest_image)) return false;
        const std::int32_t wx = floor_of(reduced_x), wy = floor_of(reduced_y);
        scratch.wrap_x[static_cast<std::size_t>(i)] = wx;
        scratch.wrap_y[static_cast<std::size_t>(i)] = wy;
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

void make_room(Scratch& scratch, std::size_t for_more) {
    if (scratch.found + for_more > scratch.candidates.size()) scratch.candidates.resize(2 * (scratch.found + for_more));
}
void add(Scratch& scratch, const Candidate& candidate) {
    make_room(scratch, 1);
    scratch.candidates[scratch.found++] = candidate;
}

// All images that could be in reach of a disc: reduced coordinates differ by less than 1.
void find_by_brute_force(const AssemblyView& s, const Cell& cell, int i, double reach, Scratch& scratch) {
    const int range_x = static_cast<int>(reach / cell.height_x) + 1, range_y = static_cast<int>(reach / cell.height_y) + 1;
    for (int j = i; j < s.disc_count(); ++j)
        for (int image_y = -range_y; image_y <= range_y; ++image_y)
            for (int image_x = -range_x; image_x <= range_x; ++image_x) {
                if (j == i && !is_canonical_own_image(image_x, image_y)) continue;
                const double x = branch_component<double>(s.x[i], s.x[j], cell.xx, cell.xy, image_x, image_y);
                const double y = branch_component<double>(s.y[i], s.y[j], cell.yx, cell.yy, image_x, image_y);
                const double near = s.radius[i] + s.radius[j] + s.numbers->skin;
                if (x * x + y * y < near * near) add(scratch, {i, j, image_x, image_y, -1});
            }
}

// Bins in reduced coordinates, each at least `reach` wide; three or more along each axis, so that each pair is met once. Around
// them lie bins of the images across the sides of the cell: so the neighbours of a disc lie in three rows of three bins.
struct Bins {
    int along_x, along_y;
    Bins(const Cell& cell, double reach)
        : along_x(static_cast<int>(std::min(cell.height_x / reach, 1e3))),
          along_y(static_cast<int>(std::min(cell.height_y / reach, 1e3))) {}
    bool usable() const { return along_x >= 3 && along_y >= 3; }
    static int clamp(double reduced, int along) { return std::clamp(static_cast<int>(reduced * along), 0, along - 1); }
    int row() const { return along_x + 2; }
    int count() const { return row() * (along_y + 2); }
    int bin(int x, int y) const { return (y + 1) * row() + x + 1; }
    // visit(bin, image x, image y) of a disc and of its images.
    template <class Visitor>
    void each_image(int own, Visitor&& visit) const {
        const int x = own % row() - 1, y = own / row() - 1;
        const int side_x = x == 0 ? 1 : x == along_x - 1 ? -1 : 0, side_y = y == 0 ? 1 : y == along_y - 1 ? -1 : 0;
        visit(own, 0, 0);
        if (side_x) visit(own + side_x * along_x, side_x, 0);
        if (side_y) visit(own + side_y * along_y * row(), 0, side_y);
        if (side_x && side_y) visit(own + side_x * along_x + side_y * along_y * row(), side_x, side_y);
    }
};

void fill_bins(const AssemblyView& s, const Cell& cell, const Bins& bins, Scratch& scratch) {
    const int discs = s.disc_count();
    scratch.bin_of.resize(static_cast<std::size_t>(discs));
    scratch.bin_end.assign(static_cast<std::size_t>(bins.count()) + 1, 0);
    std::int32_t* const begin = scratch.bin_end.data() + 1; // of each bin; once it is filled, its end
    for (int i = 0; i < discs; ++i) {
        const int own = bins.bin(Bins::clamp(cell.reduced_x(s.x[i], s.y[i]), bins.along_x), Bins::clamp(cell.reduced_y(s.x[i], s.y[i]), bins.along_y));
        scratch.bin_of[static_cast<std::size_t>(i)] = own;
        bins.each_image(own, [&](int bin, int, int) { ++begin[bin]; });
    }
    std::int32_t before = 0;
    for (int bin = 0; bin < bins.count(); ++bin) before += std::exchange(begin[bin], before);
    scratch.binned.resize(std::max(scratch.binned.size(), 4 * static_cast<std::size_t>(discs))); // no disc has more images
    for (int i = 0; i < discs; ++i)
        bins.each_image(scratch.bin_of[static_cast<std::size_t>(i)], [&](int bin, int image_x, int image_y) {
            scratch.binned[static_cast<std::size_t>(begin[bin]++)] = {s.x[i] + (cell.xx * image_x + cell.xy * image_y), s.y[i] + (cell.yx * image_x + cell.yy * image_y), s.radius[i], i,
                                                                      static_cast<std::int16_t>(image_x), static_cast<std::int16_t>(image_y)};
        });
}

// Without a branch for each: whether a neighbour is near enough nobody can predict.
void find_by_bins(const AssemblyView& s, const Bins& bins, int i, Scratch& scratch) {
    const double x = s.x[i], y = s.y[i], reach = s.radius[i] + s.numbers->skin;
    const std::int32_t* end = scratch.bin_end.data() + 1;
    const int own = scratch.bin_of[static_cast<std::size_t>(i)];
    for (int middle : {own - bins.row(), own, own + bins.row()}) {
        const std::int32_t from = end[middle - 2], to = end[middle + 1];
        if (static_cast<std::size_t>(to - from) > scratch.near.size()) scratch.near.resize(static_cast<std::size_t>(to - from));
        const Binned* const binned = scratch.binned.data();
        std::int32_t* const near = scratch.near.data();
        int count = 0;
        for (std::int32_t k = from; k < to; ++k) {
            const Binned& other = binned[k];
            const double bx = other.x - x, by = other.y - y, far = other.radius + reach;
            near[count] = k;
            count += static_cast<int>(bx * bx + by * by < far * far) & static_cast<int>(other.disc > i);
        }
        for (int n = 0; n < count; ++n) {
            const Binned& other = binned[near[n]];
            add(scratch, {i, other.disc, other.image_x, other.image_y, -1});
        }
    }
}

bool remembers(const AssemblyView& s, const ColumnChoice& columns, int c) {
    return s.tangential_force[c] != 0 || (columns.bond && s.bonded[c] != 0);
}

// Ties the new candidates of disc i to their old slots; a bonded pair that has left the skin is added again.
void find_old_slots(const AssemblyView& s, const ColumnChoice& columns, int i, std::size_t begin, Scratch& scratch) {
    for (int c = s.owned_begin[i]; c < s.owned_begin[i + 1]; ++c) {
        if (!remembers(s, columns, c)) continue;
        const Candidate old{i, s.second[c], s.image_x[c], s.image_y[c], c};
        bool listed = false;
        for (std::size_t k = begin; k < scratch.found && !listed; ++k) {
            Candidate& found = scratch.candidates[k];
            if (found.second != old.second || found.image_x != old.image_x || found.image_y != old.image_y) continue;
            found.old_slot = c;
            listed = true;
        }
        if (!listed && columns.bond && s.bonded[c] != 0) add(scratch, old);
    }
}

// A handful of them: by insertion.
void sort(Candidate* begin, Candidate* end) {
    for (Candidate* next = begin; next < end; ++next) {
        const Candidate candidate = *next;
        Candidate* place = next;
        for (; place > begin && before(candidate, place[-1]); --place) *place = place[-1];
        *place = candidate;
    }
}

// Every contact column in the new order; what is new to the list starts at zero.
void reorder_contacts(AssemblyView& s, const ColumnChoice& columns, Scratch& scratch) {
    const std::span<const Candidate> list(scratch.candidates.data(), scratch.found);
    const auto is_of_the_list = [&](const void* column) { return column == s.first || column == s.second || column == s.image_x || column == s.image_y; };
    for_each_column(s, columns, [&](const char*, const char*, Extent extent, auto*& column, bool present) {
        if (!present || extent != Extent::contacts || is_of_the_list(column)) return;
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
    scratch.found = 0;
    for (int i = 0; i < s.disc_count(); ++i) {
        const std::size_t begin = scratch.found;
        if (linked) find_by_bins(s, bins, i, scratch);
        else find_by_brute_force(s, cell, i, reach, scratch);
        find_old_slots(s, columns, i, begin, scratch);
        sort(scratch.candidates.data() + begin, scratch.candidates.data() + scratch.found);
        if (scratch.found > static_cast<std::size_t>(n.contact_capacity)) return false;
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
