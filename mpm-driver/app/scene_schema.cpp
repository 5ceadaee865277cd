#include "mpm-driver/app/scene_schema.hpp"

#include <filesystem>

#include <fmt/format.h>

#include "common/base/error.hpp"
#include "common/io/text_file.hpp"
#include "common/scene/rve_tables.hpp"
#include "mpm-driver/app/scene_tables.hpp"

namespace talik::driver {

using namespace scene;

namespace {

// The file holds the scene, and how its run is kept alive.
struct SceneFile : Scene {
    std::optional<ExchangeSpec> exchange;
};

const Table<SceneFile>& scene_table() {
    static const Table<SceneFile> kept = [] {
        Table<SceneFile> table("What the whole scene shares.");
        table.text("title", &Scene::title, "for plots and the summary")
            .whole<std::uint64_t>("seed", &Scene::seed, any(), "of the scene's random draws")
            .quantity("confining_pressure", &Scene::confining_pressure, Dimension::pressure, not_negative(), "on all free sides, compression positive; follows the material")
            .table<DomainSpec>("domain", &Scene::domain, domain_table())
            .tables<BodySpec>("body", &Scene::bodies, body_table(), required)
            .optional_table<ElasticSpec>("elastic", &Scene::elastic, elastic_table())
            .optional_table<RveSpec>("rve", &Scene::rve, rve_table())
            .optional_table<HeatSpec>("heat", &Scene::heat, heat_table())
            .optional_table<PhaseChangeStrainSpec>("phase_change_strain", &Scene::phase_change_strain, phase_change_strain_table())
            .tables<WallSpec>("wall", &Scene::walls, wall_table())
            .table<StepSpec>("step", &Scene::step, step_table())
            .tables<StageSpec>("stage", &Scene::stages, stage_table(), required)
            .table<OutputSpec>("output", &Scene::output, output_table())
            .optional_table<ExchangeSpec>("exchange", &SceneFile::exchange, exchange_table())
            .check(check_whole_scene);
        return table;
    }();
    return kept;
}

// What lies in the files that a scene names is content of the scene as well; a packing's HDF5 file is not, for the checkpoint
// holds what became of it. What is not there is a fault of its own.
std::string content_of_files(const Scene& scene) {
    std::vector<std::string> files;
    for (const BodySpec& body : scene.bodies) files.push_back(body.temperature_file);
    if (scene.rve) files.insert(files.end(), {scene.rve->packing.particles, scene.rve->packing.contacts});
    if (scene.heat) {
        for (const ThermalMaterialSpec& m : scene.heat->materials) files.insert(files.end(), {m.curve_file, m.conductivity_file});
        for (const HeatBoundarySpec& b : scene.heat->boundaries) files.push_back(b.value.file);
        for (const HeaterSpec& h : scene.heat->heaters) files.push_back(h.value.file);
        for (const HeatSourceSpec& s : scene.heat->sources) files.insert(files.end(), {s.value.file, s.shape_file});
    }
    std::string text;
    std::error_code none;
    for (const std::string& file : files) {
        if (file.empty() || !std::filesystem::is_regular_file(file, none)) continue;
        const std::string content = read_text_file(file);
        text += fmt::format("\n{} bytes\n", content.size()) + content;
    }
    return text;
}

SceneFile read_with_faults(const std::string& file, const std::vector<std::string>& overrides, Faults& faults) {
    Value document = read_document(file);
    for (const auto& override : overrides) apply_override(document, override);
    SceneFile scene;
    scene_table().read(document, "", scene, faults);
    scene.file = file;
    const std::string dump = faults.empty() ? scene_dump(scene) : ""; // before paths are resolved: a moved scene stays the same
    if (scene.heat) resolve_heat_files(scene, document, faults);
    if (const Value* rve = document.find("rve"); rve && scene.rve) resolve_packing_files(scene.rve->packing, file, Place{*rve, "rve", faults});
    if (faults.empty()) scene.hash = fingerprint(dump + content_of_files(scene));
    return scene;
}

std::vector<Section> scene_sections() {
    std::vector<Section> sections;
    scene_table().describe("", sections);
    return sections;
}

} // namespace

Scene read_scene(const std::string& file, const std::vector<std::string>& overrides) {
    Faults faults;
    Scene scene = read_with_faults(file, overrides, faults);
    throw_if_any(faults, "`mpm-driver check` lists them");
    return scene;
}

ExchangeSpec read_exchange(const std::string& file, const std::vector<std::string>& overrides) {
    Faults faults;
    return read_with_faults(file, overrides, faults).exchange.value_or(ExchangeSpec{});
}

std::vector<Fault> check_scene(const std::string& file, const std::vector<std::string>& overrides) {
    Faults faults;
    try {
        read_with_faults(file, overrides, faults);
    } catch (const Error& e) { // syntax, or a wrong --set: nothing more can be said about the rest
        faults.push_back({e.where().empty() ? file : e.where(), "", e.problem(), e.remedy()});
    }
    return faults;
}

std::string scene_help() { return help_text(scene_sections()); }

std::string scene_markdown() {
    return markdown("Scenes",
                    "A scene is a TOML file for `mpm-driver`. Quantities are text with a unit (`\"100 kPa\"`, `\"2.5 mm\"`) or bare numbers in SI; "
                    "stresses are tension positive, pressures compression positive. A table marked *present means on* is an effect: "
                    "without it there is no code on the path and no memory. Any key can be overridden on the command line: "
                    "`--set rve.contact.friction=0.3`, `--set stage.0.duration=\"0.1 s\"`.\n\n"
                    "This page is made from the table of keys that checks scenes (`mpm-driver --help-scene` prints the same); do not edit it by hand.",
                    scene_sections());
}

std::string scene_dump(const Scene& scene) { return scene_table().dump(SceneFile{scene, {}}); }

} // namespace talik::driver
