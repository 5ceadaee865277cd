// Names in /dev/shm: who holds them, who may remove them, and what is said when one cannot be had.
#include "exchange/shm_segment.hpp"
#include "exchange/stale_segment.hpp"
#include "tests/exchange/support.hpp"
#include "tests/support/catch.hpp"

#include <fcntl.h>
#include <fstream>
#include <sys/stat.h>
#include <thread>

using namespace talik;
using namespace talik::exchange;
using namespace talik::exchange::test;

namespace {

// Maps a segment that is still named, to tamper with it as a program of another making would.
struct Tampered {
    boost::interprocess::shared_memory_object memory;
    boost::interprocess::mapped_region region;
    explicit Tampered(const std::string& name)
        : memory(boost::interprocess::open_only, ("talik-" + name).c_str(), boost::interprocess::read_write),
          region(memory, boost::interprocess::read_write) {}
    shm::Segment& segment() const { return *static_cast<shm::Segment*>(region.get_address()); }
};

// A segment whose maker was killed before anybody joined it.
std::string abandoned_segment() {
    const std::string name = unique_name("stale");
    Child maker([&] {
        const auto channel = make_shm_channel(name, {});
        std::raise(SIGKILL);
    });
    maker.exit_code();
    return name;
}

WaitLimits brief() {
    WaitLimits limits;
    limits.attach_seconds = 0.3;
    return limits;
}

} // namespace

TEST_CASE("A segment is its user's alone, and has a name until both sides have it", "[exchange][shm]") {
    const std::string name = unique_name("mode");
    const auto driver = make_shm_channel(name, {});
    struct stat info {};
    REQUIRE(stat(segment_path("talik-" + name).c_str(), &info) == 0);
    CHECK((info.st_mode & 0777) == 0600);
    const auto farm = join_shm_channel(name, {});
    CHECK_FALSE(in_dev_shm(name));
}

TEST_CASE("A driver that ends before its farm came takes the name with it", "[exchange][shm]") {
    const std::string name = unique_name("gone");
    make_shm_channel(name, {}).reset();
    CHECK_FALSE(in_dev_shm(name));
}

TEST_CASE("A name in use is refused, and its process named", "[exchange][shm]") {
    const std::string name = unique_name("taken");
    const auto driver = make_shm_channel(name, {});
    ExitCode code = ExitCode::done;
    const std::string text = error_text([&] { make_shm_channel(name, {}); }, &code);
    CHECK(code == ExitCode::bad_input);
    CHECK(contains(text, fmt::format("in use by process {}", getpid())));
    CHECK(in_dev_shm(name)); // the refusal has not taken it from its owner
}

TEST_CASE("A name that cannot stand in /dev/shm is refused", "[exchange][shm]") {
    for (const char* name : {"", "a/b", "../x", "a b"}) CHECK_THROWS_AS(make_shm_channel(name, {}), Error);
}

TEST_CASE("A segment left behind by a dead process is removed at the next start of any run", "[exchange][shm][alone]") {
    const std::string name = abandoned_segment();
    REQUIRE(in_dev_shm(name));
    SECTION("of the same name") { CHECK_NOTHROW(make_shm_channel(name, {})); }
    SECTION("of another name") { CHECK_NOTHROW(make_shm_channel(unique_name("other"), {})); }
    SECTION("by a farm that waits for its driver") { CHECK_THROWS_AS(join_shm_channel(name, brief()), Error); }
    CHECK_FALSE(in_dev_shm(name));
}

TEST_CASE("A segment of a living process, or one just being made, is never removed", "[exchange][shm]") {
    const std::string name = unique_name("living"), unsigned_name = unique_name("new");
    const auto driver = make_shm_channel(name, {});
    std::ofstream(segment_path("talik-" + unsigned_name)) << "";
    remove_stale_segments();
    CHECK(in_dev_shm(name));
    CHECK(in_dev_shm(unsigned_name));
    CHECK(contains(error_text([&] { make_shm_channel(unsigned_name, {}); }), "a process that is just starting"));
    std::filesystem::remove(segment_path("talik-" + unsigned_name));
}

TEST_CASE("A process number in use again does not keep a dead run's segment alive", "[exchange][shm]") {
    const std::string name = unique_name("reused");
    const auto driver = make_shm_channel(name, {});
    Tampered(name).segment().preamble.creator.start_time += 1; // as if an earlier process of this number had made it
    CHECK(examine_segment("talik-" + name).state == SegmentState::stale);
}

TEST_CASE("Across pid namespaces, a lock on the segment tells life from death", "[exchange][shm][alone]") {
    const std::string name = unique_name("namespace");
    const auto driver = make_shm_channel(name, {});
    const std::string left = abandoned_segment();
    Tampered(name).segment().preamble.creator.pid_namespace ^= 1;
    CHECK(examine_segment("talik-" + name).state == SegmentState::in_use);
    const Tampered dead(left);
    dead.segment().preamble.creator.pid_namespace ^= 1;
    CHECK(examine_segment("talik-" + left).state == SegmentState::stale);
    const int file = dead.memory.get_mapping_handle().handle;
    const ProcessWatch watch(dead.segment().preamble.creator, file, 0);
    CHECK_FALSE(watch.alive());
    remove_stale_segments();
}

