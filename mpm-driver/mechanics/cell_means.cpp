#include "mpm-driver/mechanics/cell_means.hpp"

#include <algorithm>
#include <cmath>

namespace talik::driver {

CellMeans::CellMeans(const Grid& grid, std::size_t point_count)
    : cell_(point_count, 0), volume_(static_cast<std::size_t>(grid.node_count())), mean_(volume_.size()), acting_(point_count) {}

void CellMeans::locate(const Grid& grid, const Points& points) {
    for (std::size_t p = 0; p < points.count(); ++p) { // a cell goes by its lower left node
        const int i = static_cast<int>(std::floor(grid.cells_from_first_node(0, points.position[p][0])));
        const int j = static_cast<int>(std::floor(grid.cells_from_first_node(1, points.position[p][1])));
        cell_[p] = static_cast<std::size_t>(grid.node(i, j));
    }
}

// mean_[c] = sum_p V_p value(p) / sum_p V_p, in the points' order: the same bits for any number of threads.
template <class Value>
void CellMeans::average(const Points& points, Value&& value) {
    std::fill(volume_.begin(), volume_.end(), 0.0);
    std::fill(mean_.begin(), mean_.end(), 0.0);
    for (std::size_t p = 0; p < points.count(); ++p) {
        volume_[cell_[p]] += points.volume[p];
        mean_[cell_[p]] += points.volume[p] * value(p);
    }
    for (std::size_t c = 0; c < mean_.size(); ++c)
        if (volume_[c] > 0.0) mean_[c] /= volume_[c];
}

const std::vector<Stress>& CellMeans::acting_stress(const Points& points) {
    const auto mean_stress = [&](std::size_t p) { return 0.5 * (points.stress[p][0] + points.stress[p][1]); };
    average(points, mean_stress);
    for (std::size_t p = 0; p < points.count(); ++p) {
        const double change = mean_[cell_[p]] - mean_stress(p);
        acting_[p] = {points.stress[p][0] + change, points.stress[p][1] + change, points.stress[p][2]};
    }
    return acting_;
}

void CellMeans::average_volume_strain(Points& points) {
    const auto volume_strain = [&](std::size_t p) { return points.displacement_gradient_increment[p].trace(); };
    average(points, volume_strain);
    for (std::size_t p = 0; p < points.count(); ++p) {
        const double change = 0.5 * (mean_[cell_[p]] - volume_strain(p));
        points.displacement_gradient_increment[p].diagonal().array() += change;
    }
}

} // namespace talik::driver
