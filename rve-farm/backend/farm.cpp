#include "rve-farm/backend/farm.hpp"

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <type_traits>

#include <fmt/format.h>

#include "common/base/error.hpp"
#include "common/physics/clock.hpp"
#include "common/team/cpu_team.hpp"
#include "rve-farm/assembly/advance.hpp"
#include "rve-farm/assembly/measure.hpp"
#include "rve-farm/assembly/stable_step.hpp"

namespace talik::farm {
namespace {

const ContactLaw<double>& contact_law(const AnyPhysics& physics) {
    return std::visit([](const auto& chosen) -> const ContactLaw<double>& { return chosen.contact; }, physics);
}

void check_step(const Assembly& assembly, const ContactLaw<double>& contact, double time_step, std::size_t packing) {
    if (time_step <= stable_step(omega_squared_bound_of_contacts(assembly.view(), contact))) return;
    const double stable = stable_step(omega_squared_of_contacts(assembly.view(), contact));
    require(time_step <= stable,
            fmt::format("the DEM time step of {:.3g} s is unstable for packing {}", time_step, packing),
            fmt::format("the largest stable step of its contact network is {:.3g} s; take a fraction of it", stable));
}

double bond_strength(const NoBond&, std::span<const double>, std::size_t) { return 0; }
double bond_strength(const BrittleBond<double>& bond, std::span<const double> ice_saturation, std::size_t row) {
    return bond.reduced_strength(ice_saturation.empty() ? 1.0 : ice_saturation[row]); // Eq. (8)
}

template <class Physics>
Answer step_one(Assembly& assembly, const Physics& physics, const MacroStep& step, const FarmOptions& options) {
    AssemblyView& s = assembly.view();
    const ColumnChoice& columns = assembly.columns();
    const Status status = options.shuffle_seed
                              ? advance(ShuffledTeam(*options.shuffle_seed), s, columns, physics, step)
                              : advance(SerialTeam{}, s, columns, physics, step);
    if (status == Status::ok) return measure(s, columns, physics.contact);
    Answer fault;
    fault.status = status;
    if (status == Status::unstable_step)
        fault.largest_stable_step = stable_step(omega_squared_of_contacts(s, physics.contact));
    return fault;
}

} // namespace

Farm::Farm(const RveParameters& parameters, const std::vector<Packing>& packings, const std::vector<int>& packing_of_rve,
           FarmOptions options)
    : parameters_(parameters), options_(std::move(options)), physics_(choose_physics(parameters)) {
    check(parameters);
    if (options_.threads <= 0) options_.threads = omp_get_max_threads();
    std::vector<Assembly> prototypes;
    for (const Packing& packing : packings) {
        prototypes.emplace_back(parameters, packing);
        check_step(prototypes.back(), contact_law(physics_), parameters.time_step, prototypes.size() - 1);
    }
    assemblies_.reserve(packing_of_rve.size());
    for (int packing : packing_of_rve) {
        require(packing >= 0 && packing < static_cast<int>(packings.size()), "an RVE starts from a packing that is not there",
                "number packings from 0 in the order of their file");
        assemblies_.emplace_back(prototypes[static_cast<std::size_t>(packing)]);
    }
}

void Farm::advance(std::span<const std::uint32_t> ids, std::span<const double> increments,
                   std::span<const double> ice_saturation, double time_increment, int substeps, std::span<Answer> answers) {
    ensure(increments.size() == 4 * ids.size() && answers.size() >= ids.size());
    ensure(ice_saturation.empty() || ice_saturation.size() == ids.size());
    require(time_increment > 0, "the time increment of a macro step is not positive", "give it in s");
    for (std::uint32_t id : ids) require(id < assemblies_.size(), "a step asks for an RVE that the farm does not have", "check the ids");
    const int asked = substeps > 0 ? substeps : substeps_of(parameters_, time_increment);
    const int count = static_cast<int>(ids.size());
    const int threads = std::max(1, std::min(options_.threads, count)); // a thread without an RVE would only be waited for
    std::visit(
        [&](const auto& physics) {
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
            for (int k = 0; k < count; ++k) {
                const auto row = static_cast<std::size_t>(k);
                if (!ice_saturation.empty()) rebond(static_cast<int>(ids[row]), ice_saturation[row]);
                const double* g = increments.data() + 4 * row;
                const MacroStep step{g[0], g[1], g[2], g[3], time_increment, asked,
                                     bond_strength(physics.bond, ice_saturation, row)};
                answers[row] = step_one(assemblies_[ids[row]], physics, step, options_);
                rves_done_->fetch_add(1, std::memory_order_relaxed);
                if (options_.on_rve_done) options_.on_rve_done();
            }
        },
        physics_);
}

Assembly& Farm::assembly(int id) {
    ensure(id >= 0 && id < size());
    return assemblies_[static_cast<std::size_t>(id)];
}
const Assembly& Farm::assembly(int id) const {
    ensure(id >= 0 && id < size());
    return assemblies_[static_cast<std::size_t>(id)];
}

Answer Farm::measure(int id) const {
    return farm::measure(assembly(id).view(), assembly(id).columns(), contact_law(physics_));
}

Matrix Farm::cell(int id) const {
    const AssemblyNumbers& n = assembly(id).numbers();
    const double c = std::cos(n.frame_angle), s = std::sin(n.frame_angle); // H = R(theta) H'
    Matrix rotation, cell;
    rotation << c, -s, s, c;
    cell << n.cell_xx, n.cell_xy, n.cell_yx, n.cell_yy;
    return rotation * cell;
}

Packing Farm::packing(int id) const { return assembly(id).packing(parameters_.grain_density); }

double Farm::largest_stable_step(int id) const {
    return stable_step(omega_squared_of_contacts(assembly(id).view(), contact_law(physics_)));
}

void Farm::activate_bonds() {
    for (int id = 0; id < size(); ++id) activate_bonds(id);
}

void Farm::activate_bonds(int id) {
    require(parameters_.bond.has_value(), "bonds are to be activated, but the RVE has none", "give it a [bond] table");
    Assembly& rve = assembly(id);
    AssemblyView& s = rve.view();
    for (int c = 0; c < s.contact_count(); ++c) {
        const bool touching = s.force_x[c] != 0 || s.force_y[c] != 0;
        if (!touching || s.bonded[c] != 0) continue;
        s.bonded[c] = 1;
        ++s.numbers->activated_bonds;
    }
}

void Farm::rebond(int id, double ice_saturation) {
    if (!parameters_.bond || !parameters_.bond->rebond_on_freezing) return;
    std::int64_t& thawed = assembly(id).view().numbers->thawed;
    if (ice_saturation < parameters_.bond->rebond_ice_saturation) {
        thawed = 1;
    } else if (thawed != 0) {
        activate_bonds(id);
        thawed = 0;
    }
}

void Farm::set_friction(double friction) {
    require(friction >= 0, "the friction is negative", "give a coefficient of 0 or more");
    parameters_.contact.friction = friction;
    std::visit([&](auto& physics) { physics.contact.friction = friction; }, physics_);
}

void Farm::reset_velocities(int id) {
    AssemblyView& s = assembly(id).view();
    for (double* column : {s.velocity_x, s.velocity_y, s.spin}) std::fill_n(column, s.disc_count(), 0.0);
}

void Farm::reset_tangential_forces(int id) {
    AssemblyView& s = assembly(id).view();
    for (int c = 0; c < s.contact_count(); ++c) {
        const double ft = s.tangential_force[c];
        if (ft == 0) continue;
        // f = f_n n + f_t t: what is left is f_n n, with |f|^2 = f_n^2 + f_t^2 and f_n = k_n delta.
        const double fn = contact_law(physics_).normal_stiffness * 2 * s.half_overlap[c];
        const double fx = s.force_x[c], fy = s.force_y[c], squared = fn * fn + ft * ft;
        s.force_x[c] = fn * (fn * fx + ft * fy) / squared; // n = (f_n f + f_t (f_y, -f_x)) / |f|^2
        s.force_y[c] = fn * (fn * fy - ft * fx) / squared;
        s.tangential_force[c] = 0;
    }
}

void Farm::save(int id, std::vector<std::byte>& bytes) const { assembly(id).save(bytes); }
std::size_t Farm::load(int id, std::span<const std::byte> bytes) { return assembly(id).load(bytes); }

} // namespace talik::farm
