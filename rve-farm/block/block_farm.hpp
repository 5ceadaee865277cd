#pragma once
// Many RVEs on devices: their state stays there from step to step, increments go in and stresses come out. A macro step of an RVE
// is a chunk, one block, one launch; where its list is spent it comes back, is given a new one on the host, and goes out again
// while others compute. RVEs are dealt to the devices in their order, and know nothing of one another: no bit depends on how
// many devices there are, or on who computes beside whom.
#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "rve-farm/block/block_image.hpp"
#include "rve-farm/block/device.hpp"
#include "rve-farm/kernel/macro_run.hpp"

namespace talik::farm {

// How a block runs on a device: all its working memory shared, or spread; threads; how many find room on a multiprocessor; bytes.
struct BlockShape {
    bool spread = false;
    int threads = 0, neighbours = 1;
    std::size_t shared_bytes = 0, spread_bytes = 0;
};
BlockShape shape_of_block(const Device& device, Precision precision, bool bonds, const BlockSize& size);

class BlockFarm {
public:
    // Takes all the memory that the RVEs will ever need; refuses (out_of_resource) with the figure where a device has less.
    BlockFarm(const Stepper& stepper, const std::vector<Assembly>& assemblies, std::vector<std::shared_ptr<Device>> devices, int threads);
    ~BlockFarm();

    // One macro step of the RVEs `ids`; steps and answers in their order.
    void advance(const Stepper& stepper, std::vector<Assembly>& assemblies, std::span<const std::uint32_t> ids, std::span<const MacroStep> steps, std::span<Answer> answers,
                 const std::function<void()>& on_rve_done);

    // The state on the host is the present one.
    void fetch(Assembly& rve, int id);
    // It is newer than that on the device (and was fetched before it was changed).
    void changed(int id);

    double rebuild_seconds() const { return rebuild_seconds_; }

private:
    struct OnDevice; // a device and what of the farm lies on it
    struct Step;     // a macro step under way
    struct Place {   // of an RVE
        int device = 0;
        std::int64_t slot = 0;     // among the RVEs of the device
        std::size_t begin = 0;     // of its image
        std::size_t image = 0;     // which of images_
        BlockSize size;            // of the present list, which
        BlockShape shape;          // runs so
        bool newer_on_host = true, newer_on_device = false;
    };

    const BlockImage& image_of(const Place& place) const { return images_[place.image]; }
    void prepare_device(OnDevice& on, const Stepper& stepper, const std::vector<Assembly>& assemblies);

    void issue(OnDevice& on, Step& step);
    void take_results(OnDevice& on, Step& step);
    void make_lists(OnDevice& on, Step& step);
    void sort_out(OnDevice& on, Step& step, std::span<const int> runs);
    void download(OnDevice& on, std::vector<Assembly>& assemblies, std::span<const std::uint32_t> ids);
    void upload(OnDevice& on, Step& step, std::span<const int> runs);

    std::vector<Place> places_;     // by RVE
    std::vector<BlockImage> images_; // one for all RVEs of the same sizes
    std::vector<std::unique_ptr<OnDevice>> on_;
    std::vector<MacroRun> runs_;     // of the step under way, by row
    int threads_;
    double rebuild_seconds_ = 0;
    bool said_that_some_are_spread_ = false;
};

} // namespace talik::farm
