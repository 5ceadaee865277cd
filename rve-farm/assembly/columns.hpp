#pragma once
// The state of one RVE: columns in one arena, and a few numbers. Master state is double.
//
// Seams for the fast kernels, so that they change phases and not the state:
//  - displacement form: at the start of a macro step a contact stores branch and overlap (two more contact columns), and
//    the inner loop carries displacements since then, in float, in columns of their own beside these;
//  - groups of lanes: contacts of one disc are contiguous (owned_begin), so discs can be grouped by how many they own,
//    and `incoming` by in-degree: both are orders of the same list;
//  - the arena of an RVE is one block of bytes: it is loaded to and stored from a GPU's memory as such.
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
    double displacement_bound = 0, strain_bound = 0; // since the list was built: of any disc, m; of any length, -
    double omega_squared_bound = -1; // of the list, every candidate counted as a contact, 1/s^2; negative: not known
    double last_sub_step = 0;    // s; 0 before the first
    double friction_dissipation = 0, bond_dissipation = 0, work = 0; // J, of slots that a rebuild has cleared
    std::int64_t activated_bonds = 0, split_steps = 0, rebuilds = 0; // since the RVE was made
    std::int64_t thawed = 0;     // 1: its ice has fallen below the threshold at which bonds form anew, and not come back
};

struct AssemblyView {
    // discs; positions and velocities in co-rotated axes
    double *x, *y;                   // m
    double *velocity_x, *velocity_y; // v_f, non-affine, half a sub-step behind the positions, m/s
    double* spin;                    // relative to the frame, 1/s
    double *radius, *mass;           // m, kg
    double* damping_dissipation;     // J; only with damping
    double* fluctuation_work;        // J; only with the fluctuation effect
    double* speed_squared;           // of v_f after the last move, m^2/s^2
    // candidate contacts, sorted by (first, second, image); owned by `first`
    std::int32_t *first, *second, *image_x, *image_y; // branch = x_second + H' image - x_first
    double *force_x, *force_y;       // on `second`, N
    double* tangential_force;        // f_t along t = (-n_y, n_x), N
    double* half_overlap;            // delta / 2, m: the lever arm of f_t is r - delta / 2
    double *friction_dissipation, *work; // J, since the list was built
    std::int32_t* bonded;            // 0 or 1; only with bonds
    double* bond_dissipation;        // J; only with bonds
    // who owns and who receives
    std::int32_t *owned_begin, *incoming_begin; // disc_count + 1 offsets
    std::int32_t* incoming;          // contacts whose `second` is the disc, in list order

    AssemblyNumbers* numbers;
    Stretch stretch;    // of the present sub-step, in the frame
    double sub_step = 0; // s
    double kick = 0;     // time over which the forces act on the velocities, s
    double beta = 1;     // beta_b of Eq. (8), -

    TALIK_HOST_DEVICE int disc_count() const { return static_cast<int>(numbers->disc_count); }
    TALIK_HOST_DEVICE int contact_count() const { return static_cast<int>(numbers->contact_count); }
};

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
    visit("damping_dissipation", "J", Extent::discs, s.damping_dissipation, choice.damping);
    visit("fluctuation_work", "J", Extent::discs, s.fluctuation_work, choice.fluctuation);
    visit("speed_squared", "m^2/s^2", Extent::discs, s.speed_squared, true);
    visit("force_x", "N", Extent::contacts, s.force_x, true);
    visit("force_y", "N", Extent::contacts, s.force_y, true);
    visit("tangential_force", "N", Extent::contacts, s.tangential_force, true);
    visit("half_overlap", "m", Extent::contacts, s.half_overlap, true);
    visit("friction_dissipation", "J", Extent::contacts, s.friction_dissipation, true);
    visit("work", "J", Extent::contacts, s.work, true);
    visit("bond_dissipation", "J", Extent::contacts, s.bond_dissipation, choice.bond);
    visit("first", "-", Extent::contacts, s.first, true);
    visit("second", "-", Extent::contacts, s.second, true);
    visit("image_x", "-", Extent::contacts, s.image_x, true);
    visit("image_y", "-", Extent::contacts, s.image_y, true);
    visit("bonded", "-", Extent::contacts, s.bonded, choice.bond);
    visit("incoming", "-", Extent::contacts, s.incoming, true);
    visit("owned_begin", "-", Extent::disc_offsets, s.owned_begin, true);
    visit("incoming_begin", "-", Extent::disc_offsets, s.incoming_begin, true);
}

} // namespace talik::farm
