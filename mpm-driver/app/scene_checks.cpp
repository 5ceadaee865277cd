// Rules of a scene that look at more than one table.
#include <algorithm>
#include <cmath>

#include "mpm-driver/app/polygon.hpp"
#include "mpm-driver/app/scene_tables.hpp"
#include "mpm-driver/points/seed.hpp"

namespace talik::driver {

using namespace scene;

namespace {

// The table of a list at this place: [[body]] number i.
Place item(const Place& at, const char* list, std::size_t i) {
    return {at.value.find(list)->items[i], fmt::format("{}.{}", list, i), at.faults};
}

void check_law(const Scene& scene, const Place& at, const char* law, bool given) {
    const auto has_law = [&](const BodySpec& b) { return b.law == law; };
    const auto body = std::find_if(scene.bodies.begin(), scene.bodies.end(), has_law);
    if (body != scene.bodies.end() && !given)
        item(at, "body", static_cast<std::size_t>(body - scene.bodies.begin())).fault("law", fmt::format("\"{}\" needs the table [{}]", law, law), "add that table");
    if (body == scene.bodies.end() && given) at.fault(law, "is given, but no body has this law", fmt::format("remove it, or give a body law = \"{}\"", law));
}

void check_bodies(const Scene& scene, const Place& at) {
    const Vector low = scene.domain.origin, high = low + scene.domain.size;
    const double slack = 1e-9 * scene.domain.size.maxCoeff(); // rounding of the input
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        const Place body = item(at, "body", i);
        for (const Vector& corner : scene.bodies[i].polygon)
            if (((corner - low).array() < -slack).any() || ((corner - high).array() > slack).any()) {
                body.fault(body.has("box") ? "box" : "polygon", fmt::format("its corner ({:g}, {:g}) m lies outside the domain", corner[0], corner[1]),
                           fmt::format("the domain reaches from ({:g}, {:g}) to ({:g}, {:g}) m", low[0], low[1], high[0], high[1]));
                break;
            }
        for (std::size_t j = 0; j < i; ++j)
            if (scene.bodies[j].name == scene.bodies[i].name) body.fault("name", fmt::format("\"{}\" is also the name of body.{}", scene.bodies[i].name, j), "give each body a name of its own");
    }
}

const char* outline(const Place& body) { return body.has("box") ? "box" : "polygon"; }

// Where nothing else is wrong, for points are laid out to see it.
void check_points(const Scene& scene, const Place& at) {
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        const BodySpec& body = scene.bodies[i];
        const Place place = item(at, "body", i);
        if (!holds_a_point(body, scene.domain))
            place.fault(outline(place), fmt::format("holds no point: points stand {:g} m apart", 2.0 * point_half_size(body, scene.domain.cell)), "take a smaller cell, more points per cell, or a larger body");
        for (std::size_t j = 0; j < i; ++j)
            if (overlap(body, scene.bodies[j], scene.domain))
                place.fault(outline(place), fmt::format("overlaps body.{} \"{}\": the same ground would be there twice", j, scene.bodies[j].name), "give each body ground of its own");
    }
}

int axis_of(const WallSpec& wall) { return wall.side == "left" || wall.side == "right" ? 0 : 1; }
bool bounds_from_below(const WallSpec& wall) { return wall.side == "left" || wall.side == "bottom"; } // the material's side of smaller coordinate

// A wall reaches without end across its axis: the material of every body lies on one side of it.
void check_cut(const WallSpec& wall, const Scene& scene, const Place& at) {
    const double slack = 1e-9 * scene.domain.cell; // rounding of the input
    for (const BodySpec& body : scene.bodies)
        for (const Vector& corner : body.polygon) {
            const double depth = (bounds_from_below(wall) ? 1.0 : -1.0) * (wall.position - corner[axis_of(wall)]); // m, of the corner behind the wall
            if (depth <= slack) continue;
            at.fault("position", fmt::format("the {} wall at {:g} m cuts through body \"{}\", whose corner ({:g}, {:g}) m lies behind it", wall.side, wall.position, body.name, corner[0], corner[1]),
                     "move the wall to the body's edge or further out, or mend its side");
            return;
        }
}

void check_walls(const Scene& scene, const Place& at) {
    for (std::size_t i = 0; i < scene.walls.size(); ++i) {
        const WallSpec& wall = scene.walls[i];
        const int axis = axis_of(wall);
        const double low = scene.domain.origin[axis], high = low + scene.domain.size[axis], slack = 1e-9 * scene.domain.size[axis];
        if (wall.position < low - slack || wall.position > high + slack)
            item(at, "wall", i).fault("position", fmt::format("{:g} m lies outside the domain", wall.position), fmt::format("give a position in [{:g}, {:g}] m", low, high));
        check_cut(wall, scene, item(at, "wall", i));
        for (const WallSpec& other : scene.walls)
            if (axis_of(other) == axis && bounds_from_below(other) && !bounds_from_below(wall) && wall.position <= other.position)
                item(at, "wall", i).fault("position", fmt::format("the {} wall at {:g} m leaves no room to the {} wall \"{}\" at {:g} m", wall.side, wall.position, other.side, other.name, other.position),
                                          "put it on the other side of that wall");
        for (std::size_t j = 0; j < i; ++j)
            if (scene.walls[j].name == wall.name) item(at, "wall", i).fault("name", fmt::format("\"{}\" is also the name of wall.{}", wall.name, j), "give each wall a name of its own");
    }
}

