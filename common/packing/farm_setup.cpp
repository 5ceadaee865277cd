#include "common/packing/farm_setup.hpp"

#include <string>

#include "common/base/error.hpp"
#include "common/io/byte_stream.hpp"

namespace talik {
namespace {

constexpr std::uint32_t setup_version = 4;

void put_parameters(ByteWriter& out, const RveParameters& p) {
    out.put(p.contact.normal_stiffness);
    out.put(p.contact.tangential_stiffness);
    out.put(p.contact.friction);
    out.put(static_cast<std::uint8_t>(p.bond.has_value()));
    const BondParameters bond = p.bond.value_or(BondParameters{});
    out.put(bond.normal_strength);
    out.put(bond.tangential_strength);
    out.put(bond.strength_factor);
    out.put(static_cast<std::uint8_t>(bond.rebond_on_freezing));
    out.put(bond.rebond_ice_saturation);
    out.put(p.grain_density);
    out.put(p.thickness);
    out.put(p.damping);
    out.put(static_cast<std::uint8_t>(p.fluctuation_stress));
    out.put(p.time_step);
    out.put(static_cast<std::int32_t>(p.substeps));
    out.put(p.skin);
    out.text(p.precision);
}

RveParameters get_parameters(ByteReader& in) {
    RveParameters p;
    p.contact.normal_stiffness = in.get<double>();
    p.contact.tangential_stiffness = in.get<double>();
    p.contact.friction = in.get<double>();
    const bool bonded = in.get<std::uint8_t>() != 0;
    BondParameters bond;
    bond.normal_strength = in.get<double>();
    bond.tangential_strength = in.get<double>();
    bond.strength_factor = in.get<double>();
    bond.rebond_on_freezing = in.get<std::uint8_t>() != 0;
    bond.rebond_ice_saturation = in.get<double>();
    if (bonded) p.bond = bond;
    p.grain_density = in.get<double>();
    p.thickness = in.get<double>();
    p.damping = in.get<double>();
    p.fluctuation_stress = in.get<std::uint8_t>() != 0;
    p.time_step = in.get<double>();
    p.substeps = in.get<std::int32_t>();
    p.skin = in.get<double>();
    p.precision = in.text();
    return p;
}

void put_packing(ByteWriter& out, const Packing& packing) {
    for (int i = 0; i < 4; ++i) out.put(packing.cell.data()[i]);
    out.put(packing.thickness);
    out.put(packing.grain_density);
    out.put(packing.pressure);
    out.put(packing.vertical_stress);
    out.put(packing.lateral_stress);
    out.put(packing.seed);
    for (const auto* column : {&packing.x, &packing.y, &packing.radius, &packing.velocity_x, &packing.velocity_y, &packing.spin})
        out.array(*column);
    out.put(static_cast<std::uint64_t>(packing.contacts.size()));
    for (const PackedContact& contact : packing.contacts) {
        out.put(static_cast<std::int32_t>(contact.first));
        out.put(static_cast<std::int32_t>(contact.second));
        out.put(static_cast<std::int32_t>(contact.image[0]));
        out.put(static_cast<std::int32_t>(contact.image[1]));
        out.put(contact.tangential_force);
        out.put(static_cast<std::uint8_t>(contact.bonded));
    }
}

Packing get_packing(ByteReader& in) {
    Packing packing;
    for (int i = 0; i < 4; ++i) packing.cell.data()[i] = in.get<double>();
    packing.thickness = in.get<double>();
    packing.grain_density = in.get<double>();
    packing.pressure = in.get<double>();
    packing.vertical_stress = in.get<double>();
    packing.lateral_stress = in.get<double>();
    packing.seed = in.get<std::uint64_t>();
    for (auto* column : {&packing.x, &packing.y, &packing.radius, &packing.velocity_x, &packing.velocity_y, &packing.spin})
        *column = in.array<double>();
    const auto contacts = in.get<std::uint64_t>();
    for (std::uint64_t i = 0; i < contacts; ++i) { // grows as it reads: a false count ends as a named error
        PackedContact contact;
        contact.first = in.get<std::int32_t>();
        contact.second = in.get<std::int32_t>();
        contact.image = {in.get<std::int32_t>(), 0};
        contact.image[1] = in.get<std::int32_t>();
        contact.tangential_force = in.get<double>();
        contact.bonded = in.get<std::uint8_t>() != 0;
        packing.contacts.push_back(contact);
    }
    return packing;
}

void check(const FarmSetup& setup) {
    const auto sound = [](bool holds, const std::string& problem) {
        if (!holds) fail(ExitCode::bad_input, "farm setup: " + problem, "both programs must come from the same version of Talik");
    };
    for (const Packing& packing : setup.packings) {
        const std::size_t discs = packing.radius.size();
        sound(discs > 0 && packing.x.size() == discs && packing.y.size() == discs, "a packing's columns differ in length");
        for (const PackedContact& c : packing.contacts)
            sound(c.first >= 0 && c.second >= 0 && static_cast<std::size_t>(std::max(c.first, c.second)) < discs,
                  "a contact names a disc that is not there");
    }
    sound(setup.ids.empty() || setup.ids.size() == setup.packing_of_rve.size(), "not every RVE has an id");
    for (int index : setup.packing_of_rve)
        sound(index >= 0 && static_cast<std::size_t>(index) < setup.packings.size(), "an RVE names a packing that is not there");
}

} // namespace

std::vector<std::byte> encode(const FarmSetup& setup) {
    ByteWriter out;
    out.put(setup_version);
    put_parameters(out, setup.parameters);
    out.put(static_cast<std::uint32_t>(setup.packings.size()));
    for (const Packing& packing : setup.packings) put_packing(out, packing);
    out.array(setup.packing_of_rve);
    out.array(setup.ids);
    return out.take();
}

FarmSetup decode_farm_setup(std::span<const std::byte> bytes) {
    ByteReader in(bytes, "configure");
    require(in.get<std::uint32_t>() == setup_version, "farm setup: another version", "use mpm-driver and rve-farm of one version");
    FarmSetup setup;
    setup.parameters = get_parameters(in);
    const auto packings = in.get<std::uint32_t>();
    for (std::uint32_t i = 0; i < packings; ++i) setup.packings.push_back(get_packing(in));
    setup.packing_of_rve = in.array<int>();
    setup.ids = in.array<std::uint32_t>();
    in.finish();
    check(setup);
    return setup;
}

} // namespace talik
