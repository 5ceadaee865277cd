#include "rve-farm/block/block_farm.hpp"

#include <algorithm>
#include <chrono>
#include <deque>

#include <fmt/format.h>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "rve-farm/block/block_work.hpp"
#include "rve-farm/kernel/conclude.hpp"
#include "rve-farm/physics/physics_choice.hpp"

namespace talik::farm {
namespace {

constexpr std::size_t blocks_worth_a_launch = 256;
constexpr int blocks_of_a_batch = 1024;       // some waves of the largest GPUs: the tail of one overlaps with the next
constexpr int spread_blocks_of_a_batch = 256; // each needs working memory of its own
constexpr std::size_t most_staged_images = 64;
constexpr int copies = Device::batch_streams; // the stream of copies besides those of batches

// What takes less than a microsecond for an RVE is not worth waking a thread for a few of them.
int threads_for(int rves, int threads) { return std::clamp(rves / 64, 1, threads); }

double mebibytes(std::size_t bytes) { return static_cast<double>(bytes) / (1 << 20); }

template <class Real>
BlockShape shape_in(const Device& device, bool bonds, const BlockSize& size) {
    std::byte* const anywhere = reinterpret_cast<std::byte*>(std::uintptr_t{4096}); // only counted, never touched
    const std::size_t budget = device.shared_bytes_of_a_block();
    BlockWork<Real> work;
    // As many warps as a multiprocessor has for each of the blocks that it has room for.
    constexpr int warps = warps_of_a_multiprocessor<Real>(false);
    const auto shared = [&](int threads) { return work.template lay_out<false>(size, bonds, threads, anywhere, 0, anywhere).shared; };
    const std::size_t most = shared(block_threads(size.groups, warps));
    if (most <= budget) {
        const auto blocks = static_cast<int>(std::clamp<std::size_t>(device.shared_bytes_of_a_multiprocessor() / (most + shared_bytes_of_the_system), 1, warps));
        const int threads = block_threads(size.groups, warps / blocks);
        return {false, threads, blocks, shared(threads), 0};
    }
    const int threads = block_threads(size.groups, warps_of_a_multiprocessor<Real>(true));
    const auto used = work.template lay_out<true>(size, bonds, threads, anywhere, budget, anywhere);
    return {true, threads, 1, used.shared, used.spread};
}

// What is not shared of a block, as if nothing were: enough for any list.
std::size_t most_spread(Precision precision, bool bonds, const BlockSize& size) {
    std::byte* const anywhere = reinterpret_cast<std::byte*>(std::uintptr_t{4096});
    const auto count = [&](auto real) { return BlockWork<decltype(real)>().template lay_out<true>(size, bonds, 32, anywhere, 0, anywhere).spread; };
    return precision == Precision::single_ ? count(float()) : count(double());
}

} // namespace

BlockShape shape_of_block(const Device& device, Precision precision, bool bonds, const BlockSize& size) {
    return precision == Precision::single_ ? shape_in<float>(device, bonds, size) : shape_in<double>(device, bonds, size);
}

struct BlockFarm::OnDevice {
    std::shared_ptr<Device> device;
    int index = 0;
    std::vector<std::uint32_t> ids; // of its RVEs
    std::byte* images = nullptr;
    BlockRve* rves = nullptr;       // on the device, by slot
    std::size_t spread_bytes = 0;   // of a block
    std::size_t largest_image = 0, staged_images = 0;
    std::byte* staging = nullptr;   // on the host
    BlockRve* staged_rves = nullptr;

