#include "mpm-driver/app/scene_tables.hpp"

#include <cmath>

#include "mpm-driver/app/polygon.hpp"

namespace talik::driver {

using namespace scene;
using enum Dimension;

namespace {

constexpr double most_cells = 1e8; // about 15 GB of nodes: beyond it a slip of the pen, not a grid
constexpr double highest_speed = 1e4; // m/s, of a body: above the wave speeds of ground

void check_domain(const DomainSpec& d, const Place& at) {
    const double count = (d.size / d.cell).prod();
    if (!(count <= most_cells)) { // before anything is cast to a whole number
        at.fault("cell", fmt::format("{:g} m makes {:.3g} cells of this domain", d.cell, count), fmt::format("take a cell of at least {:.3g} m: at most {:g} cells", std::sqrt(d.size.prod() / most_cells), most_cells));
        return;
    }
    for (int axis = 0; axis < Dim; ++axis) {
        const double cells = d.size[axis] / d.cell;
        if (std::abs(cells - std::round(cells)) > 1e-6 || std::round(cells) < 1.0) // far above rounding, far below a cell
            at.fault("size", fmt::format("its {} of {:g} m is no whole number of cells of {:g} m", axis == 0 ? "width" : "height", d.size[axis], d.cell),
                     fmt::format("take {:g} m", std::max(1.0, std::ceil(cells)) * d.cell));
    }
}

void corners_of_box(std::vector<Vector>& points) {
    const Vector low = points[0].cwiseMin(points[1]), high = points[0].cwiseMax(points[1]);
    points = {low, Vector(high[0], low[1]), high, Vector(low[0], high[1])};
}

void check_body(const BodySpec& b, const Place& at) {
    if (at.has("box") == at.has("polygon")) {
        at.fault("polygon", at.has("box") ? "is given beside a box" : "is missing", "give the body a box or a polygon");
        return;
    }
    const char* outline = at.has("box") ? "box" : "polygon";
    if (std::abs(polygon_area(b.polygon)) <= 0.0) at.fault(outline, "has no area", "give corners that span one");
    else if (!polygon_is_simple(b.polygon)) at.fault(outline, "crosses itself", "give its corners in order along the outline");
    const int side = static_cast<int>(std::lround(std::sqrt(b.points_per_cell)));
    if (side * side != b.points_per_cell) at.fault("points_per_cell", fmt::format("{} is no square", b.points_per_cell), "take 1, 4, 9 or 16");
    if (!(b.velocity.norm() <= highest_speed)) at.fault("velocity", fmt::format("{:g} m/s is no speed of ground", b.velocity.norm()), fmt::format("give at most {:g} m/s", highest_speed));
    if (b.law == "elastic" && !b.density && b.material.empty()) at.fault("density", "is missing", "an elastic body needs its bulk density");
    if (b.law != "elastic" && !b.stress.isZero(0.0)) at.fault("stress", "is given for a body of RVEs", "leave it out: their packings bring their own");
}

// A wall's name becomes a part of column names.
bool is_plain_name(const std::string& name) {
    constexpr std::string_view allowed = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";
    return !name.empty() && name.find_first_not_of(allowed) == std::string::npos;
}

void check_wall(const WallSpec& w, const Place& at) {
    if (!is_plain_name(w.name)) at.fault("name", fmt::format("\"{}\" is no name for a wall", w.name), "use letters, digits, _ and -");
    if (w.friction > 0.0 && w.kind != "roller") at.fault("friction", "is given for a wall that sticks", "take kind = \"roller\", or leave the friction out");
    if (w.ramp > 0.0 && w.velocity == 0.0) at.fault("ramp", "is given for a wall without velocity", "give the velocity, or leave the ramp out");
}

} // namespace

Table<DomainSpec> domain_table() {
    using D = DomainSpec;
    Table<D> table("The background grid of square cells. Walls may stand anywhere in it.");
    table.components("origin", &D::origin, length, any(), "lower left corner")
        .components("size", &D::size, length, positive(), "width and height, whole numbers of cells", required)
        .quantity("cell", &D::cell, length, positive(), "side h of a cell", required)
        .quantity("thickness", &D::thickness, length, between(1e-6, 1e6), "out of the plane (plane strain)")
        .choice("volume_strain", &D::volume_strain, {"point", "cell"}, "of a point: its own, as in the paper, or the mean over its cell (B-bar), against stresses that ring inside a cell")
        .check(check_domain);
    return table;
}

Table<BodySpec> body_table() {
    using B = BodySpec;
    Table<B> table("Bodies: boxes or polygons, filled with points.");
    table.text("name", &B::name, "for messages and output", required)
        .points("box", &B::polygon, length, 2, "two opposite corners", corners_of_box)
        .points("polygon", &B::polygon, length, 0, "corners in order along the outline")
        .choice("law", &B::law, {"rve", "elastic", "none"}, "what answers with stress: an RVE behind each point, linear elasticity, or nothing (scenes of heat alone, all at rest)", required)
        .whole("points_per_cell", &B::points_per_cell, between(1, 16), "1, 4, 9 or 16: the same number along each axis")
        .optional_quantity("density", &B::density, density, between(1, 1e5), "bulk density; without it that of the RVE's discs")
        .components("velocity", &B::velocity, velocity, any(), "at the start")
        .text("material", &B::material, "of heat: the name of a [[heat.material]]")
        .optional_quantity("temperature", &B::temperature, temperature, any(), "at the start")
        .text("temperature_file", &B::temperature_file, "in its place: CSV x_m, y_m, temperature_C on a full rectangular grid")
        .flag("frozen", &B::frozen, "a start at T0 of a sharp front (a ramp of no width) is frozen, not thawed")
        .components("stress", &B::stress, pressure, any(), "at the start, of law \"elastic\": sxx, syy, sxy, tension positive")
        .check(check_body);
    return table;
}

Table<ElasticSpec> elastic_table() {
    using E = ElasticSpec;
    Table<E> table("Linear elasticity in plane strain, for bodies of law \"elastic\".");
    table.quantity("young", &E::young, pressure, positive(), "Young's modulus", required)
        .number("poisson", &E::poisson, {.least = -0.99, .most = 0.499}, "Poisson's ratio", required);
    return table;
}

Table<PhaseChangeStrainSpec> phase_change_strain_table() {
    using P = PhaseChangeStrainSpec;
    Table<P> table("Swelling of ground whose pore water freezes. RVEs and the elastic law are asked for the strain without it.");
    table.number("expansion", &P::expansion, {.least = 0.0, .most = 0.5}, "of water on freezing, relative: ice takes 9 % more room; air in the pores gives way first");
    return table;
}

Table<WallSpec> wall_table() {
    using W = WallSpec;
    Table<W> table("Rigid, flat walls along an axis. They may move and stand between nodes.");
    table.text("name", &W::name, "for `moves` and output", required)
        .choice("side", &W::side, {"left", "right", "bottom", "top"}, "the side of the material that it bounds", required)
        .quantity("position", &W::position, length, any(), "of its face at the start, along its axis", required)
        .choice("kind", &W::kind, {"roller", "fixed"}, "roller: no motion through it; fixed: the material sticks to it")
        .number("friction", &W::friction, not_negative(), "Coulomb friction of a roller")
        .flag("separates", &W::separates, "the material may lift off")
        .quantity("velocity", &W::velocity, velocity, any(), "along its axis (up and right positive), in the stages that list it in `moves`")
        .quantity("ramp", &W::ramp, time, not_negative(), "the velocity grows smoothly from 0 over this time")
        .check(check_wall);
    return table;
}

Table<StageSpec> stage_table() {
    using S = StageSpec;
    Table<S> table("Stages of the run, one after the other.");
    table.text("name", &S::name, "for the log and the output", required)
        .quantity("duration", &S::duration, time, positive(), "at most", required)
        .optional_quantity("energy_ratio", &S::energy_ratio, none, positive(), "ends earlier, once kinetic energy / internal work of the stage stays below this for ten steps; else a warning is given at the end")
        .components("gravity", &S::gravity, acceleration, any(), "gx, gy")
        .quantity("gravity_ramp", &S::gravity_ramp, time, not_negative(), "gravity grows smoothly over this time, from that of the stage before (at the start from zero)")
        .quantity("particle_damping", &S::particle_damping, rate, not_negative(), "alpha_p (Eq. 34)")
        .quantity("grid_damping", &S::grid_damping, rate, not_negative(), "alpha_g (Eq. 34)")
        .number("pic", &S::pic, between(0, 1), "alpha_PIC, fraction of PIC per step (Eq. 34)")
        .texts("moves", &S::moves, {}, "names of the walls that move")
        .texts("activates", &S::activates, {"bonds"}, "switched on at its start")
        .texts("activates_in", &S::activates_in, {}, "names of the bodies in which it is switched on; none = all; a region of the ground is a body of its own");
    return table;
}

Table<StepSpec> step_table() {
    using S = StepSpec;
    Table<S> table("The time step.");
    table.optional_quantity("fixed", &S::fixed, time, positive(), "the last step of a stage is cut to its end; refused where it is beyond the limit of Eq. (42)", "auto")
        .number("safety", &S::safety, {.least = 0.0, .most = 1.0, .above_least = true}, "fraction of the limit taken by \"auto\"");
    return table;
}

Table<OutputSpec> output_table() {
    using O = OutputSpec;
    Table<O> table("What is written, and how often.");
    table.quantity("history_interval", &O::history_interval, time, not_negative(), "rows of history.csv; 0 = every step")
        .quantity("fields_interval", &O::fields_interval, time, not_negative(), "fields of all points; 0 = start and end only")
        .quantity("checkpoint_interval", &O::checkpoint_interval, time, not_negative(), "0 = at the end only");
    return table;
}

Table<ExchangeSpec> exchange_table() {
    using E = ExchangeSpec;
    Table<E> table("What is done about a farm that is lost. Changes no result, and may change at a restart.");
    table.whole("replace_farm", &E::replace_farm, between(0, 1e6), "how many lost farms another one takes over from, to the same bits, before the run ends with exit code 3; 0 = at the first")
        .quantity("replace_interval", &E::replace_interval, time, between(0.1, 1e6), "of wall time, between checkpoints of the farms alone: the work that a lost farm costs at most, with the start of another");
    return table;
}

} // namespace talik::driver
