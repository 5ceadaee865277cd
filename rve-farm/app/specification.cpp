#include "rve-farm/app/specification.hpp"

#include "common/scene/rve_tables.hpp"

namespace talik::farm {

using namespace scene;

namespace {

struct PackSpec {
    RveSpec rve;
};

// A packing of the specification must come from something that can be made into one.
void check_rve_is_given(const Place& at) {
    if (!at.has("rve")) at.fault("rve", "is missing", "add the tables [rve.packing] and [rve.contact]");
}

Table<PackSpec> pack_table() {
    Table<PackSpec> table("What `rve-farm pack` prepares: the [rve] tables of a scene.");
    table.table<RveSpec>("rve", &PackSpec::rve, rve_table()).check([](const PackSpec& spec, const Place& at) {
        check_rve_is_given(at);
        if (!spec.rve.packing.file.empty()) at.fault("rve.packing.file", "is given to a preparation", "give void_ratio, or particles in CSV");
        if (spec.rve.packing.k0 && !spec.rve.packing.k0->stress_min) at.fault("rve.packing.k0.stress_min", "is missing", "give stress_min and stress_max: a packing on its own knows no depth");
    });
    return table;
}

void check_test(const ElementTest& test, const Place& at) {
    if (!test.constant_height && test.path != "simple_shear") at.fault("constant_height", "is for simple shear alone", "leave it out");
    if (test.step * test.rate > 0.01) at.fault("step", "moves by more than 1 % in one macro step", "take a smaller step or rate");
}

Table<ElementTest> test_table() {
    using T = ElementTest;
    Table<T> table("The path. Every RVE of the packing goes along it; the curves are written one by one, and as mean and standard deviation.");
    table.choice("path", &T::path, {"isotropic", "biaxial", "isochoric", "simple_shear"},
                 "isotropic: both axes compressed; biaxial: y compressed, lateral stress held; isochoric: y compressed, area constant; simple_shear: along x", required)
        .quantity("rate", &T::rate, Dimension::rate, positive(), "logarithmic strain rate of the compression, or of gamma_xy")
        .number("strain", &T::strain, {.least = 0.0, .most = 5.0, .above_least = true}, "at the end, logarithmic; gamma_xy in simple shear")
        .quantity("pressure", &T::pressure, Dimension::pressure, positive(), "compression positive; held laterally (biaxial), vertically (simple shear), and by `settle`")
        .flag("constant_height", &T::constant_height, "simple shear: height held, else the vertical pressure")
        .quantity("step", &T::step, Dimension::time, positive(), "macro step")
        .whole("rows", &T::rows, between(1, 1000000), "of each curve, evenly spaced")
        .flag("forget_shear_forces", &T::forget_shear_forces, "before loading: tangential forces to zero")
        .flag("settle", &T::settle, "before loading: all stresses to the pressure, until at rest")
        .flag("activate_bonds", &T::activate_bonds, "before loading: bonds at all contacts")
        .number("ice_saturation", &T::ice_saturation, between(0, 1), "S_i, constant (Eq. 8)")
        .check(check_test);
    return table;
}

Table<ElementSpec> element_table() {
    Table<ElementSpec> table("An element test of `rve-farm element`.");
    table.text("title", &ElementSpec::title, "for plots")
        .table<RveSpec>("rve", &ElementSpec::rve, rve_table())
        .table<ElementTest>("test", &ElementSpec::test, test_table())
        .check([](const ElementSpec& spec, const Place& at) {
            check_rve_is_given(at);
            const bool bonds = spec.rve.parameters.bond.has_value();
            if (spec.test.activate_bonds && !bonds) at.fault("test.activate_bonds", "needs the table [rve.bond]", "add that table, or leave this out");
        });
    return table;
}

template <class Spec>
Spec read_specification(const Table<Spec>& table, const std::string& file, const std::vector<std::string>& overrides, std::string& dump) {
    Value document = read_document(file);
    for (const auto& override : overrides) apply_override(document, override);
    Spec spec;
    Faults faults;
    table.read(document, "", spec, faults);
    dump = table.dump(spec);
    if (const Value* rve = document.find("rve")) resolve_packing_files(spec.rve.packing, file, Place{*rve, "rve", faults});
    throw_if_any(faults, "mend this one first");
    return spec;
}

template <class Spec>
std::string help(const Table<Spec>& table) {
    std::vector<Section> sections;
    table.describe("", sections);
    return help_text(sections);
}

} // namespace

RveSpec read_pack_specification(const std::string& file, const std::vector<std::string>& overrides, std::string& dump) {
    return read_specification(pack_table(), file, overrides, dump).rve;
}

ElementSpec read_element_specification(const std::string& file, const std::vector<std::string>& overrides, std::string& dump) {
    return read_specification(element_table(), file, overrides, dump);
}

std::string pack_help() { return help(pack_table()); }
std::string element_help() { return help(element_table()); }

} // namespace talik::farm
