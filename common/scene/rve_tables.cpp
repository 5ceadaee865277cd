#include "common/scene/rve_tables.hpp"

#include <filesystem>

#include "common/base/version.hpp"

namespace talik::scene {
namespace {

using enum Dimension;

void check_packing(const PackingSpec& p, const Place& at) {
    const int sources = at.has("file") + at.has("particles") + at.has("void_ratio");
    if (sources == 0) at.fault("void_ratio", "is missing", "give void_ratio for a packing to be prepared, or file, or particles");
    if (sources > 1) at.fault(at.has("file") ? "file" : "particles", "is given beside another source of the packing", "give one of file, particles, void_ratio");
    if (at.has("contacts") && !at.has("particles")) at.fault("contacts", "is given without particles", "give the CSV file of the discs as well");
    if (p.k0 && !p.by_specification()) at.fault("k0", "is given for packings from a file", "leave it out: snapshots of a K0 path come with a file of `rve-farm pack`");
    if (p.k0 && p.k0->stress_min && *p.k0->stress_min < p.pressure) at.fault("pressure", fmt::format("{:g} Pa, where the K0 path begins, is above its lowest stress of {:g} Pa", p.pressure, *p.k0->stress_min), "prepare at a lower pressure: a half of the lowest stress or less");
    if (p.radius_max < p.radius_min) at.fault("radius_max", "is smaller than radius_min", "exchange the two");
    if (p.radius_max >= p.radius_min && p.radius_min < p.radius_max / 100.0)
        at.fault("radius_min", "is less than a hundredth of radius_max", "bring the sizes closer: the smallest disc sets the DEM step, the largest the neighbour search");
}

void check_contact(const ContactParameters& c, const Place& at) {
    if (c.tangential_stiffness > 100.0 * c.normal_stiffness)
        at.fault("tangential_stiffness", "is more than 100 times the normal stiffness", "give both in N/m; for grains k_t / k_n is 0.5 to 1");
}

// Rules across the tables of a specification whose discs are still to be made.
void check_preparation(const RveSpec& rve, const Place& at) {
    if (!at.has("packing")) at.fault("packing", "is missing", "add the table [rve.packing] with void_ratio, file or particles");
    if (!at.has("packing") || !rve.packing.by_specification()) return;
    const RveParameters& p = rve.parameters;
    if (p.skin > 10.0 * rve.packing.radius_max) at.fault("skin", fmt::format("{:g} m is more than ten times the largest radius", p.skin), "leave it out, or give less");
    const double overlap = rve.packing.pressure * p.thickness / p.contact.normal_stiffness; // p t / k_n, -: overlap of two discs over their size
    if (overlap > 0.2)
        at.fault("packing", fmt::format("the pressure presses discs into each other by about {:.2g} of their size", overlap), "take a larger contact.normal_stiffness, or a lower pressure or thickness: p t / k_n at most 0.2");
    if (overlap < 1e-9)
        at.fault("packing", fmt::format("the pressure presses discs into each other by only {:.2g} of their size: beyond the precision of positions", overlap), "take a smaller contact.normal_stiffness, or a higher pressure or thickness: p t / k_n at least 1e-9");
}

void check_k0(const K0Spec& k0, const Place& at) {
    if (k0.stress_min.has_value() != k0.stress_max.has_value()) at.fault(k0.stress_min ? "stress_min" : "stress_max", "is given without the other end", "give both, or neither: then they are those of the scene's depths");
    if (k0.stress_min && k0.stress_max && *k0.stress_max < *k0.stress_min) at.fault("stress_max", "is smaller than stress_min", "exchange the two");
}

Table<K0Spec> k0_table() {
    using K = K0Spec;
    Table<K> table("Packings at the stress of their depth: each is compressed without lateral strain from `pressure` on, and kept at rest at a number of vertical stresses; an RVE starts from the one nearest to its depth's.");
    table.whole("levels", &K::levels, between(1, 1000), "vertical stresses at which the packing is kept; as many as there are rows of points make level ground start at rest")
        .choice("spacing", &K::spacing, {"linear", "geometric"}, "of these stresses")
        .optional_quantity("stress_min", &K::stress_min, pressure, positive(), "the lowest, compression positive; left out: that of the shallowest point, at least `pressure`")
        .optional_quantity("stress_max", &K::stress_max, pressure, positive(), "the highest; left out: that of the deepest point under the gravity of the first stage")
        .check(check_k0);
    return table;
}

Table<PackingSpec> packing_table() {
    using P = PackingSpec;
    Table<P> table("The packing that RVEs start from: prepared from a void ratio and a pressure, or read from a file.");
    table.text("file", &P::file, "HDF5 file written by `rve-farm pack`; the path is relative to this file")
        .text("particles", &P::particles, "CSV file of discs (x, y, radius; cell in its first line)")
        .text("contacts", &P::contacts, "CSV file of their contacts, with the tangential forces")
        .whole("discs", &P::discs, between(4, 100000), "discs in an RVE")
        .quantity("radius_min", &P::radius_min, length, between(1e-6, 10), "smallest radius; radii are uniform by number")
        .quantity("radius_max", &P::radius_max, length, between(1e-6, 10), "largest radius")
        .number("void_ratio", &P::void_ratio, {.least = 0.0, .most = 1.0, .above_least = true}, "target, area based: A_cell / sum(pi r^2) - 1")
        .number("void_ratio_tolerance", &P::void_ratio_tolerance, {.least = 1e-6, .most = 0.1}, "largest deviation from the target")
        .quantity("pressure", &P::pressure, Dimension::pressure, positive(), "isotropic pressure it is prepared at, compression positive")
        .whole("seed", &P::seed, any(), "of every random draw")
        .whole("count", &P::count, between(1, 9999), "packings, of seeds seed, seed + 1, ...; dealt out to the RVEs in a seeded random order")
        .template optional_table<K0Spec>("k0", &P::k0, k0_table())
        .check(check_packing);
    return table;
}

Table<ContactParameters> contact_table() {
    using C = ContactParameters;
    Table<C> table("Contacts without bond: linear springs and Coulomb friction (Eqs. 5a-c).");
    table.quantity("normal_stiffness", &C::normal_stiffness, stiffness, between(1e-3, 1e15), "k_n")
        .quantity("tangential_stiffness", &C::tangential_stiffness, stiffness, positive(), "k_t")
        .number("friction", &C::friction, not_negative(), "Coulomb coefficient mu")
        .check(check_contact);
    return table;
}

Table<BondParameters> bond_table() {
    using B = BondParameters;
    Table<B> table("Bonds of ice at contacts (Eqs. 6-8), from the stage on that activates them.");
    table.quantity("normal_strength", &B::normal_strength, pressure, not_negative(), "c_n: a bond breaks in tension beyond beta_b c_n r^2, r the smaller radius")
        .quantity("tangential_strength", &B::tangential_strength, pressure, not_negative(), "c_t: and in shear beyond beta_b c_t r^2")
        .number("strength_factor", &B::strength_factor, not_negative(), "beta_a: beta_b = beta_a S_i, S_i the ice saturation")
        .flag("rebond_on_freezing", &B::rebond_on_freezing, "bonds form anew, at the contacts present, where ground that has thawed freezes again")
        .number("rebond_ice_saturation", &B::rebond_ice_saturation, {.least = 0.0, .most = 1.0, .above_least = true}, "S_i below which an RVE counts as thawed, and at which it bonds anew");
    return table;
}

} // namespace

Table<RveSpec> rve_table() {
    using R = RveSpec;
    Table<R> table("Discrete assemblies (RVEs) behind the points of law \"rve\", computed by rve-farm.");
    table.quantity("grain_density", [](R& r) -> double& { return r.parameters.grain_density; }, density, between(1, 1e5), "of the discs' material")
        .quantity("thickness", [](R& r) -> double& { return r.parameters.thickness; }, length, between(1e-6, 1e6), "t of the discs; sets forces and volumes of an RVE")
        .number("damping", [](R& r) -> double& { return r.parameters.damping; }, {.least = 0.0, .most = 0.99}, "local non-viscous damping of the non-affine motion; 0 = none")
        .flag("fluctuation_stress", [](R& r) -> bool& { return r.parameters.fluctuation_stress; }, "adds the kinetic part -(1/V) sum m v_f v_f to the stress (Eq. 49)")
        .quantity("time_step", [](R& r) -> double& { return r.parameters.time_step; }, time, positive(), "largest DEM sub-step; checked against the stable one")
        .template whole<int>("substeps", [](R& r) -> int& { return r.parameters.substeps; }, between(0, 1000000), "DEM sub-steps per macro step; 0 = from time_step")
        .quantity("skin", [](R& r) -> double& { return r.parameters.skin; }, length, not_negative(), "of the neighbour list; 0 = chosen as it goes, from how fast it is used up")
        .choice("precision", [](R& r) -> std::string& { return r.parameters.precision; }, {"double", "single"}, "of the DEM; single is up to 1.7 times as fast, and within 1e-6 of the pressure per step; the state is double always")
        .template table<PackingSpec>("packing", &R::packing, packing_table())
        .template table<ContactParameters>("contact", [](R& r) -> ContactParameters& { return r.parameters.contact; }, contact_table())
        .template optional_table<BondParameters>("bond", [](R& r) -> std::optional<BondParameters>& { return r.parameters.bond; }, bond_table())
        .check(check_preparation);
    return table;
}

void resolve_packing_files(PackingSpec& packing, const std::string& document_file, const Place& rve) {
    const Value* table = rve.value.find("packing");
    if (!table) return;
    const Place at{*table, joined(rve.key, "packing"), rve.faults};
    const auto resolve = [&](const char* key, std::string& file) {
        if (file.empty()) return;
        const std::filesystem::path path(file);
        const Value* given = table->find(key);
        const bool from_command_line = given && given->position == "--set"; // then meant from where one stands
        if (path.is_relative() && !from_command_line) file = (std::filesystem::path(document_file).parent_path() / path).lexically_normal().string();
        if (!std::filesystem::exists(file)) at.fault(key, "\"" + file + "\" does not exist", "prepare it (rve-farm pack), or mend the path; it is relative to this file");
    };
    resolve("file", packing.file);
    resolve("particles", packing.particles);
    resolve("contacts", packing.contacts);
}

std::string packing_specification(const RveSpec& rve) {
    RveSpec kept = rve;
    kept.parameters = RveParameters(); // bonds, steps and damping are those of the run, not of the preparation
    kept.parameters.contact = rve.parameters.contact;
    kept.parameters.grain_density = rve.parameters.grain_density;
    kept.parameters.thickness = rve.parameters.thickness;
    return "[rve]\n" + rve_table().dump(kept, "rve");
}

std::string packing_fingerprint(const RveSpec& rve) { return fingerprint("packing by " + code_that_packs() + "\n" + packing_specification(rve)); }

} // namespace talik::scene
