#pragma once
// The state of one RVE: columns in one arena, and a few numbers. Master state is double, whatever the kernels compute in;
// what follows from positions (branches, overlaps, normal forces) is not stored.
#include <cstdint>

#include "rve-farm/assembly/stretch.hpp"

namespace talik::farm {

// Only 8-byte members: written to checkpoints as it is.
struct AssemblyNumbers {
    std::int64_t disc_count = 0, contact_count = 0, contact_capacity = 0;
    double cell_xx = 0, cell_xy = 0, cell_yx = 0, cell_yy = 0; // H' in co-rotated axes, columns are basis vectors, m
    double frame_angle = 0;      // theta, rad: fixed axes = R(theta) co-rotated axes
    double lost_xx = 0, lost_xy = 0, lost_yx = 0, lost_yy = 0, lost_angle = 0; // what rounding has kept from the five above
    double thickness = 0;        // m
    double disc_area = 0;        // sum pi r^2, m^2
    double largest_radius = 0, smallest_radius = 0, mean_radius = 0; // m
    double skin = 0;             // of the neighbour list, m
    double narrowest_skin = 0, widest_skin = 0; // between which it is chosen at every rebuild, m
    double displacement_bound = 0, strain_bound = 0; // since the list was built: of any disc, m; of any length, -
    double last_displacement = 0; // largest non-affine displacement per sub-step in the last chunk, m
    double list_substeps = 0;    // sub-steps taken on the present list
    double omega_squared_bound = -1; // of the list, every candidate counted as a contact, 1/s^2; negative: not known
    double last_sub_step = 0;    // s; 0 before the first
    double friction_dissipation = 0, bond_dissipation = 0, damping_dissipation = 0, work = 0; // since the RVE was made, J
    std::int64_t activated_bonds = 0, split_steps = 0, rebuilds = 0, retaken_chunks = 0; // since the RVE was made
    std::int64_t thawed = 0;     // 1: its ice has fallen below the threshold at which bonds form anew, and not come back
};

struct AssemblyView {
    // discs; positions and velocities in co-rotated axes
    double *x, *y;                   // m
    double *velocity_x, *velocity_y; // v_f, non-affine, half a sub-step behind the positions, m/s
    double* spin;                    // relative to the frame, 1/s
    double *radius, *mass;           // m, kg
    double *drift_x, *drift_y;       // non-affine displacement since the list was built, carried along by the cell, m
    // candidate contacts, sorted by (first, second, image)
    std::int32_t *first, *second, *image_x, *image_y; // branch = x_second + H' image - x_first
    double* tangential_force;        // f_t on `second` along t = (-n_y, n_x), N
    std::int32_t* bonded;            // 0 or 1; only with bonds
    std::int32_t* owned_begin;       // of each disc as `first`, disc_count + 1 offsets

    AssemblyNumbers* numbers;

    TALIK_HOST_DEVICE int disc_count() const { return static_cast<int>(numbers->disc_count); }
    TALIK_HOST_DEVICE int contact_count() const { return static_cast<int>(numbers->contact_count); }
};

// One component of the branch from one disc to the image of another, m.
template <class Real>
TALIK_HOST_DEVICE Real branch_component(Real from, Real to, Real first_column, Real second_column, Real image_x, Real image_y) {
    return to - from + (first_column * image_x + second_column * image_y);
}

// Where a contact stands, from the positions.
struct ContactGeometry {
    double x, y, length, overlap; // branch, its length, delta = r_i + r_j - |b|: m
};
TALIK_HOST_DEVICE ContactGeometry geometry_of(const AssemblyView& s, int c) {
    const AssemblyNumbers& n = *s.numbers;
    const int i = s.first[c], j = s.second[c];
    const double image_x = s.image_x[c], image_y = s.image_y[c];
    const double x = branch_component(s.x[i], s.x[j], n.cell_xx, n.cell_xy, image_x, image_y);
    const double y = branch_component(s.y[i], s.y[j], n.cell_yx, n.cell_yy, image_x, image_y);
    const double length = std::sqrt(x * x + y * y);
    return {x, y, length, s.radius[i] + s.radius[j] - length};
}

TALIK_HOST_DEVICE bool is_bonded(const AssemblyView& s, int c) { return s.bonded && s.bonded[c] != 0; }
// A candidate carries force where its discs overlap, or a bond holds them.
TALIK_HOST_DEVICE bool carries_force(const AssemblyView& s, int c) { return is_bonded(s, c) || geometry_of(s, c).overlap > 0; }

enum class Extent { discs, disc_offsets, contacts };

// What an RVE holds depends on the effects that are on: an absent effect has no column.
struct ColumnChoice {
    bool bond = false, damping = false, fluctuation = false;
};

// The one column list: serves allocation, checkpoint, reordering and comparison in tests.
// visit(name, unit, extent, pointer, present)
template <class Visitor>
void for_each_column(AssemblyView& s, const ColumnChoice& choice, Visitor&& visit) {
    visit("x", "m", Extent::discs, s.x, true);
    visit("y", "m", Extent::discs, s.y, true);
    visit("velocity_x", "m/s", Extent::discs, s.velocity_x, true);
    visit("velocity_y", "m/s", Extent::discs, s.velocity_y, true);
    visit("spin", "1/s", Extent::discs, s.spin, true);
    visit("radius", "m", Extent::discs, s.radius, true);
    visit("mass", "kg", Extent::discs, s.mass, true);
    visit("drift_x", "m", Extent::discs, s.drift_x, true);
    visit("drift_y", "m", Extent::discs, s.drift_y, true);
    visit("tangential_force", "N", Extent::contacts, s.tangential_force, true);
    visit("first", "-", Extent::contacts, s.first, true);
    visit("second", "-", Extent::contacts, s.second, true);
    visit("image_x", "-", Extent::contacts, s.image_x, true);
    visit("image_y", "-", Extent::contacts, s.image_y, true);
    visit("bonded", "-", Extent::contacts, s.bonded, choice.bond);
    visit("owned_begin", "-", Extent::disc_offsets, s.owned_begin, true);
}

} // namespace talik::farm
