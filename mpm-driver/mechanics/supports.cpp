#include "mpm-driver/mechanics/supports.hpp"

#include <algorithm>

#include "mpm-driver/grid/parallel.hpp"

namespace talik::driver {

Supports::Supports(const Grid& grid, std::size_t points)
    : row_(grid.nodes(0)), supports_(points), bin_begin_(static_cast<std::size_t>(grid.node_count()) + 1),
      bin_points_(points) {}

void Supports::update(const Grid& grid, const Points& points, const std::vector<double>& half_size) {
    each(points.count(), [&](std::size_t p) {
        const double lambda = half_size[points.body[p]] / grid.cell();
        const auto x = ugimp_weights(grid.cells_from_first_node(0, points.position[p][0]), lambda, grid.cell());
        const auto y = ugimp_weights(grid.cells_from_first_node(1, points.position[p][1]), lambda, grid.cell());
        supports_[p] = {grid.node(x.first_node, y.first_node), x.value, y.value, x.slope, y.slope};
    });
    sort_into_bins();
}

// Counting sort by first node; stable, so that a bin lists its points by id.
void Supports::sort_into_bins() {
    std::fill(bin_begin_.begin(), bin_begin_.end(), 0u);
    for (const Support& s : supports_) ++bin_begin_[s.first_node + 1];
    for (std::size_t bin = 1; bin < bin_begin_.size(); ++bin) bin_begin_[bin] += bin_begin_[bin - 1];
    for (std::size_t p = 0; p < supports_.size(); ++p)
        bin_points_[bin_begin_[supports_[p].first_node]++] = static_cast<std::uint32_t>(p);
    // Each begin has run on to the next bin's: shift back.
    for (std::size_t bin = bin_begin_.size() - 1; bin > 0; --bin) bin_begin_[bin] = bin_begin_[bin - 1];
    bin_begin_[0] = 0;
}

} // namespace talik::driver