void check_stages(const Scene& scene, const Place& at) {
    std::vector<std::string> names;
    for (const WallSpec& wall : scene.walls) names.push_back(wall.name);
    for (std::size_t i = 0; i < scene.stages.size(); ++i) {
        const StageSpec& stage = scene.stages[i];
        for (auto moved = stage.moves.begin(); moved != stage.moves.end(); ++moved)
            if (std::find(stage.moves.begin(), moved, *moved) != moved) item(at, "stage", i).fault("moves", fmt::format("names the wall \"{}\" twice", *moved), "name it once");
        if (scene.step.fixed)
            for (const DampingFault& fault : damping_faults(stage, *scene.step.fixed)) item(at, "stage", i).fault(fault.key, fault.problem, fault.remedy);
        for (const std::string& moved : stage.moves) {
            const auto wall = std::find(names.begin(), names.end(), moved);
            if (wall == names.end())
                item(at, "stage", i).fault("moves", fmt::format("\"{}\" is no wall of this scene", moved), names.empty() ? "add a [[wall]] of that name" : fmt::format("its walls are: {}", fmt::join(names, ", ")));
            else if (scene.walls[static_cast<std::size_t>(wall - names.begin())].velocity == 0.0)
                item(at, "stage", i).fault("moves", fmt::format("the wall \"{}\" has no velocity", moved), "give it one in its [[wall]]");
        }
        if (stage.gravity_ramp > stage.duration) item(at, "stage", i).fault("gravity_ramp", fmt::format("{:g} s is longer than the stage", stage.gravity_ramp), "give the stage a longer duration");
        if (stage.activates.empty() && !stage.activates_in.empty())
            item(at, "stage", i).fault("activates_in", "is given for a stage that activates nothing", "add activates = [\"bonds\"], or leave this out");
        for (const std::string& name : stage.activates_in)
            if (std::none_of(scene.bodies.begin(), scene.bodies.end(), [&](const BodySpec& body) { return body.name == name && body.law == "rve"; }))
                item(at, "stage", i).fault("activates_in", fmt::format("\"{}\" is no body of RVEs in this scene", name), "name bodies of law \"rve\"");
        if (!stage.activates.empty() && !(scene.rve && scene.rve->parameters.bond))
            item(at, "stage", i).fault("activates", "\"bonds\" needs the table [rve.bond]", "add that table, or leave this out");
    }
}

// Packings by depth balance the gravity that is there from the first step on.
void check_k0(const Scene& scene, const Place& at) {
    if (!scene.rve || !scene.rve->packing.k0 || scene.rve->packing.k0->stress_min || scene.stages.empty()) return;
    const StageSpec& first = scene.stages.front();
    if (!(first.gravity[1] < 0.0)) item(at, "stage", 0).fault("gravity", "is not downward, but [rve.packing.k0] takes the stress of depth from it", "give it, or give k0 its stress_min and stress_max");
    if (first.gravity_ramp > 0.0) item(at, "stage", 0).fault("gravity_ramp", "is given beside packings that are at the stress of full gravity already", "leave it out, or leave out [rve.packing.k0]");
}

void check_phase_change_strain(const Scene& scene, const Place& at) {
    if (!scene.phase_change_strain) return;
    if (!scene.heat) at.fault("phase_change_strain", "is given in a scene without heat", "add the table [heat], or leave it out");
    if (!scene.mechanics()) at.fault("phase_change_strain", "is given in a scene where nothing moves", "give the bodies a law, or leave it out");
}

} // namespace

std::vector<DampingFault> damping_faults(const StageSpec& stage, double step) {
    std::vector<DampingFault> faults;
    for (const auto& [key, alpha] : {std::pair{"particle_damping", stage.particle_damping}, std::pair{"grid_damping", stage.grid_damping}})
        if (alpha * step >= 1.0)
            faults.push_back({key, fmt::format("{:g} 1/s times the step of {:g} s is {:.3g}: at 1 and above a step does not damp but turn the motion round", alpha, step, alpha * step),
                              fmt::format("give less than {:.3g} 1/s, or take a smaller step", 1.0 / step)});
    return faults;
}

void check_whole_scene(const Scene& scene, const Place& at) {
    check_law(scene, at, "elastic", scene.elastic.has_value());
    check_law(scene, at, "rve", scene.rve.has_value());
    check_bodies(scene, at);
    check_heat(scene, at);
    check_walls(scene, at);
    check_stages(scene, at);
    check_k0(scene, at);
    check_phase_change_strain(scene, at);
    if (at.faults.empty()) check_points(scene, at);
}

std::vector<std::string> seeding_warnings(const Scene& scene) {
    std::vector<std::string> warnings;
    for (const BodySpec& body : scene.bodies) {
        const double wanted = std::abs(polygon_area(body.polygon));
        if (wanted > 1e6 * scene.domain.cell * scene.domain.cell) continue; // so many cells follow any outline, and take long to count
        const double got = area_of_points(body, scene.domain), spacing = 2.0 * point_half_size(body, scene.domain.cell); // m^2, m
        if (std::abs(got - wanted) > 0.01 * wanted)
            warnings.push_back(fmt::format("body \"{}\": its outline encloses {:.4g} m2, its points stand for {:.4g} m2 ({:+.1f} %), and so does its mass: make it a whole number of point spacings of {:g} m, or take a smaller cell",
                                           body.name, wanted, got, 100.0 * (got / wanted - 1.0), spacing));
    }
    return warnings;
}

} // namespace talik::driver