TEST_CASE("A farm started first waits for its driver, for a bounded time", "[exchange][shm]") {
    const std::string name = unique_name("first");
    SECTION("the driver comes") {
        std::unique_ptr<Channel> driver;
        std::thread late([&] {
            std::this_thread::sleep_for(std::chrono::milliseconds(150));
            driver = make_shm_channel(name, {});
        });
        CHECK_NOTHROW(join_shm_channel(name, {}));
        late.join();
    }
    SECTION("it does not") {
        const auto begin = Clock::now();
        CHECK(contains(error_text([&] { join_shm_channel(name, brief()); }), "within 0.3 s"));
        CHECK(seconds_since(begin) < 1.0);
    }
}

TEST_CASE("A driver waits for its farm for a bounded time", "[exchange][shm]") {
    const auto driver = make_shm_channel(unique_name("alone"), brief());
    Frame frame;
    CHECK(contains(error_text([&] { driver->receive(frame); }), "the farm did not come to the exchange within 0.3 s"));
}

TEST_CASE("/dev/shm too small is said in MiB, before anything touches memory", "[exchange][shm]") {
    const std::string name = unique_name("small");
    ShmOptions options;
    ExitCode code = ExitCode::done;
    SECTION("by its free space") {
        options.ring_bytes = 4u << 20;
        options.free_bytes = [] { return std::uint64_t(1) << 20; };
        const std::string text = error_text([&] { make_shm_channel(name, {}, options); }, &code);
        CHECK(contains(text, "/dev/shm has 1.0 MiB, the exchange needs 8.0 MiB"));
    }
    SECTION("by the allocation itself") {
        options.ring_bytes = std::size_t(1) << 44; // 16 TiB
        options.free_bytes = [] { return ~std::uint64_t(0); };
        const std::string text = error_text([&] { make_shm_channel(name, {}, options); }, &code);
        CHECK(contains(text, "the exchange needs 33554432.0 MiB"));
    }
    CHECK(code == ExitCode::out_of_resource);
    CHECK_FALSE(in_dev_shm(name));
}

TEST_CASE("Driver and farm of different versions turn each other away, both saying so", "[exchange][shm]") {
    const std::string name = unique_name("version");
    const auto driver = make_shm_channel(name, {});
    Tampered(name).segment().preamble.version = protocol_version + 1; // as a newer driver would have written it
    const std::string says = fmt::format("the driver speaks version {} of the exchange, the farm version {}", protocol_version + 1, protocol_version);
    CHECK(contains(error_text([&] { join_shm_channel(name, {}); }), says));
    Frame frame;
    CHECK(contains(error_text([&] { driver->receive(frame); }), says));
}

TEST_CASE("A segment of the wrong size, or none of ours, is refused in one line", "[exchange][shm]") {
    const std::string name = unique_name("size"), strange = unique_name("strange");
    const auto driver = make_shm_channel(name, {});
    Tampered(name).segment().ring_bytes *= 2;
    CHECK(contains(error_text([&] { join_shm_channel(name, {}); }), "bytes where"));
    std::ofstream(segment_path("talik-" + strange)) << std::string(5000, 'x');
    CHECK(contains(error_text([&] { join_shm_channel(strange, {}); }), "belongs to another user or program"));
    CHECK(contains(error_text([&] { make_shm_channel(strange, {}); }), "belongs to another user or program"));
    CHECK(in_dev_shm(strange)); // not ours to remove
    std::filesystem::remove(segment_path("talik-" + strange));
}

TEST_CASE("A second farm is turned away, and the first one named", "[exchange][shm]") {
    const std::string name = unique_name("second");
    const auto driver = make_shm_channel(name, {});
    Tampered(name).segment().side[1].process.pid = 4242;
    Tampered(name).segment().side[1].presence = shm::Presence::attaching;
    CHECK(contains(error_text([&] { join_shm_channel(name, {}); }), "already has a farm (process 4242)"));
    CHECK(in_dev_shm(name)); // the name is not the intruder's to remove
}

TEST_CASE("A byte flipped in the ring is noticed by the checksum", "[exchange][shm]") {
    const std::string name = unique_name("flip");
    const auto driver = make_shm_channel(name, {});
    const Tampered segment(name);
    const auto farm = join_shm_channel(name, {});
    driver->use_checksums(true);
    Frame frame;
    frame.payload.assign(1000, std::byte{3});
    driver->send(frame);
    auto* ring = static_cast<std::byte*>(segment.region.get_address()) + shm::data_offset;
    ring[sizeof(FrameHeader) + 700] ^= std::byte{1};
    CHECK(contains(error_text([&] { farm->receive(frame); }), "corrupted"));
}

TEST_CASE("Counters of the ring that cannot be are an error, never an access out of bounds", "[exchange][shm]") {
    const std::string name = unique_name("counters");
    const auto driver = make_shm_channel(name, {});
    const Tampered segment(name);
    const auto farm = join_shm_channel(name, {});
    segment.segment().ring[0].written = std::uint64_t(1) << 40;
    Frame frame;
    CHECK(contains(error_text([&] { farm->receive(frame); }), "counters of the ring are corrupted"));
}
