#include "exchange/shm_segment.hpp"

#include <cerrno>
#include <chrono>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <new>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <thread>

#include "common/base/error.hpp"
#include "common/base/interrupt.hpp"
#include "common/base/log.hpp"
#include "exchange/frame.hpp"
#include "exchange/stale_segment.hpp"

namespace talik::exchange {
namespace bip = boost::interprocess;
namespace {

std::string checked_file_name(const std::string& name) {
    bool sound = !name.empty() && name.size() <= 100;
    for (char c : name) sound = sound && (std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_' || c == '.');
    require(sound, "'" + name + "' is no name for an exchange",
            "use 1 to 100 letters, digits, '-', '_' and '.', as in --exchange shm:slope-1");
    return "talik-" + name;
}

[[noreturn]] void report_taken(const std::string& name, const SegmentFinding& found) {
    if (found.state == SegmentState::foreign)
        fail(ExitCode::bad_input, fmt::format("the exchange name '{}' belongs to another user or program ({})", name,
                                              segment_path("talik-" + name)),
             "choose another name with --exchange shm:NAME");
    const std::string by = found.creator.pid > 0 ? fmt::format("process {}", found.creator.pid) : "a process that is just starting";
    fail(ExitCode::bad_input, fmt::format("the exchange name '{}' is in use by {}", name, by),
         "choose another name with --exchange shm:NAME, or end that run");
}

bip::shared_memory_object create_file(const std::string& name) {
    const std::string file_name = checked_file_name(name);
    for (int attempt = 0;; ++attempt) {
        try {
            return {bip::create_only, file_name.c_str(), bip::read_write, bip::permissions(0600)};
        } catch (const bip::interprocess_exception& error) {
            if (error.get_native_error() != EEXIST && error.get_error_code() != bip::already_exists_error)
                fail(ExitCode::out_of_resource, "cannot make shared memory in /dev/shm: " + std::string(std::strerror(error.get_native_error())),
                     "see that /dev/shm is mounted and writable");
        }
        const SegmentFinding found = examine_segment(file_name);
        const bool now_free = found.state == SegmentState::gone || remove_if_stale(file_name);
        if (!now_free || attempt >= 10) report_taken(name, found);
    }
}

// ftruncate() alone would succeed beyond the limit, and the first touch would then kill the process (SIGBUS).
void allocate(int file, std::size_t bytes, std::uint64_t free_bytes) {
    constexpr double mebibyte = 1048576.0;
    int error = free_bytes < bytes ? ENOSPC : EINTR;
    while (error == EINTR) error = posix_fallocate(file, 0, static_cast<off_t>(bytes));
    if (error == ENOSPC)
        fail(ExitCode::out_of_resource,
             fmt::format("/dev/shm has {:.1f} MiB, the exchange needs {:.1f} MiB", static_cast<double>(free_bytes) / mebibyte,
                         static_cast<double>(bytes) / mebibyte),
             "free or enlarge /dev/shm (of a container: --shm-size)");
    if (error != 0)
        fail(ExitCode::out_of_resource, fmt::format("cannot get {} bytes of shared memory: {}", bytes, std::strerror(error)),
             "see that /dev/shm is a tmpfs of this machine");
}

} // namespace

std::uint64_t free_shared_memory() {
    struct statvfs info {};
    if (statvfs("/dev/shm", &info) != 0) return 0;
    return static_cast<std::uint64_t>(info.f_bavail) * info.f_frsize;
}

SharedSegment::SharedSegment(bip::shared_memory_object&& memory, const std::string& name)
    : memory_(std::move(memory)), file_name_("talik-" + name) {}

SharedSegment::~SharedSegment() {
    remove_name();
}

void SharedSegment::remove_name() noexcept {
    if (!file_name_.empty()) unlink_if_same(file(), file_name_);
    file_name_.clear();
}

void SharedSegment::map() { region_ = std::make_shared<bip::mapped_region>(memory_, bip::read_write); }

std::byte* SharedSegment::ring_data(int role) const {
    return static_cast<std::byte*>(region_->get_address()) + shm::data_offset + static_cast<std::size_t>(role) * (**this).ring_bytes;
}

SharedSegment SharedSegment::create(const std::string& name, std::size_t ring_bytes, const std::function<std::uint64_t()>& free_bytes) {
    remove_stale_segments();
    SharedSegment made(create_file(name), name); // from here on its destructor removes the name
    hold_byte(made.file(), static_cast<int>(Role::driver));
    const std::size_t bytes = shm::segment_bytes(ring_bytes);
    allocate(made.file(), bytes, free_bytes ? free_bytes() : free_shared_memory());
    made.map();
    auto* segment = new (made.region_->get_address()) shm::Segment{};
    segment->preamble.version = protocol_version;
    segment->preamble.header_bytes = sizeof(shm::Segment);
    segment->preamble.segment_bytes = bytes;
    segment->preamble.creator = this_process();
    segment->ring_bytes = ring_bytes;
    shm::Side& own = segment->side[static_cast<int>(Role::driver)];
    own.process = segment->preamble.creator;
    own.presence = shm::Presence::attached;
    segment->preamble.magic = shm::magic;
    return made;
}

namespace {

// The segment is whole and ours, or there is one clear line why not.
void check_signed(shm::Segment& segment, std::size_t mapped_bytes, const std::string& name) {
    shm::Preamble& preamble = segment.preamble;
    const auto turn_away = [&](const std::string& problem, const std::string& remedy) {
        if (preamble.refused.exchange(1) == 0) std::strncpy(preamble.refusal, problem.c_str(), sizeof preamble.refusal - 1);
        fail(ExitCode::partner_lost, problem, remedy);
    };
    if (preamble.magic != shm::magic)
        fail(ExitCode::bad_input, "the shared memory '" + name + "' is not an exchange of Talik", "choose another --exchange name");
    if (preamble.version != protocol_version)
        turn_away(fmt::format("the driver speaks version {} of the exchange, the farm version {}", preamble.version, protocol_version),
                  "use driver and farm of the same version of Talik");
    if (preamble.header_bytes != sizeof(shm::Segment) || preamble.segment_bytes != mapped_bytes ||
        shm::segment_bytes(segment.ring_bytes) != mapped_bytes)
        turn_away(fmt::format("the shared memory of the exchange has {} bytes where {} are agreed", mapped_bytes, preamble.segment_bytes),
                  "use driver and farm of the same build of Talik");
}

void attach_as_farm(shm::Segment& segment, const std::string& name) {
    shm::Side& own = segment.side[static_cast<int>(Role::farm)];
    auto expected = shm::Presence::absent;
    require(own.presence.compare_exchange_strong(expected, shm::Presence::attaching),
            fmt::format("the exchange '{}' already has a farm (process {})", name, own.process.pid),
            "give each run its own --exchange name");
    own.process = this_process();
    own.presence = shm::Presence::attached;
}

} // namespace

// True once the segment is there, signed, and its driver lives.
bool SharedSegment::try_join(const std::string& name, bip::shared_memory_object& memory) {
    const std::string file_name = checked_file_name(name);
    const SegmentFinding found = examine_segment(file_name);
    if (found.state == SegmentState::foreign) report_taken(name, found);
    if (found.state == SegmentState::stale) remove_if_stale(file_name);
    if (found.state != SegmentState::in_use) return false;
    try {
        memory = bip::shared_memory_object(bip::open_only, file_name.c_str(), bip::read_write);
        return true;
    } catch (const bip::interprocess_exception&) {
        return false; // it has gone again
    }
}

SharedSegment SharedSegment::join(const std::string& name, const WaitLimits& limits) {
    using Clock = std::chrono::steady_clock;
    const auto begin = Clock::now();
    bip::shared_memory_object memory;
    for (bool said = false; !try_join(name, memory);) {
        const double waited = std::chrono::duration<double>(Clock::now() - begin).count();
        if (!said && waited > 0.5) log::info("waiting for a driver to open the exchange '{}'", name), said = true;
        if (waited > limits.attach_seconds)
            fail(ExitCode::partner_lost, fmt::format("no driver opened the exchange '{}' within {:g} s", name, limits.attach_seconds),
                 "start mpm-driver with the same --exchange shm:NAME");
        if (interrupted())
            fail(ExitCode::failed, fmt::format("interrupted by {} while waiting for a driver", interrupt_name()), "start again");
        std::this_thread::sleep_for(std::chrono::milliseconds(waited < 0.2 ? 2 : 20));
    }
    SharedSegment joined(std::move(memory), name);
    const std::string file_name = std::exchange(joined.file_name_, {}); // the driver's, until this side has attached
    joined.map();
    check_signed(*joined, joined.region_->get_size(), name);
    attach_as_farm(*joined, name);
    hold_byte(joined.file(), static_cast<int>(Role::farm));
    joined.file_name_ = file_name;
    joined.remove_name();
    return joined;
}

SharedSegment SharedSegment::join_here(const std::string& name, const SharedSegment& made) {
    SharedSegment joined(bip::shared_memory_object(bip::open_only, checked_file_name(name).c_str(), bip::read_write), name);
    joined.region_ = made.region_;
    attach_as_farm(*joined, name);
    joined.remove_name();
    return joined;
}

int remove_stale_segments() {
    int removed = 0;
    std::error_code error; // a folder that cannot be listed holds nothing of ours
    for (const auto& entry : std::filesystem::directory_iterator("/dev/shm", error)) {
        const std::string file_name = entry.path().filename().string();
        if (file_name.starts_with("talik-") && remove_if_stale(file_name)) ++removed;
    }
    return removed;
}

} // namespace talik::exchange
