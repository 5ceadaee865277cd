#include "rve-farm/assembly/lattice_reduction.hpp"

#include <cmath>

#include "rve-farm/assembly/neighbours.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/rve_samples.hpp"

using namespace talik;
using namespace talik::farm;

TEST_CASE("a reduced basis spans the same lattice, and images keep their places", "[cell]") {
    double xx = 1.0, xy = 7.3, yx = 0.1, yy = 1.2;
    const double old_xx = xx, old_xy = xy, old_yx = yx, old_yy = yy;
    const BasisChange change = reduce_basis(xx, xy, yx, yy);
    CHECK(xx * yy - xy * yx == Approx(old_xx * old_yy - old_xy * old_yx));
    CHECK(std::abs(xx * xy + yx * yy) <= 0.56 * std::min(xx * xx + yx * yx, xy * xy + yy * yy)); // half, and the margin
    for (int a = -2; a <= 2; ++a)
        for (int b = -2; b <= 2; ++b) {
            const auto image = change.image(a, b);
            const double ix = static_cast<double>(image[0]), iy = static_cast<double>(image[1]);
            CHECK(xx * ix + xy * iy == Approx(old_xx * a + old_xy * b).margin(1e-12));
            CHECK(yx * ix + yy * iy == Approx(old_yx * a + old_yy * b).margin(1e-12));
        }
}

TEST_CASE("a cell that is not skewed is left alone", "[cell]") {
    double xx = 1, xy = 0.4, yx = 0, yy = 1;
    CHECK(reduce_basis(xx, xy, yx, yy).identity());
}

TEST_CASE("stress and forces are the same before and after each reduction, along a simple shear past gamma = 3", "[cell][eq49]") {
    RveParameters parameters;
    Farm farm(parameters, {samples::disordered(36)}, {0});
    Assembly& rve = farm.assembly(0);
    int reductions = 0;
    for (int k = 0; k < 640; ++k) { // gamma = 3.2
        samples::step(farm, {0, 5e-3, 0, 0}, 5e-3, 500);
        if (k % 8 != 0) continue;
        // The step reduces as soon as it pays; so that a reduction happens here, the basis is first made more skewed:
        // a_2 <- a_2 + a_1, and the images (k_x, k_y) <- (k_x - k_y, k_y), which is the same lattice.
        AssemblyNumbers& n = *rve.view().numbers;
        n.cell_xy += n.cell_xx;
        n.cell_yy += n.cell_yx;
        for (int c = 0; c < rve.view().contact_count(); ++c) rve.view().image_x[c] -= rve.view().image_y[c];
        AssemblyView& s = rve.view();
        const auto forces = [&] { // of the contacts that carry any, in the order of the list, from the branches in the present basis
            std::vector<Vector> list;
            for (int c = 0; c < s.contact_count(); ++c) {
                const ContactGeometry g = geometry_of(s, c);
                if (!(g.overlap > 0)) continue;
                const double fn = parameters.contact.normal_stiffness * g.overlap, ft = s.tangential_force[c];
                list.emplace_back((fn * g.x - ft * g.y) / g.length, (fn * g.y + ft * g.x) / g.length);
            }
            return list;
        };
        const Answer before = farm.measure(0);
        const std::vector<Vector> forces_before = forces();
        const Matrix basis = farm.cell(0);
        REQUIRE(rebuild_neighbours(s, rve.columns()) == Status::ok);
        const std::vector<Vector> forces_after = forces();
        REQUIRE(forces_after.size() == forces_before.size());
        double largest = 0, change = 0;
        for (std::size_t c = 0; c < forces_after.size(); ++c) {
            largest = std::max(largest, forces_before[c].norm());
            change = std::max(change, (forces_after[c] - forces_before[c]).norm());
        }
        const Answer after = farm.measure(0);
        // A branch of 8 mm out of coordinates and images of a 50 mm cell is exact to 1e-17 m, of an overlap of 0.1 mm: 1e-13.
        CHECK(change <= 1e-12 * largest);
        for (std::size_t i = 0; i < 3; ++i)
            CHECK(std::abs(after.stress[i] - before.stress[i]) <= 1e-13 * samples::mean_pressure(before) + 1e-9);
        reductions += (farm.cell(0) - basis).norm() > 1e-9;
    }
    CHECK(reductions == 80); // each time
    CHECK(farm.measure(0).contacts > 0);
    CHECK(rve.numbers().rebuilds > 3);
    const Matrix cell = farm.cell(0);
    CHECK(std::abs(cell.col(0).dot(cell.col(1))) < 0.6 * std::min(cell.col(0).squaredNorm(), cell.col(1).squaredNorm()));
}
