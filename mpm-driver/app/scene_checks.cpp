// Rules of a scene that look at more than one table.
#include <algorithm>

#include "mpm-driver/app/scene_tables.hpp"

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
    }
}

void check_walls(const Scene& scene, const Place& at) {
    for (std::size_t i = 0; i < scene.walls.size(); ++i) {
        const WallSpec& wall = scene.walls[i];
        const int axis = wall.side == "left" || wall.side == "right" ? 0 : 1;
        const double low = scene.domain.origin[axis], high = low + scene.domain.size[axis], slack = 1e-9 * scene.domain.size[axis];
        if (wall.position < low - slack || wall.position > high + slack)
            item(at, "wall", i).fault("position", fmt::format("{:g} m lies outside the domain", wall.position), fmt::format("give a position in [{:g}, {:g}] m", low, high));
        for (std::size_t j = 0; j < i; ++j)
            if (scene.walls[j].name == wall.name) item(at, "wall", i).fault("name", fmt::format("\"{}\" is also the name of wall.{}", wall.name, j), "give each wall a name of its own");
    }
}

void check_stages(const Scene& scene, const Place& at) {
    std::vector<std::string> names;
    for (const WallSpec& wall : scene.walls) names.push_back(wall.name);
    for (std::size_t i = 0; i < scene.stages.size(); ++i) {
        const StageSpec& stage = scene.stages[i];
        for (const std::string& moved : stage.moves) {
            const auto wall = std::find(names.begin(), names.end(), moved);
            if (wall == names.end())
                item(at, "stage", i).fault("moves", fmt::format("\"{}\" is no wall of this scene", moved), names.empty() ? "add a [[wall]] of that name" : fmt::format("its walls are: {}", fmt::join(names, ", ")));
            else if (scene.walls[static_cast<std::size_t>(wall - names.begin())].velocity == 0.0)
                item(at, "stage", i).fault("moves", fmt::format("the wall \"{}\" has no velocity", moved), "give it one in its [[wall]]");
        }
        if (!stage.activates.empty() && !(scene.rve && scene.rve->parameters.bond))
            item(at, "stage", i).fault("activates", "\"bonds\" needs the table [rve.bond]", "add that table, or leave this out");
    }
}

} // namespace

void check_whole_scene(const Scene& scene, const Place& at) {
    check_law(scene, at, "elastic", scene.elastic.has_value());
    check_law(scene, at, "rve", scene.rve.has_value());
    check_bodies(scene, at);
    check_walls(scene, at);
    check_stages(scene, at);
}

} // namespace talik::driver
