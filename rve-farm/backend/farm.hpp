#pragma once
// Many RVEs spread over the threads of this machine. An RVE belongs to one thread during a macro step, so the number of
// threads changes no bit of any answer.
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/math/matrix.hpp"
#include "common/packing/packing.hpp"
#include "common/physics/rve_parameters.hpp"
#include "rve-farm/assembly/assembly.hpp"
#include "rve-farm/assembly/answer.hpp"
#include "rve-farm/block/block_farm.hpp"
#include "rve-farm/kernel/macro_step.hpp"
#include "rve-farm/physics/physics.hpp"

namespace talik::farm {

// Where RVEs are stepped. `automatic`: on the GPUs of this machine where there are any, and enough RVEs to be worth it.
enum class Backend { cpu, cuda, automatic };

struct FarmOptions {
    Backend backend = Backend::cpu;
    std::vector<std::shared_ptr<Device>> devices; // to be used instead of the CPU, whatever the backend: for tests
    int threads = 0; // 0 = all that OpenMP offers
    std::optional<Level> level;               // of the instructions; none = the best that this machine has
    std::optional<Precision> precision;       // of the kernel; none = the parameters'
    bool ledger = true;                       // book work and dissipation: a twentieth of the time or so
    bool smaller_sub_steps = true;            // taken where contacts have grown too stiff for those asked for; else Status::unstable_step
    bool time_stages = false;                 // for Farm::stages
    // Tests: the plain kernel, every phase in an order scrambled by this seed (ShuffledTeam); must give the same bits.
    std::optional<std::uint64_t> shuffle_seed;
    // Called by the thread that finished an RVE, from several threads at once: only for advancing progress counters.
    std::function<void()> on_rve_done;
};

// Refuses (out_of_resource) `cuda` where no GPU can be used, saying why.
void require_gpu(Backend backend);

class Farm {
public:
    // packing_of_rve[id] is the index of the packing that RVE `id` starts from. Grain density and thickness are those of
    // `parameters`. Refuses (bad_input) a time_step beyond the stable one, naming the largest stable step.
    Farm(const RveParameters& parameters, const std::vector<Packing>& packings, const std::vector<int>& packing_of_rve,
         FarmOptions options = {});

    int size() const { return static_cast<int>(assemblies_.size()); }
    const RveParameters& parameters() const { return stepper_.parameters; }
    const Kernel& kernel() const { return *stepper_.kernel; } // of the CPU; a GPU has its precision
    bool on_gpu() const { return blocks_ != nullptr; }
    const std::string& backend_in_words() const { return backend_in_words_; }

    // One macro step of the RVEs `ids` (any subset, no id twice).
    //   displacement_gradient_increments: dt grad v, row-major (xx xy yx yy) for each of the ids
    //   ice_saturation: S_i in [0, 1] of each (Eq. 8); empty means 1 (bonds, where there are any, at full strength)
    //   time_increment: of the macro step, s. substeps: 0 = the parameters' (fixed, or ceil(dt / time_step))
    void advance(std::span<const std::uint32_t> ids, std::span<const double> displacement_gradient_increments,
                 std::span<const double> ice_saturation, double time_increment, int substeps, std::span<Answer> answers);

    // The present state of one RVE, without stepping.
    Assembly& assembly(int id); // to be changed
    const Assembly& assembly(int id) const;
    const AssemblyNumbers& numbers(int id) const; // always here: on a GPU nothing is fetched for them
    Answer measure(int id) const;
    Matrix cell(int id) const;             // in fixed axes, columns are the basis vectors, m
    Packing packing(int id) const;         // with its contacts that carry force or bond: imports to the same state
    double largest_stable_step(int id) const; // 2/omega_max of the contact network (power iteration), s; damping shortens it

    void activate_bonds(); // all contacts touching at this moment, in every RVE
    void activate_bonds(int id);
    void set_friction(double friction); // mu of all RVEs, for preparing packings
    void reset_velocities(int id);      // discs at rest
    void reset_tangential_forces(int id); // forgets the shear history of all contacts

    // Everything of one RVE, in bytes, list orders included: what is loaded goes on with the same bits.
    // load returns the number of bytes it has used.
    void save(int id, std::vector<std::byte>& bytes) const;
    std::size_t load(int id, std::span<const std::byte> bytes);

    // Where the time of all threads has gone since the farm was made, s; zeros unless asked for in the options.
    StageSeconds stages() const;

    // RVEs finished since the farm was made; readable from any thread.
    std::uint64_t rves_done() const { return rves_done_->load(std::memory_order_relaxed); }

private:
    // Where the scene lets bonds form anew: an RVE whose ice fell below the threshold bonds at the contacts present once
    // its ice is back there. The memory of the thaw is part of the RVE's state.
    void rebond(int id, double ice_saturation);
    void choose_backend();
    double beta(std::span<const double> ice_saturation, std::size_t row) const { // Eq. (8)
        return parameters().bond ? parameters().bond->strength_at(ice_saturation.empty() ? 1.0 : ice_saturation[row]) : 0.0;
    }

    FarmOptions options_;
    Stepper stepper_;
    std::vector<StageSeconds> stages_; // by thread
    mutable std::vector<Assembly> assemblies_; // fetched from a GPU when they are asked for
    std::unique_ptr<BlockFarm> blocks_;         // where the RVEs are on GPUs
    std::string backend_in_words_ = "cpu";
    std::unique_ptr<std::atomic<std::uint64_t>> rves_done_ = std::make_unique<std::atomic<std::uint64_t>>(0); // movable
};

} // namespace talik::farm
