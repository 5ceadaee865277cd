#include "rve-farm/assembly/assembly.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <string>
#include <tuple>
#include <type_traits>

#include <fmt/format.h>

#include "common/base/error.hpp"
#include "rve-farm/assembly/neighbours.hpp"
#include "rve-farm/physics/physics_choice.hpp"

namespace talik::farm {
namespace {

// Of the mean radius: the first list's, and the range in which it is chosen afterwards (choose_skin).
constexpr double first_skin = 0.03, narrowest_skin = 0.005, widest_skin = 0.3;

// Room for the candidates: discs within reach of one another at random would be (2 + skin/r)^2 / 2 per disc at most
// (half of the area of the neighbourhood over the area of a disc); two more for overlaps and mixtures of sizes.
std::int64_t capacity_for(std::int64_t discs, double skin_over_radius, std::size_t contacts) {
    const double per_disc = 2 + (2 + skin_over_radius) * (2 + skin_over_radius) / 2;
    return static_cast<std::int64_t>(per_disc * static_cast<double>(discs)) + 64 + static_cast<std::int64_t>(contacts);
}

// A contact written from its other end: image turned round; f_t is the same, as t and the force turn both.
PackedContact canonical(PackedContact contact) {
    const bool own_image = contact.first == contact.second;
    const bool turned = own_image ? contact.image[1] < 0 || (contact.image[1] == 0 && contact.image[0] < 0)
                                  : contact.first > contact.second;
    if (!turned) return contact;
    std::swap(contact.first, contact.second);
    contact.image = {-contact.image[0], -contact.image[1]};
    return contact;
}

void check_contact(const PackedContact& contact, int discs) {
    const bool inside = contact.first >= 0 && contact.first < discs && contact.second >= 0 && contact.second < discs;
    require(inside, "a contact of the packing names a disc that is not there", "number discs from 0 in their order");
    require(contact.first != contact.second || contact.image[0] != 0 || contact.image[1] != 0,
            "a contact of the packing joins a disc to itself", "give the image, or leave the contact out");
}

} // namespace

void check(const Packing& packing, const RveParameters& parameters) {
    const std::size_t discs = packing.radius.size();
    require(discs > 0, "the packing has no discs", "prepare it with `rve-farm pack`");
    require(packing.x.size() == discs && packing.y.size() == discs, "the packing's columns differ in length",
            "give x, y and radius for every disc");
    for (const auto* column : {&packing.velocity_x, &packing.velocity_y, &packing.spin})
        require(column->empty() || column->size() == discs, "the packing's columns differ in length",
                "give velocities for every disc, or for none");
    bool meaningful = packing.cell.determinant() > 0 && packing.cell.allFinite();
    for (std::size_t i = 0; i < discs; ++i)
        meaningful = meaningful && packing.radius[i] > 0 && std::isfinite(packing.x[i] + packing.y[i] + packing.radius[i]);
    for (const auto* column : {&packing.velocity_x, &packing.velocity_y, &packing.spin})
        for (double value : *column) meaningful = meaningful && std::isfinite(value);
    for (const PackedContact& contact : packing.contacts) meaningful = meaningful && std::isfinite(contact.tangential_force);
    require(meaningful, "the packing has a radius that is not positive, a cell turned inside out, or numbers that are none (positions, radii, velocities, forces)",
            "columns of the cell matrix are the basis vectors, counter-clockwise");
    const auto same = [](double a, double b) { return std::abs(a - b) <= 1e-9 * std::abs(b); };
    require(same(packing.thickness, parameters.thickness),
            "the packing was made for discs of thickness " + std::to_string(packing.thickness) + " m, the RVE has " +
                std::to_string(parameters.thickness) + " m",
            "give both the same: the stress of a packing is inversely proportional to it");
    require(same(packing.grain_density, parameters.grain_density),
            "the packing was made for grains of " + std::to_string(packing.grain_density) + " kg/m^3, the RVE has " +
                std::to_string(parameters.grain_density) + " kg/m^3",
            "give both the same");
    for (const PackedContact& contact : packing.contacts) check_contact(contact, static_cast<int>(discs));
}

Assembly::Assembly(const RveParameters& parameters, const Packing& packing) : numbers_(std::make_unique<AssemblyNumbers>()) {
    check(packing, parameters);
    columns_ = {parameters.bond.has_value(), parameters.damping > 0, parameters.fluctuation_stress};
    double mean_radius = 0;
    for (double radius : packing.radius) mean_radius += radius / static_cast<double>(packing.disc_count());
    numbers_->mean_radius = mean_radius;
    const bool fixed = parameters.skin > 0;
    const double largest = *std::max_element(packing.radius.begin(), packing.radius.end());
    require(parameters.skin <= 10 * largest, fmt::format("a skin of {:g} m is more than ten times the largest radius, {:g} m", parameters.skin, largest),
            "leave it out, or give less");
    numbers_->skin = fixed ? parameters.skin : first_skin * mean_radius;
    numbers_->narrowest_skin = fixed ? parameters.skin : narrowest_skin * mean_radius;
    numbers_->widest_skin = fixed ? parameters.skin : widest_skin * mean_radius;
    numbers_->thickness = parameters.thickness;
    allocate(packing.disc_count(), capacity_for(packing.disc_count(), numbers_->widest_skin / mean_radius, packing.contacts.size()));
    import_discs(parameters, packing);
    import_contacts(packing);
    const Status built = rebuild_neighbours(view_, columns_);
    require(built != Status::contact_list_full, "the packing's discs overlap too much for a contact list", "start from a looser packing");
    require(built == Status::ok, "a disc of the packing lies millions of cells away", "give positions in or near the cell");
    limit_tangential_forces(contact_law_of(parameters));
}

Assembly::Assembly(const Assembly& other) : columns_(other.columns_), numbers_(std::make_unique<AssemblyNumbers>(*other.numbers_)) {
    allocate(numbers_->disc_count, numbers_->contact_capacity);
    std::vector<std::byte> bytes;
    other.save(bytes);
    load(bytes);
}

void Assembly::allocate(std::int64_t discs, std::int64_t contact_capacity) {
    numbers_->disc_count = discs;
    numbers_->contact_capacity = contact_capacity;
    const auto room = [&](Extent extent) {
        return static_cast<std::size_t>(extent == Extent::contacts ? contact_capacity : discs + (extent == Extent::disc_offsets));
    };
    const auto aligned = [](std::size_t bytes) { return (bytes + 63) / 64 * 64; }; // cache lines, and vectors of any width
    std::size_t bytes = 64;
    for_each_column(view_, columns_, [&](const char*, const char*, Extent extent, auto*& column, bool present) {
        if (present) bytes += aligned(room(extent) * sizeof(*column));
    });
    arena_ = std::make_unique_for_overwrite<std::byte[]>(bytes);
    std::byte* next = begin_ = arena_.get() + (64 - reinterpret_cast<std::uintptr_t>(arena_.get()) % 64) % 64;
    bytes_ = bytes - 64;
    for_each_column(view_, columns_, [&](const char*, const char*, Extent extent, auto*& column, bool present) {
        using Entry = std::remove_reference_t<decltype(*column)>;
        column = present ? reinterpret_cast<Entry*>(next) : nullptr;
        if (!present) return;
        if (extent != Extent::contacts) std::fill_n(column, room(extent), Entry{});
        next += aligned(room(extent) * sizeof(Entry));
    });
    view_.numbers = numbers_.get();
}

void Assembly::import_discs(const RveParameters& parameters, const Packing& packing) {
    AssemblyNumbers& n = *numbers_;
    n.cell_xx = packing.cell(0, 0), n.cell_xy = packing.cell(0, 1);
    n.cell_yx = packing.cell(1, 0), n.cell_yy = packing.cell(1, 1);
    n.largest_radius = *std::max_element(packing.radius.begin(), packing.radius.end());
    n.smallest_radius = *std::min_element(packing.radius.begin(), packing.radius.end());
    const auto value = [](const std::vector<double>& column, std::size_t i) { return column.empty() ? 0.0 : column[i]; };
    for (std::size_t i = 0; i < packing.radius.size(); ++i) {
        const double area = std::numbers::pi * packing.radius[i] * packing.radius[i]; // m^2
        view_.x[i] = packing.x[i];
        view_.y[i] = packing.y[i];
        view_.radius[i] = packing.radius[i];
        view_.mass[i] = parameters.grain_density * area * n.thickness; // rho pi r^2 t, kg
        view_.velocity_x[i] = value(packing.velocity_x, i);
        view_.velocity_y[i] = value(packing.velocity_y, i);
        view_.spin[i] = value(packing.spin, i);
        n.disc_area += area;
    }
}

// As if they were the contacts of a former list: rebuilding carries over what they remember.
void Assembly::import_contacts(const Packing& packing) {
    std::vector<PackedContact> contacts;
    for (const PackedContact& contact : packing.contacts) contacts.push_back(canonical(contact));
    const auto key = [](const PackedContact& c) { return std::tuple(c.first, c.second, c.image[1], c.image[0]); };
    std::sort(contacts.begin(), contacts.end(), [&](const auto& a, const auto& b) { return key(a) < key(b); });
    numbers_->contact_count = static_cast<std::int64_t>(contacts.size());
    for (std::size_t c = 0; c < contacts.size(); ++c) {
        view_.first[c] = contacts[c].first;
        view_.second[c] = contacts[c].second;
        view_.image_x[c] = contacts[c].image[0];
        view_.image_y[c] = contacts[c].image[1];
        view_.tangential_force[c] = contacts[c].tangential_force;
        if (!columns_.bond) continue;
        view_.bonded[c] = contacts[c].bonded;
        numbers_->activated_bonds += contacts[c].bonded;
    }
    index_owned(view_);
}

// A packing may remember more than its positions can bear: f_t is within the Coulomb limit, and zero where nothing touches.
void Assembly::limit_tangential_forces(const ContactLaw<double>& law) {
    for (int c = 0; c < view_.contact_count(); ++c)
        if (!is_bonded(view_, c))
            view_.tangential_force[c] = law.limited({law.normal_stiffness * geometry_of(view_, c).overlap, view_.tangential_force[c]}).tangential;
}

Packing Assembly::packing(double grain_density) const {
    const AssemblyNumbers& n = *numbers_;
    const double c = std::cos(n.frame_angle), s = std::sin(n.frame_angle); // back to fixed axes
    const auto discs = static_cast<std::size_t>(n.disc_count);
    Packing packing;
    packing.thickness = n.thickness;
    packing.grain_density = grain_density;
    packing.cell << c * n.cell_xx - s * n.cell_yx, c * n.cell_xy - s * n.cell_yy, //
        s * n.cell_xx + c * n.cell_yx, s * n.cell_xy + c * n.cell_yy;
    for (std::size_t i = 0; i < discs; ++i) {
        packing.x.push_back(c * view_.x[i] - s * view_.y[i]);
        packing.y.push_back(s * view_.x[i] + c * view_.y[i]);
        packing.velocity_x.push_back(c * view_.velocity_x[i] - s * view_.velocity_y[i]);
        packing.velocity_y.push_back(s * view_.velocity_x[i] + c * view_.velocity_y[i]);
        packing.radius.push_back(view_.radius[i]);
        packing.spin.push_back(view_.spin[i]);
    }
    for (int k = 0; k < view_.contact_count(); ++k) {
        const bool bonded = columns_.bond && view_.bonded[k] != 0;
        if (!carries_force(view_, k)) continue;
        packing.contacts.push_back(
            {view_.first[k], view_.second[k], {view_.image_x[k], view_.image_y[k]}, view_.tangential_force[k], bonded});
    }
    return packing;
}

void Assembly::save(std::vector<std::byte>& bytes) const {
    const auto append = [&](const void* data, std::size_t size) {
        const auto* begin = static_cast<const std::byte*>(data);
        bytes.insert(bytes.end(), begin, begin + size);
    };
    append(numbers_.get(), sizeof(AssemblyNumbers));
    AssemblyView view = view_;
    for_each_column(view, columns_, [&](const char*, const char*, Extent extent, auto*& column, bool present) {
        if (present) append(column, static_cast<std::size_t>(entries(*numbers_, extent)) * sizeof(*column));
    });
}

std::size_t Assembly::load(std::span<const std::byte> bytes) {
    static_assert(std::is_trivially_copyable_v<AssemblyNumbers>);
    const char* remedy = "load it into the scene and build that wrote it";
    std::size_t used = 0;
    const auto take = [&](void* data, std::size_t size) {
        require(size <= bytes.size() - used, "the saved state of an RVE ends too soon", remedy);
        std::memcpy(data, bytes.data() + used, size);
        used += size;
    };
    AssemblyNumbers saved;
    take(&saved, sizeof(saved));
    const bool fits = saved.disc_count == numbers_->disc_count && saved.contact_capacity == numbers_->contact_capacity &&
                      saved.contact_count >= 0 && saved.contact_count <= saved.contact_capacity;
    require(fits, "the saved state is that of an RVE of another size", remedy);
    *numbers_ = saved;
    layout_.forget();
    for_each_column(view_, columns_, [&](const char*, const char*, Extent extent, auto*& column, bool present) {
        if (present) take(column, static_cast<std::size_t>(entries(saved, extent)) * sizeof(*column));
    });
    return used;
}

} // namespace talik::farm
