#include "rve-farm/backend/farm.hpp"

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "common/physics/clock.hpp"
#include "rve-farm/assembly/stable_step.hpp"
#include "rve-farm/physics/physics_choice.hpp"

namespace talik::farm {
namespace {

void check_step(const Assembly& assembly, const RveParameters& parameters, std::size_t packing) {
    const ContactLaw<double> contact = contact_law_of(parameters);
    const double time_step = parameters.time_step, shortening = shortening_by_damping(parameters.damping);
    if (time_step <= stable_step(omega_squared_bound_of_contacts(assembly.view(), contact)) / shortening) return;
    const double stable = stable_step(omega_squared_of_contacts(assembly.view(), contact)) / shortening;
    require(time_step <= stable,
            fmt::format("the DEM time step of {:.3g} s is unstable for packing {}", time_step, packing),
            fmt::format("the largest stable step of its contact network is {:.4g} s; take a fraction of it", stable));
}

const Kernel& kernel_of(const FarmOptions& options, const RveParameters& parameters) {
    const Precision asked = parameters.precision == "single" ? Precision::single_ : Precision::double_;
    return farm::kernel(options.level.value_or(best_level()), options.precision.value_or(asked));
}

} // namespace

Farm::Farm(const RveParameters& parameters, const std::vector<Packing>& packings, const std::vector<int>& packing_of_rve,
           FarmOptions options)
    : options_(std::move(options)), stepper_{parameters, &kernel_of(options_, parameters), options_.ledger, options_.shuffle_seed, options_.smaller_sub_steps} {
    check(parameters);
    if (options_.threads <= 0) options_.threads = omp_get_max_threads();
    if (options_.time_stages) stages_.resize(static_cast<std::size_t>(options_.threads));
    std::vector<Assembly> prototypes;
    for (const Packing& packing : packings) {
        prototypes.emplace_back(parameters, packing);
        check_step(prototypes.back(), parameters, prototypes.size() - 1);
    }
    assemblies_.reserve(packing_of_rve.size());
    for (int packing : packing_of_rve) {
        require(packing >= 0 && packing < static_cast<int>(packings.size()), "an RVE starts from a packing that is not there",
                "number packings from 0 in the order of their file");
        assemblies_.emplace_back(prototypes[static_cast<std::size_t>(packing)]);
    }
    choose_backend();
}

void require_gpu(Backend backend) {
    if (backend != Backend::cuda) return;
    const Gpus gpus = open_gpus();
    if (gpus.devices.empty()) fail(ExitCode::out_of_resource, "--backend cuda: " + gpus.reason, "use --backend cpu, or auto");
}

// A block takes a few microseconds for a sub-step however many there are beside it, a core some two: below a few RVEs to a core
// a GPU gains nothing.
void Farm::choose_backend() {
    constexpr int rves_of_a_thread_worth_a_gpu = 4;
    Gpus gpus{options_.devices, ""};
    if (gpus.devices.empty() && options_.backend == Backend::cpu) return;
    if (gpus.devices.empty() && options_.backend == Backend::automatic) {
        if (!built_with_cuda() || size() < rves_of_a_thread_worth_a_gpu * options_.threads) return;
        gpus = open_gpus();
        if (gpus.devices.empty()) log::info("no GPU to compute on ({}): the CPU does it", gpus.reason);
        if (gpus.devices.empty()) return;
    }
    if (gpus.devices.empty()) {
        require_gpu(Backend::cuda);
        gpus = open_gpus();
    }
    try {
        if (size() > 0) blocks_ = std::make_unique<BlockFarm>(stepper_, assemblies_, gpus.devices, options_.threads);
    } catch (const Error& problem) { // too little memory
        if (options_.backend != Backend::automatic || !options_.devices.empty()) throw;
        log::warn("{}: the CPU does it", problem.problem());
        return;
    }
    backend_in_words_ = gpus.devices.front()->name();
    if (gpus.devices.size() > 1) backend_in_words_ = fmt::format("{} GPUs, the first of them {}", gpus.devices.size(), backend_in_words_);
}

void Farm::advance(std::span<const std::uint32_t> ids, std::span<const double> increments,
                   std::span<const double> ice_saturation, double time_increment, int substeps, std::span<Answer> answers) {
    ensure(increments.size() == 4 * ids.size() && answers.size() >= ids.size());
    ensure(ice_saturation.empty() || ice_saturation.size() == ids.size());
    require(time_increment > 0, "the time increment of a macro step is not positive", "give it in s");
    for (std::uint32_t id : ids) require(id < assemblies_.size(), "a step asks for an RVE that the farm does not have", "check the ids");
    const int asked = substeps > 0 ? substeps : substeps_of(parameters(), time_increment);
    const int count = static_cast<int>(ids.size());
    const int threads = std::max(1, std::min(options_.threads, count)); // a thread without an RVE would only be waited for
    if (blocks_) {
        std::vector<MacroStep> steps(ids.size());
        for (std::size_t row = 0; row < ids.size(); ++row) {
            if (!ice_saturation.empty()) rebond(static_cast<int>(ids[row]), ice_saturation[row]);
            const double* g = increments.data() + 4 * row;
            steps[row] = {g[0], g[1], g[2], g[3], time_increment, asked, beta(ice_saturation, row)};
        }
        blocks_->advance(stepper_, assemblies_, ids, steps, answers, [this] {
            rves_done_->fetch_add(1, std::memory_order_relaxed);
            if (options_.on_rve_done) options_.on_rve_done();
        });
        return;
    }
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
    for (int k = 0; k < count; ++k) {
        const auto row = static_cast<std::size_t>(k);
        if (!ice_saturation.empty()) rebond(static_cast<int>(ids[row]), ice_saturation[row]);
        const double* g = increments.data() + 4 * row;
        answers[row] = farm::advance(stepper_, assemblies_[ids[row]], {g[0], g[1], g[2], g[3], time_increment, asked, beta(ice_saturation, row)},
                                    stages_.empty() ? nullptr : &stages_[static_cast<std::size_t>(omp_get_thread_num())]);
        rves_done_->fetch_add(1, std::memory_order_relaxed);
        if (options_.on_rve_done) options_.on_rve_done();
    }
}

StageSeconds Farm::stages() const {
    StageSeconds sum;
    if (blocks_) sum.rebuild = blocks_->rebuild_seconds();
    for (const StageSeconds& s : stages_) sum.load += s.load, sum.inner += s.inner, sum.close += s.close, sum.rebuild += s.rebuild;
    return sum;
}

Assembly& Farm::assembly(int id) {
    std::as_const(*this).assembly(id);
    if (blocks_) blocks_->changed(id);
    return assemblies_[static_cast<std::size_t>(id)];
}
const Assembly& Farm::assembly(int id) const {
    ensure(id >= 0 && id < size());
    if (blocks_) blocks_->fetch(assemblies_[static_cast<std::size_t>(id)], id);
    return assemblies_[static_cast<std::size_t>(id)];
}

const AssemblyNumbers& Farm::numbers(int id) const { return assemblies_.at(static_cast<std::size_t>(id)).numbers(); }

Answer Farm::measure(int id) const { return farm::measure(stepper_, assembly(id)); }

Matrix Farm::cell(int id) const {
    const AssemblyNumbers& n = numbers(id);
    const double c = std::cos(n.frame_angle), s = std::sin(n.frame_angle); // H = R(theta) H'
    Matrix rotation, cell;
    rotation << c, -s, s, c;
    cell << n.cell_xx, n.cell_xy, n.cell_yx, n.cell_yy;
    return rotation * cell;
}

Packing Farm::packing(int id) const { return assembly(id).packing(parameters().grain_density); }

double Farm::largest_stable_step(int id) const {
    return stable_step(omega_squared_of_contacts(assembly(id).view(), contact_law_of(parameters())));
}

void Farm::activate_bonds() {
    for (int id = 0; id < size(); ++id) activate_bonds(id);
}

void Farm::activate_bonds(int id) {
    require(parameters().bond.has_value(), "bonds are to be activated, but the RVE has none", "give it a [bond] table");
    Assembly& rve = assembly(id);
    AssemblyView& s = rve.view();
    for (int c = 0; c < s.contact_count(); ++c) {
        if (!carries_force(s, c) || s.bonded[c] != 0) continue;
        s.bonded[c] = 1;
        ++s.numbers->activated_bonds;
    }
}

void Farm::rebond(int id, double ice_saturation) {
    if (!parameters().bond || !parameters().bond->rebond_on_freezing) return;
    std::int64_t& thawed = assemblies_[static_cast<std::size_t>(id)].view().numbers->thawed; // numbers are always here
    if (ice_saturation < parameters().bond->rebond_ice_saturation) {
        thawed = 1;
    } else if (thawed != 0) {
        activate_bonds(id);
        thawed = 0;
    }
}

void Farm::set_friction(double friction) {
    require(friction >= 0, "the friction is negative", "give a coefficient of 0 or more");
    stepper_.parameters.contact.friction = friction;
}

void Farm::reset_velocities(int id) {
    AssemblyView& s = assembly(id).view();
    for (double* column : {s.velocity_x, s.velocity_y, s.spin}) std::fill_n(column, s.disc_count(), 0.0);
}

void Farm::reset_tangential_forces(int id) {
    AssemblyView& s = assembly(id).view();
    std::fill_n(s.tangential_force, s.contact_count(), 0.0);
}

void Farm::save(int id, std::vector<std::byte>& bytes) const { assembly(id).save(bytes); }
std::size_t Farm::load(int id, std::span<const std::byte> bytes) { return assembly(id).load(bytes); }

} // namespace talik::farm
