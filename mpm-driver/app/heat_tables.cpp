// The tables of keys of [heat].
#include <algorithm>
#include <array>
#include <filesystem>

#include "common/base/error.hpp"
#include "mpm-driver/app/scene_tables.hpp"
#include "mpm-driver/heat/initial_field.hpp"
#include "mpm-driver/heat/time_value.hpp"
#include "mpm-driver/heat/thermal_material.hpp"

namespace talik::driver {

using namespace scene;
using enum Dimension;

namespace {

const std::vector<std::string> sides = {"left", "right", "bottom", "top"};

void check_material(const ThermalMaterialSpec& m, const Place& at) {
    const bool soil = m.porosity < 1.0;
    if (soil && m.grain_heat_capacity < 0.0) at.fault("grain_heat_capacity", "is missing", "add grain_heat_capacity = ..., of the grains alone");
    if (m.conductivity_file.empty() && soil && m.grain_conductivity < 0.0) at.fault("grain_conductivity", "is missing: a material needs its conductivity", "add grain_conductivity = ..., of the grains alone, or conductivity_file");
    if (m.curve == "ramp" && m.residual_temperature > m.freezing_temperature)
        at.fault("residual_temperature", fmt::format("T_res = {:g} C is above T0 = {:g} C: the freezing curve would not be monotonic", m.residual_temperature, m.freezing_temperature), "give a T_res of at most T0");
    if (m.curve == "table" && m.curve_file.empty()) at.fault("curve", "\"table\" needs curve_file", "give the file, or another curve");
    if (m.curve != "table" && !m.curve_file.empty()) at.fault("curve_file", fmt::format("is given beside curve = \"{}\"", m.curve), "take curve = \"table\", or leave the file out");
    const double xx = m.anisotropy[0], yy = m.anisotropy[1], xy = m.anisotropy[2];
    if (!(xx > 0.0 && yy > 0.0 && xx * yy > xy * xy)) at.fault("anisotropy", fmt::format("[{:g}, {:g}, {:g}] is no conductivity: heat would flow from cold to warm", xx, yy, xy), "give xx, yy > 0 and xy^2 < xx yy");
    if (m.curve != "fine") return;
    if (!soil) at.fault("curve", "\"fine\" needs grains: the porosity is 1", "give a porosity below 1, or another curve");
    else {
        const double all = m.porosity * m.saturation * m.water_density / ((1.0 - m.porosity) * m.grain_density); // mass of water over mass of grains
        const double w0 = m.water_content.value_or(all);
        if (m.residual_water_content > w0)
            at.fault("residual_water_content", fmt::format("{:g} is more than the water content {:.4g} at T0: the freezing curve would not be monotonic", m.residual_water_content, w0), "give less, or a larger water_content");
        else if (m.residual_water_content > all)
            at.fault("residual_water_content", fmt::format("{:g} is more than all the water that the pores hold, {:.4g}", m.residual_water_content, all), "give less, or more porosity or saturation");
    }
}

void check_heater(const HeaterSpec& h, const Place& at) {
    if (h.box.empty() == h.line.empty()) at.fault("box", h.box.empty() ? "is missing" : "is given beside a line", "give a box or a line");
    if (h.begins && h.ends && *h.ends <= *h.begins) at.fault("ends", fmt::format("{:g} s is not after it begins, at {:g} s", *h.ends, *h.begins), "give a later time");
}

// Exactly one of value and file, and a sine only with its period.
void check_value(const TimeValueSpec& v, const std::string& key, const Place& at) {
    if (v.constant.has_value() == !v.file.empty()) at.fault(key, v.file.empty() ? "is missing" : "is given beside a file", "give a value or a file of values in time");
    if ((v.amplitude != 0.0) != (v.period > 0.0)) at.fault("period", v.period > 0.0 ? "is given without an amplitude" : "is missing beside an amplitude", "give both, or neither");
    if (v.amplitude != 0.0 && !v.file.empty()) at.fault("amplitude", "is given beside a file", "leave one of them out");
}

template <class Spec>
void add_value(Table<Spec>& table, const std::string& key, Dimension dimension, const std::string& meaning) {
    const Dimension amplitude = dimension == temperature ? temperature_difference : dimension;
    table.optional_quantity(key, [](Spec& s) -> std::optional<double>& { return s.value.constant; }, dimension, any(), meaning)
        .quantity("amplitude", [](Spec& s) -> double& { return s.value.amplitude; }, amplitude, any(), "of a sine added to it: amplitude sin(2 pi (t - shift) / period)")
        .quantity("period", [](Spec& s) -> double& { return s.value.period; }, time, not_negative(), "of the sine, by heat's clock (time_scale times the scene's); 0 = none")
        .quantity("shift", [](Spec& s) -> double& { return s.value.shift; }, time, any(), "time, of heat's clock, at which the sine rises through zero")
        .text("file", [](Spec& s) -> std::string& { return s.value.file; }, "in place of all these: CSV time_s (of heat's clock), value (SI), straight between its rows; equal times make a jump");
}

Table<ThermalMaterialSpec> material_table() {
    using M = ThermalMaterialSpec;
    Table<M> table("Soil as a mixture of grains, water, ice and air. Fractions refer to the initial volume; masses stay with the points.");
    table.text("name", &M::name, "for the bodies made of it", required)
        .number("porosity", &M::porosity, {.least = 0.0, .most = 1.0, .above_least = true}, "n; 1 = water alone", required)
        .number("saturation", &M::saturation, between(0, 1), "part of the pores that holds water or ice; the rest is air")
        .quantity("grain_density", &M::grain_density, density, positive(), "of the grains alone")
        .quantity("water_density", &M::water_density, density, positive(), "of water")
        .quantity("ice_density", &M::ice_density, density, positive(), "of ice; as the water's, the volume does not change on freezing")
        .quantity("grain_heat_capacity", &M::grain_heat_capacity, heat_capacity, not_negative(), "of the grains; required unless the porosity is 1")
        .quantity("water_heat_capacity", &M::water_heat_capacity, heat_capacity, positive(), "of water")
        .quantity("ice_heat_capacity", &M::ice_heat_capacity, heat_capacity, positive(), "of ice")
        .quantity("grain_conductivity", &M::grain_conductivity, conductivity, positive(), "of the grains; required unless the porosity is 1 or conductivity_file is given")
        .quantity("water_conductivity", &M::water_conductivity, conductivity, positive(), "of water")
        .quantity("ice_conductivity", &M::ice_conductivity, conductivity, positive(), "of ice")
        .quantity("air_conductivity", &M::air_conductivity, conductivity, positive(), "of air, and of what dilation opens")
        .quantity("latent_heat", &M::latent_heat, latent_heat, not_negative(), "L, of melting")
        .choice("conductivity_mean", &M::conductivity_mean, {"geometric", "arithmetic", "harmonic"}, "of the mixture (Eq. 2)")
        .text("conductivity_file", &M::conductivity_file, "in place of the mixture: CSV temperature_C, conductivity_W_per_mK, straight between its rows")
        .components("anisotropy", &M::anisotropy, none, any(), "xx, yy, xy: the conductivity tensor is this times the mixture's conductivity")
        .flag("turns", &M::turns, "the tensor turns with the material; else its axes stay")
        .choice("frozen_water", &M::frozen_water, {"conserves mass", "fills pores"}, "mass: rho_f theta_f + rho_s theta_s stays (Eq. 3); pores: theta_f + theta_s stays (as in InterFrost)")
        .choice("curve", &M::curve, {"ramp", "fine", "saturation", "table", "none"}, "freezing curve: Eqs. (38, 39), (4, 40), (41), curve_file, or water that never freezes")
        .quantity("freezing_temperature", &M::freezing_temperature, temperature, any(), "T0")
        .quantity("residual_temperature", &M::residual_temperature, temperature, any(), "T_res of the ramp; as T0: a sharp front")
        .number("residual_saturation", &M::residual_saturation, {.least = 0.0, .most = 0.999}, "of ramp and saturation curve: the part of the water that stays liquid")
        .quantity("width", &M::width, temperature_difference, positive(), "W of the saturation curve")
        .optional_quantity("water_content", &M::water_content, none, positive(), "w0 of the fine soil, mass of water over mass of grains; without it what the pores hold")
        .number("residual_water_content", &M::residual_water_content, not_negative(), "wbar of the fine soil")
        .number("decay", &M::decay, positive(), "a of the fine soil, 1/K")
        .text("curve_file", &M::curve_file, "of curve \"table\": CSV temperature_C, unfrozen_saturation, from cold to warm, ending with 1")
        .check(check_material);
    return table;
}

Table<HeatBoundarySpec> boundary_table() {
    using B = HeatBoundarySpec;
    Table<B> table("A side of the material, as seen from outside along an axis; it follows the material. Sides without one are adiabatic.");
    table.text("name", &B::name, "for output", required)
        .choice("side", &B::side, sides, "of the material", required)
        .choice("kind", &B::kind, {"temperature", "flux"}, "what `value` is: degrees C, or W/m^2 into the material");
    add_value(table, "value", none, "in degrees C or W/m^2");
    table.optional_quantity("from", &B::from, length, any(), "along the side; without it from its beginning")
        .optional_quantity("to", &B::to, length, any(), "along the side; without it to its end")
        .check([](const B& b, const Place& at) {
            check_value(b.value, "value", at);
            if (b.from && b.to && *b.to <= *b.from) at.fault("to", "is not beyond `from`", "give a larger one");
        });
    return table;
}

Table<HeaterSpec> heater_table() {
    using H = HeaterSpec;
    Table<H> table("Ground held at a temperature: a box, or the nodes within half a cell of a line.");
    table.text("name", &H::name, "for output", required)
        .points("box", &H::box, length, 2, "two opposite corners")
        .points("line", &H::line, length, 2, "its two ends");
    add_value(table, "temperature", temperature, "that it is held at");
    table.optional_quantity("begins", &H::begins, time, any(), "when it is switched on, by the scene's clock (as stages; not scaled by time_scale); without it at the start")
        .optional_quantity("ends", &H::ends, time, any(), "when it is switched off, by the scene's clock; without it never")
        .check([](const H& h, const Place& at) { check_heater(h, at); check_value(h.value, "temperature", at); });
    return table;
}

Table<HeatSourceSpec> source_table() {
    using S = HeatSourceSpec;
    Table<S> table("Heat made in the material.");
    table.text("name", &S::name, "for output", required)
        .text("body", &S::body, "that it acts in; without it in all")
        .points("box", &S::box, length, 2, "two opposite corners: only in points that start inside");
    add_value(table, "power", power_density, "per volume");
    table.text("shape_file", &S::shape_file, "multiplies the power: CSV x_m, y_m, factor on a full rectangular grid")
        .check([](const S& s, const Place& at) { check_value(s.value, "power", at); });
    return table;
}

} // namespace

Table<HeatSpec> heat_table() {
    using H = HeatSpec;
    Table<H> table("Heat with phase change, on the grid and points of the mechanics.");
    table.choice("formulation", &H::formulation, {"enthalpy", "capacity"}, "enthalpy: conserves energy, sharp fronts allowed; capacity: the paper's (A2), to show what it costs")
        .number("stability", &H::stability, at_least(2.0), "b of the step limit C h^2 / (b k) (Eq. 43): 2 is stable where all ground ends on grid lines, 3 where it ends anywhere or moves; a longer fixed step is refused")
        .number("ice_step", &H::ice_step, {.least = 0.0, .most = 1.0, .above_least = true}, "with mechanics: no step of heat is foreseen to change the ice saturation of a point by more than this; a mechanical step is the shortest")
        .number("time_scale", &H::time_scale, positive(), "seconds of heat per second of the scene: scales conductivities, fluxes, sources and the times of their tables together")
        .tables("material", &H::materials, material_table(), required)
        .tables("boundary", &H::boundaries, boundary_table())
        .tables("heater", &H::heaters, heater_table())
        .tables("source", &H::sources, source_table())
        .check([](const H& h, const Place& at) {
            if (h.materials.size() > 8) at.fault("material", fmt::format("{} materials are more than may meet", h.materials.size()), "give at most 8");
            if (h.formulation != "capacity") return;
            for (const ThermalMaterialSpec& m : h.materials)
                if (m.curve == "ramp" && m.residual_temperature == m.freezing_temperature)
                    at.fault("formulation", fmt::format("\"capacity\" cannot freeze material \"{}\", whose ramp has no width", m.name), "give it a residual_temperature below T0, or take \"enthalpy\"");
        });
    return table;
}

double mixture_density(const ThermalMaterialSpec& m) {
    return (1.0 - m.porosity) * m.grain_density + m.porosity * m.saturation * m.water_density;
}

namespace {

// The least b of C h^2 / (b k), Eq. (43), that is stable: 2 where all ground ends on grid lines. A surface that reaches 0.41 of a cell
// beyond a node leaves that node the least volume of all that keep a temperature of their own (find_small_nodes): the largest
// eigenvalue of a row of such nodes is 5.6 k/(C h^2) instead of 4. So 3 where ground ends anywhere, or moves.
double least_b(const Scene& scene) {
    const auto on_grid = [&](const Vector& x) { return ((x - scene.domain.origin) / scene.domain.cell).unaryExpr([](double n) { return std::abs(n - std::round(n)); }).maxCoeff() < 1e-6; };
    const auto ends_on_lines = [&](const BodySpec& body) {
        for (std::size_t i = 0; i < body.polygon.size(); ++i) {
            const Vector edge = body.polygon[(i + 1) % body.polygon.size()] - body.polygon[i];
            if (!on_grid(body.polygon[i]) || (edge[0] != 0.0 && edge[1] != 0.0)) return false;
        }
        return true;
    };
    return !scene.mechanics() && std::all_of(scene.bodies.begin(), scene.bodies.end(), ends_on_lines) ? 2.0 : 3.0;
}

void check_stability(const Scene& scene, const Value& document, Faults& faults) {
    const double least = least_b(scene);
    if (scene.heat->stability >= least) return;
    const Value* heat = document.find("heat");
    const Value* written = heat ? heat->find("stability") : nullptr;
    faults.push_back({written ? written->position : document.position, "heat.stability", fmt::format("{:g} is not stable for ground that ends between grid lines or moves", scene.heat->stability),
                      fmt::format("give at least {:g}", least)});
}

// A fixed step of heat alone (with mechanics heat takes sub-steps of its own).
void check_step(const Scene& scene, const ThermalMaterial& material, const Value& document, Faults& faults) {
    const double b = least_b(scene), largest = 2.0 / b * material.largest_step(scene.domain.cell) / scene.heat->time_scale; // s
    const bool used = std::any_of(scene.bodies.begin(), scene.bodies.end(), [&](const BodySpec& body) { return body.material == material.name(); });
    if (!used || scene.mechanics() || !scene.step.fixed || *scene.step.fixed <= largest * (1.0 + 1e-9)) return;
    faults.push_back({document.find("step")->find("fixed")->position, "step.fixed",
                      fmt::format("{:g} s is beyond the largest stable step of heat in material \"{}\", {:.4g} s (Eq. 43 with b = {:g})", *scene.step.fixed, material.name(), largest, b),
                      fmt::format("use \"auto\", or at most {:.3g} s", b / scene.heat->stability * largest)});
}

} // namespace

void resolve_heat_files(Scene& scene, const Value& document, Faults& faults) {
    const auto folder = std::filesystem::path(scene.file).parent_path();
    const Value* heat = document.find("heat");
    const auto resolve = [&](std::string& file, const Value* place, const std::string& key) {
        if (file.empty()) return;
        file = (folder / file).lexically_normal().string(); // an absolute path stays
        const Value* written = place ? place->find(key.substr(key.rfind('.') + 1)) : nullptr;
        if (!std::filesystem::exists(file)) faults.push_back({written ? written->position : document.position, key, fmt::format("\"{}\" does not exist", file), "mend the path: it is meant relative to the scene"});
    };
    const auto each_of = [&](auto& list, const Value* holder, const std::string& path, const std::string& name, auto&& body) {
        const Value* items = holder ? holder->find(name) : nullptr;
        for (std::size_t i = 0; i < list.size(); ++i)
            body(list[i], items && i < items->items.size() ? &items->items[i] : nullptr, fmt::format("{}{}.{}.", path, name, i));
    };
    each_of(scene.bodies, &document, "", "body", [&](BodySpec& b, const Value* at, const std::string& key) {
        resolve(b.temperature_file, at, key + "temperature_file");
        for (const ThermalMaterialSpec& m : scene.heat->materials)
            if (m.name == b.material && !b.density) b.density = mixture_density(m);
    });
    each_of(scene.heat->materials, heat, "heat.", "material", [&](ThermalMaterialSpec& m, const Value* at, const std::string& key) {
        resolve(m.curve_file, at, key + "curve_file");
        resolve(m.conductivity_file, at, key + "conductivity_file");
    });
    each_of(scene.heat->boundaries, heat, "heat.", "boundary", [&](HeatBoundarySpec& b, const Value* at, const std::string& key) { resolve(b.value.file, at, key + "file"); });
    each_of(scene.heat->heaters, heat, "heat.", "heater", [&](HeaterSpec& h, const Value* at, const std::string& key) { resolve(h.value.file, at, key + "file"); });
    each_of(scene.heat->sources, heat, "heat.", "source", [&](HeatSourceSpec& s, const Value* at, const std::string& key) {
        resolve(s.value.file, at, key + "file");
        resolve(s.shape_file, at, key + "shape_file");
    });
    if (!faults.empty()) return;
    check_stability(scene, document, faults);
    try { // what the tables themselves hold: a curve that is not monotonic, times out of order
        for (const ThermalMaterialSpec& m : scene.heat->materials) check_step(scene, ThermalMaterial(m), document, faults);
        for (const HeatBoundarySpec& b : scene.heat->boundaries) TimeValue(b.value, b.name);
        for (const HeaterSpec& h : scene.heat->heaters) TimeValue(h.value, h.name);
        for (const HeatSourceSpec& s : scene.heat->sources) {
            TimeValue(s.value, s.name);
            if (!s.shape_file.empty()) PlaneTable(s.shape_file, "factor");
        }
        for (const BodySpec& b : scene.bodies)
            if (!b.temperature_file.empty()) PlaneTable(b.temperature_file, "temperature_C");
    } catch (const Error& error) {
        faults.push_back({error.where().empty() ? scene.file : error.where(), "heat", error.problem(), error.remedy()});
    }
}

} // namespace talik::driver