    struct Stream {
        BlockTask *tasks = nullptr, *tasks_there = nullptr;
        BlockResult *results = nullptr, *results_there = nullptr;
        std::byte* spread = nullptr;
        std::vector<int> runs; // under way
    };
    Stream streams[Device::batch_streams];
    std::deque<int> under_way; // streams, oldest first
    std::deque<int> ready, without_list; // runs of the step
};

struct BlockFarm::Step {
    const Stepper& stepper;
    std::vector<Assembly>& assemblies;
    std::span<const std::uint32_t> ids;
    std::span<Answer> answers;
    const std::function<void()>& on_rve_done;
    std::span<MacroRun> runs;
};

BlockFarm::~BlockFarm() = default;

BlockFarm::BlockFarm(const Stepper& stepper, const std::vector<Assembly>& assemblies, std::vector<std::shared_ptr<Device>> devices, int threads) : threads_(threads) {
    ensure(!devices.empty());
    for (auto& device : devices) {
        on_.push_back(std::make_unique<OnDevice>());
        on_.back()->device = std::move(device);
        on_.back()->index = static_cast<int>(on_.size()) - 1;
    }
    std::vector<std::pair<std::int64_t, std::int64_t>> sizes; // discs, room for contacts
    for (std::size_t id = 0; id < assemblies.size(); ++id) {
        const AssemblyNumbers& n = assemblies[id].numbers();
        const std::pair size(n.disc_count, n.contact_capacity);
        const auto known = std::find(sizes.begin(), sizes.end(), size);
        Place place;
        place.image = static_cast<std::size_t>(known - sizes.begin());
        if (known == sizes.end()) {
            sizes.push_back(size);
            images_.emplace_back(assemblies[id]);
        }
        OnDevice& on = *on_[id % on_.size()];
        place.device = on.index;
        place.slot = static_cast<std::int64_t>(on.ids.size());
        on.ids.push_back(static_cast<std::uint32_t>(id));
        places_.push_back(place);
    }
    for (auto& on : on_)
        if (!on->ids.empty()) prepare_device(*on, stepper, assemblies);
}

void BlockFarm::prepare_device(OnDevice& on, const Stepper& stepper, const std::vector<Assembly>& assemblies) {
    std::size_t images = 0;
    for (const std::uint32_t id : on.ids) {
        Place& place = places_[id];
        const BlockImage& image = image_of(place);
        place.begin = images;
        images += image.bytes();
        on.largest_image = std::max(on.largest_image, image.bytes());
        if (shape_of_block(*on.device, stepper.kernel->precision, stepper.parameters.bond.has_value(), image.largest()).spread)
            on.spread_bytes = std::max(on.spread_bytes, most_spread(stepper.kernel->precision, stepper.parameters.bond.has_value(), image.largest()));
    }
    const std::size_t blocks = std::min<std::size_t>(blocks_of_a_batch, on.ids.size());
    const std::size_t spread_blocks = on.spread_bytes > 0 ? std::min<std::size_t>(spread_blocks_of_a_batch, on.ids.size()) : 0;
    const std::size_t of_streams = Device::batch_streams * (blocks * (sizeof(BlockTask) + sizeof(BlockResult)) + spread_blocks * on.spread_bytes);
    const std::size_t all = images + on.ids.size() * sizeof(BlockRve) + of_streams, left = on.device->free_bytes();
    if (all > left)
        fail(ExitCode::out_of_resource,
             fmt::format("{} RVEs of up to {} discs need {:.0f} MiB of the memory of {}, which has {:.0f} MiB left", on.ids.size(),
                         [&] {
                             std::int64_t most = 0;
                             for (const std::uint32_t id : on.ids) most = std::max(most, assemblies[id].numbers().disc_count);
                             return most;
                         }(),
                         mebibytes(all), on.device->name(), mebibytes(left)),
             "use more GPUs, fewer RVEs, or --backend cpu");
    on.images = on.device->allocate(images, "the state of the RVEs");
    on.rves = reinterpret_cast<BlockRve*>(on.device->allocate(on.ids.size() * sizeof(BlockRve), "the list of the RVEs"));
    on.staged_images = std::min(most_staged_images, on.ids.size());
    on.staging = on.device->allocate_on_host(on.staged_images * on.largest_image, "copies of RVEs");
    on.staged_rves = reinterpret_cast<BlockRve*>(on.device->allocate_on_host(on.staged_images * sizeof(BlockRve), "copies of RVEs"));
    for (auto& stream : on.streams) {
        stream.tasks = reinterpret_cast<BlockTask*>(on.device->allocate_on_host(blocks * sizeof(BlockTask), "tasks"));
        stream.results = reinterpret_cast<BlockResult*>(on.device->allocate_on_host(blocks * sizeof(BlockResult), "results"));
        stream.tasks_there = reinterpret_cast<BlockTask*>(on.device->allocate(blocks * sizeof(BlockTask), "tasks"));
        stream.results_there = reinterpret_cast<BlockResult*>(on.device->allocate(blocks * sizeof(BlockResult), "results"));
        if (spread_blocks > 0) stream.spread = on.device->allocate(spread_blocks * on.spread_bytes, "the working memory of large RVEs");
    }
}

void BlockFarm::advance(const Stepper& stepper, std::vector<Assembly>& assemblies, std::span<const std::uint32_t> ids, std::span<const MacroStep> steps, std::span<Answer> answers,
                        const std::function<void()>& on_rve_done) {
    if (runs_.size() < ids.size()) runs_.resize(ids.size());
    Step step{stepper, assemblies, ids, answers, on_rve_done, std::span(runs_).first(ids.size())};
    const int count = static_cast<int>(ids.size());
#pragma omp parallel for schedule(static) num_threads(threads_for(count, threads_))
    for (int r = 0; r < count; ++r) {
        const auto row = static_cast<std::size_t>(r);
        step.runs[row] = MacroRun(stepper, assemblies[ids[row]], steps[row]);
        if (step.runs[row].need() == MacroRun::Need::nothing) answers[row] = step.runs[row].answer();
    }
    for (auto& on : on_) { // what an error has left behind
        on->ready.clear(), on->without_list.clear(), on->under_way.clear();
        for (auto& stream : on->streams) stream.runs.clear();
    }
    for (int r = 0; r < count; ++r) sort_out(*on_[static_cast<std::size_t>(places_[ids[static_cast<std::size_t>(r)]].device)], step, std::span(&r, 1));
    for (bool busy = true; busy;) {
        busy = false;
        for (auto& on : on_) issue(*on, step);
        for (auto& on : on_) {
            if (!on->without_list.empty()) { // while others compute
                make_lists(*on, step);
                issue(*on, step);
            }
            if (!on->under_way.empty() && (on->without_list.empty() || on->device->is_done(on->under_way.front()))) take_results(*on, step);
            busy = busy || !on->under_way.empty() || !on->without_list.empty() || !on->ready.empty();
        }
    }
}

// To where each run goes next. The answer of what is over has been given.
void BlockFarm::sort_out(OnDevice& on, Step& step, std::span<const int> runs) {
    for (const int r : runs) {
        const auto row = static_cast<std::size_t>(r);
        switch (step.runs[row].need()) {
        case MacroRun::Need::positions:
        case MacroRun::Need::list: on.without_list.push_back(r); break;
        case MacroRun::Need::chunk:
            // A state that has not been there yet goes through the hands of the host first.
            (places_[step.ids[row]].newer_on_host ? on.without_list : on.ready).push_back(r);
            break;
        case MacroRun::Need::nothing:
            if (step.on_rve_done) step.on_rve_done();
            break;
        }
    }
}

// Launches what is ready while streams are free. A batch is of one kind: as many threads to a block, as many blocks on a
// multiprocessor, all shared or not. While lists are being made, small batches wait for more, unless the device would be idle.
void BlockFarm::issue(OnDevice& on, Step& step) {
    if (!on.without_list.empty() && !on.under_way.empty() && on.ready.size() < blocks_worth_a_launch) return;
    for (int s = 0; s < Device::batch_streams && !on.ready.empty(); ++s) {
        auto& stream = on.streams[s];
        if (!stream.runs.empty()) continue;
        const Stepper& stepper = step.stepper;
        const auto place_of = [&](int r) -> const Place& { return places_[step.ids[static_cast<std::size_t>(r)]]; };
        const BlockShape first = place_of(on.ready.front()).shape;
        const bool spread = first.spread;
        const int threads = first.threads;
        const std::size_t most = std::min<std::size_t>(static_cast<std::size_t>(spread ? spread_blocks_of_a_batch : blocks_of_a_batch), on.ids.size());
        std::deque<int> others;
        std::size_t shared = 0;
        for (; !on.ready.empty() && stream.runs.size() < most; on.ready.pop_front()) {
            const int r = on.ready.front();
            const Place& place = place_of(r);
            if (place.shape.spread != spread || place.shape.threads != threads || place.shape.neighbours != first.neighbours) {
                others.push_back(r);
                continue;
            }
            shared = std::max(shared, place.shape.shared_bytes);
            stream.runs.push_back(r);
        }
        const int blocks = static_cast<int>(stream.runs.size());
#pragma omp parallel for schedule(static) num_threads(threads_for(blocks, threads_))
        for (int k = 0; k < blocks; ++k) {
            const auto row = static_cast<std::size_t>(stream.runs[static_cast<std::size_t>(k)]);
            BlockTask& task = stream.tasks[k];
            task.rve = places_[step.ids[row]].slot;
            task.request = step.runs[row].request();
            task.numbers = step.assemblies[step.ids[row]].numbers();
            task.spread = spread ? stream.spread + static_cast<std::size_t>(k) * on.spread_bytes : nullptr;
        }
        on.ready.insert(on.ready.begin(), others.begin(), others.end());
        if (spread && !said_that_some_are_spread_) {
            said_that_some_are_spread_ = true;
            log::warn("RVEs of this size do not fit into the {:.0f} KiB of shared memory of a block of {}: they run in a slower variant, part of whose working memory is not shared",
                      static_cast<double>(on.device->shared_bytes_of_a_block()) / 1024, on.device->name());
        }
        BlockLaunch launch;
        launch.parameters = &stepper.parameters;
        launch.precision = stepper.kernel->precision;
        launch.ledger = stepper.ledger;
        launch.spread = spread;
        launch.threads = threads;
        launch.shared_bytes = shared;
        launch.rves = on.rves;
        launch.tasks = stream.tasks_there;
        launch.results = stream.results_there;
        launch.blocks = blocks;
        on.device->copy_in(s, reinterpret_cast<std::byte*>(stream.tasks_there), reinterpret_cast<const std::byte*>(stream.tasks), stream.runs.size() * sizeof(BlockTask));
        on.device->launch(s, launch);
        on.device->copy_out(s, reinterpret_cast<std::byte*>(stream.results), reinterpret_cast<const std::byte*>(stream.results_there), stream.runs.size() * sizeof(BlockResult));
        on.under_way.push_back(s);
    }
}

// Waits for the oldest batch.
void BlockFarm::take_results(OnDevice& on, Step& step) {
    const int s = on.under_way.front();
    auto& stream = on.streams[s];
    on.device->wait(s);
    on.under_way.pop_front();
    const std::vector<int> runs = std::move(stream.runs);
    stream.runs.clear();
    const ContactLaw<double> law = contact_law_of(step.stepper.parameters);
    const int count = static_cast<int>(runs.size());
#pragma omp parallel for schedule(static) num_threads(threads_for(count, threads_))
    for (int k = 0; k < count; ++k) {
        const auto row = static_cast<std::size_t>(runs[static_cast<std::size_t>(k)]);
        const BlockResult& result = stream.results[k];
        MacroRun& run = step.runs[row];
        ChunkOutcome outcome;
        outcome.accepted = result.accepted != 0;
        outcome.finite = result.finite != 0;
        outcome.largest_displacement = result.largest_displacement;
        outcome.stretch = result.stretch;
        outcome.last_stretch = result.last_stretch;
        outcome.strain = run.request().substeps * run.request().stretch.largest_strain(); // the same in each
        if (outcome.accepted) {
            conclude(run.request(), result.cell, law, result.sums, *step.assemblies[step.ids[row]].view().numbers, outcome);
            places_[step.ids[row]].newer_on_device = true;
        }
        run.chunk_run(outcome);
        if (run.need() == MacroRun::Need::nothing) step.answers[row] = run.answer();
    }
    sort_out(on, step, runs);
}

// Some of those that need the host: their state fetched, judged, given a list, sent back.
void BlockFarm::make_lists(OnDevice& on, Step& step) {
    const auto begin = std::chrono::steady_clock::now();
    std::vector<int> runs;
    std::vector<std::uint32_t> ids;
    for (; !on.without_list.empty() && runs.size() < on.staged_images; on.without_list.pop_front()) {
        runs.push_back(on.without_list.front());
        ids.push_back(step.ids[static_cast<std::size_t>(runs.back())]);
    }
    download(on, step.assemblies, ids);
    const int count = static_cast<int>(runs.size());
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads_)
    for (int k = 0; k < count; ++k) {
        const auto row = static_cast<std::size_t>(runs[static_cast<std::size_t>(k)]);
        MacroRun& run = step.runs[row];
        Assembly& rve = step.assemblies[step.ids[row]];
        Place& place = places_[step.ids[row]];
        if (run.need() == MacroRun::Need::positions) run.judge();
        if (run.need() == MacroRun::Need::list) {
            Status status = make_list(rve, block_shape());
            if (status == Status::ok) status = image_of(place).size_of(rve.layout(), place.size);
            place.newer_on_host = true;
            run.list_made(status);
        }
        if (run.need() == MacroRun::Need::nothing) step.answers[row] = run.answer();
    }
    upload(on, step, runs);
    sort_out(on, step, runs);
    rebuild_seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

// At most staged_images of them.
void BlockFarm::download(OnDevice& on, std::vector<Assembly>& assemblies, std::span<const std::uint32_t> ids) {
    std::vector<std::uint32_t> fetched;
    for (const std::uint32_t id : ids) {
        Place& place = places_[id];
        if (!place.newer_on_device) continue;
        on.device->copy_out(copies, on.staging + fetched.size() * on.largest_image, on.images + place.begin, image_of(place).state_bytes(assemblies[id]));
        fetched.push_back(id);
    }
    if (fetched.empty()) return;
    on.device->wait(copies);
    const int count = static_cast<int>(fetched.size());
#pragma omp parallel for schedule(static) num_threads(threads_for(count, threads_))
    for (int k = 0; k < count; ++k) {
        const std::uint32_t id = fetched[static_cast<std::size_t>(k)];
        image_of(places_[id]).read_state(assemblies[id], on.staging + static_cast<std::size_t>(k) * on.largest_image);
        places_[id].newer_on_device = false;
    }
}

void BlockFarm::upload(OnDevice& on, Step& step, std::span<const int> runs) {
    std::vector<int> sent;
    for (const int r : runs) {
        const auto row = static_cast<std::size_t>(r);
        Place& place = places_[step.ids[row]];
        if (step.runs[row].need() != MacroRun::Need::chunk || !place.newer_on_host) continue;
        Assembly& rve = step.assemblies[step.ids[row]];
        rve.layout().update(rve.view(), block_shape());
        ensure(image_of(place).size_of(rve.layout(), place.size) == Status::ok); // of a list made or loaded, in the room of one
        place.shape = shape_of_block(*on.device, step.stepper.kernel->precision, step.stepper.parameters.bond.has_value(), place.size);
        sent.push_back(r);
    }
    const int count = static_cast<int>(sent.size());
#pragma omp parallel for schedule(static) num_threads(threads_for(count, threads_))
    for (int k = 0; k < count; ++k) {
        const std::uint32_t id = step.ids[static_cast<std::size_t>(sent[static_cast<std::size_t>(k)])];
        Place& place = places_[id];
        Assembly& rve = step.assemblies[id];
        on.staged_rves[k] = image_of(place).write(rve, place.size, on.staging + static_cast<std::size_t>(k) * on.largest_image, on.images + place.begin);
        place.newer_on_host = false;
    }
    for (int k = 0; k < count; ++k) {
        const Place& place = places_[step.ids[static_cast<std::size_t>(sent[static_cast<std::size_t>(k)])]];
        on.device->copy_in(copies, on.images + place.begin, on.staging + static_cast<std::size_t>(k) * on.largest_image, image_of(place).bytes());
        on.device->copy_in(copies, reinterpret_cast<std::byte*>(on.rves + place.slot), reinterpret_cast<const std::byte*>(on.staged_rves + k), sizeof(BlockRve));
    }
    if (count > 0) on.device->wait(copies);
}

void BlockFarm::fetch(Assembly& rve, int id) {
    Place& place = places_[static_cast<std::size_t>(id)];
    if (!place.newer_on_device) return;
    OnDevice& on = *on_[static_cast<std::size_t>(place.device)];
    on.device->copy_out(copies, on.staging, on.images + place.begin, image_of(place).state_bytes(rve));
    on.device->wait(copies);
    image_of(place).read_state(rve, on.staging);
    place.newer_on_device = false;
}

void BlockFarm::changed(int id) {
    ensure(!places_[static_cast<std::size_t>(id)].newer_on_device);
    places_[static_cast<std::size_t>(id)].newer_on_host = true;
}

} // namespace talik::farm
