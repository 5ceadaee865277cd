// Rules of a scene with heat that look at more than one table.
#include <algorithm>

#include "mpm-driver/app/polygon.hpp"
#include "mpm-driver/app/scene_tables.hpp"

namespace talik::driver {

using namespace scene;

namespace {

bool inside(const std::vector<Vector>& polygon, const Vector& x) { // even-odd rule
    bool odd = false;
    for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++)
        if ((polygon[i][1] > x[1]) != (polygon[j][1] > x[1]) &&
            x[0] < polygon[i][0] + (polygon[j][0] - polygon[i][0]) * (x[1] - polygon[i][1]) / (polygon[j][1] - polygon[i][1])) odd = !odd;
    return odd;
}

// Whether a box or line meets a body: a corner inside, or edges that cross.
bool meets(const std::vector<Vector>& outline, const std::vector<Vector>& polygon) {
    for (const Vector& x : outline)
        if (inside(polygon, x)) return true;
    for (const Vector& x : polygon)
        if (outline.size() > 2 && inside(outline, x)) return true;
    for (std::size_t i = 0; i < outline.size(); ++i)
        for (std::size_t j = 0; j < polygon.size(); ++j)
            if (segments_meet(outline[i], outline[(i + 1) % outline.size()], polygon[j], polygon[(j + 1) % polygon.size()])) return true;
    return false;
}

std::vector<Vector> corners(const std::vector<Vector>& box) {
    const Vector low = box[0].cwiseMin(box[1]), high = box[0].cwiseMax(box[1]);
    return {low, Vector(high[0], low[1]), high, Vector(low[0], high[1])};
}

Place item_of(const Place& at, const char* list, std::size_t i) {
    const Value* heat = at.value.find("heat");
    return {heat->find(list)->items[i], fmt::format("heat.{}.{}", list, i), at.faults};
}

void check_bodies(const Scene& scene, const Place& at) {
    const std::vector<Value>& written = at.value.find("body")->items;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        const BodySpec& body = scene.bodies[i];
        const Place place{written[i], fmt::format("body.{}", i), at.faults};
        if (scene.mechanics() && body.law == "none") place.fault("law", "\"none\" is given beside bodies with a law", "in a scene of heat alone no body has one; else give each a law");
        if (!scene.heat) {
            if (body.law == "none") place.fault("law", "\"none\" needs the table [heat]", "add that table, or give the body a law");
            for (const auto& [key, given] : {std::pair{"material", !body.material.empty()}, std::pair{"temperature", body.temperature.has_value()}, std::pair{"temperature_file", !body.temperature_file.empty()}})
                if (given) place.fault(key, "is given in a scene without heat", "add the table [heat], or leave it out");
            continue;
        }
        const auto& materials = scene.heat->materials;
        std::vector<std::string> names;
        for (const ThermalMaterialSpec& m : materials) names.push_back(m.name);
        if (std::find(names.begin(), names.end(), body.material) == names.end())
            place.fault("material", body.material.empty() ? std::string("is missing: a scene with heat needs it") : fmt::format("\"{}\" is no [[heat.material]] of this scene", body.material),
                        fmt::format("give one of: {}", fmt::join(names, ", ")));
        if (body.temperature.has_value() == !body.temperature_file.empty())
            place.fault("temperature", body.temperature ? "is given beside a file" : "is missing: a scene with heat needs that of the start", "give a temperature or a temperature_file");
    }
}

} // namespace

void check_heat(const Scene& scene, const Place& at) {
    check_bodies(scene, at);
    if (!scene.heat) return;
    const HeatSpec& heat = *scene.heat;
    std::vector<std::string> names; // they become columns of the history
    const auto name = [&](const std::string& given, const Place& place) {
        constexpr std::string_view allowed = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";
        if (given.empty() || given.find_first_not_of(allowed) != std::string::npos) place.fault("name", fmt::format("\"{}\" is no name", given), "use letters, digits, _ and -");
        else if (std::find(names.begin(), names.end(), given) != names.end()) place.fault("name", fmt::format("\"{}\" is the name of two causes of heat", given), "give each a name of its own");
        names.push_back(given);
    };
    for (std::size_t i = 0; i < heat.materials.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
            if (heat.materials[j].name == heat.materials[i].name) item_of(at, "material", i).fault("name", fmt::format("\"{}\" is also the name of heat.material.{}", heat.materials[i].name, j), "give each a name of its own");
    for (std::size_t i = 0; i < heat.boundaries.size(); ++i) name(heat.boundaries[i].name, item_of(at, "boundary", i));
    for (std::size_t i = 0; i < heat.heaters.size(); ++i) {
        const HeaterSpec& heater = heat.heaters[i];
        const Place place = item_of(at, "heater", i);
        name(heater.name, place);
        const std::vector<Vector> outline = heater.box.empty() ? heater.line : corners(heater.box);
        if (std::none_of(scene.bodies.begin(), scene.bodies.end(), [&](const BodySpec& body) { return meets(outline, body.polygon); }))
            place.fault(heater.box.empty() ? "line" : "box", "lies outside the ground: no body is there", "put the heater where a body is");
    }
    for (std::size_t i = 0; i < heat.sources.size(); ++i) {
        const HeatSourceSpec& source = heat.sources[i];
        name(source.name, item_of(at, "source", i));
        if (!source.body.empty() && std::none_of(scene.bodies.begin(), scene.bodies.end(), [&](const BodySpec& body) { return body.name == source.body; }))
            item_of(at, "source", i).fault("body", fmt::format("\"{}\" is no body of this scene", source.body), "name one of its bodies");
    }
}

} // namespace talik::driver
