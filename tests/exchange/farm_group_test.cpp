// Several farms answer as one, and one that is lost is replaced: always the same bits.
#include "exchange/farm_group.hpp"

#include "tests/exchange/support.hpp"
#include "tests/support/catch.hpp"

#include <csignal>
#include <fstream>
#include <list>

using namespace talik;
using namespace talik::exchange;
using namespace talik::exchange::test;

namespace {

constexpr int rve_count = 700, steps = 12; // more than a chunk in each farm of two

// Knows its RVEs by their ids in the run, and keeps its sums in files as a real farm does.
class KeepingFarm : public SummingFarm {
public:
    std::vector<std::byte> configure(std::span<const std::byte> payload, Channel&) override {
        on("configure");
        ByteReader in(payload, "configure");
        ids_ = in.array<std::uint32_t>();
        start(static_cast<int>(ids_.size()));
        return {};
    }
    std::vector<std::byte> command(const std::string&, std::span<const std::byte> payload) override {
        on("command");
        ByteReader in(payload, "command");
        for (const std::uint32_t id : in.array<std::uint32_t>()) sums_[std::size_t(id) * 4] += 1000.0;
        return {};
    }
    void checkpoint(const std::string& path) override {
        on("checkpoint");
        ByteWriter out;
        out.array(ids_);
        out.array(sums_);
        memory_.save(out);
        std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(out.bytes().data()), static_cast<std::streamsize>(out.bytes().size()));
    }
    void restore(const std::string& path) override { // of one file, or of a folder of them
        on("restore");
        std::vector<std::filesystem::path> files = {path};
        if (std::filesystem::is_directory(path)) files = {std::filesystem::directory_iterator(path), std::filesystem::directory_iterator()};
        for (const auto& one : files) {
            std::ifstream file(one, std::ios::binary);
            const std::string text((std::istreambuf_iterator<char>(file)), {});
            ByteReader in(std::as_bytes(std::span(text.data(), text.size())), "checkpoint");
            const auto ids = in.array<std::uint32_t>();
            const auto sums = in.array<double>();
            AnswerMemory memory(static_cast<int>(ids.size()), columns_);
            memory.load(in);
            for (std::uint32_t own = 0; own < ids_.size(); ++own)
                for (std::uint32_t there = 0; there < ids.size(); ++there)
                    if (ids[there] == ids_[own]) std::copy_n(&sums[std::size_t(there) * 4], 4, &sums_[std::size_t(own) * 4]), memory_.take(own, memory, there);
        }
    }

private:
    double weight(std::uint32_t id) const override { return 1.0 + ids_[id]; }
    std::vector<std::uint32_t> ids_;
};

// Of the same setup, but with another law.
class OtherFarm : public KeepingFarm {
    double weight(std::uint32_t id) const override { return 2.0 + id; }
};

// Farms as child processes over shared memory. `on` is called in the nth farm started, at each state.
struct Farms {
    using On = std::function<void(int nth, const std::string& state)>;
    explicit Farms(int count, On on_state = [](int, const std::string&) {}) : on(std::move(on_state)) {
        for (int i = 0; i < count; ++i) start();
    }
    Channel& start() {
        const std::string name = unique_name("group");
        const int nth = static_cast<int>(channels.size());
        channels.push_back(make_shm_channel(name, {}));
        children.emplace_back([&, name, nth] {
            KeepingFarm farm;
            farm.on = [&](const std::string& state) { on(nth, state); };
            FarmEnd(*join_shm_channel(name, {}), farm, "keeping-farm").serve();
        });
        return *channels.back();
    }
    std::vector<Channel*> all() const {
        std::vector<Channel*> out;
        for (const auto& channel : channels) out.push_back(channel.get());
        return out;
    }
    On on;
    std::vector<std::unique_ptr<Channel>> channels;
    std::list<Child> children;
};

// Every answer of a run, step by step, in the order of the RVEs.
std::vector<double> run(FarmGroup& group, const std::filesystem::path& checkpoint_at_5, int first = 1, int last = steps, const std::filesystem::path& from = {}) {
    group.connect(driver_hello());
    group.configure(rve_count, [](std::span<const std::uint32_t> rves) {
        ByteWriter out;
        out.array(rves);
        return out.take();
    });
    if (!from.empty()) group.restore(from);
    std::vector<double> values;
    for (int step = first; step <= last; ++step) {
        std::vector<std::uint32_t> rves;
        for (std::uint32_t rve = 0; rve < rve_count; ++rve)
            if ((rve + static_cast<std::uint32_t>(step)) % 3 != 0) rves.push_back(rve_count - 1 - rve); // any subset in any order
        const FarmGroup::Fill fill = [&](std::span<const std::uint32_t> rows, Batch& chunk) {
            for (std::size_t i = 0; i < rows.size(); ++i)
                for (int c = 0; c < 4; ++c) chunk.component(c)[i] = c == 0 ? 1e-3 * step / (1.0 + rves[rows[i]]) : 0.0;
        };
        group.begin_step({static_cast<std::uint64_t>(step), 1e-3, 0}, rves, fill);
        group.finish_step();
        std::vector<double> answers(rve_count, 0.0);
        for (int farm = 0; farm < group.farms(); ++farm)
            for (std::size_t row = 0; row < group.answer(farm).ids().size(); ++row)
                answers[group.rves(farm)[group.answer(farm).ids()[row]]] = group.answer(farm).component(0)[row];
        values.insert(values.end(), answers.begin(), answers.end());
        if (step == 3) group.command_rves("add", std::vector<std::uint32_t>{1, 699, 350});
        if (step == 5 && !checkpoint_at_5.empty()) std::filesystem::create_directories(checkpoint_at_5), group.checkpoint(checkpoint_at_5);
        group.keep_up();
    }
    group.bye();
    return values;
}

const std::vector<double>& reference() {
    static const std::vector<double> kept = [] {
        Farms farms(1);
        FarmGroup group(farms.all());
        return run(group, {});
    }();
    return kept;
}

struct Folder {
    std::filesystem::path path = std::filesystem::temp_directory_path() / unique_name("folder");
    ~Folder() { std::error_code ignored; std::filesystem::remove_all(path, ignored); }
};

Replacement by(Farms& farms, const Folder& folder, int at_most = 3) {
    Replacement how;
    how.at_most = at_most;
    how.another = [&farms](int) -> Channel& { return farms.start(); };
    how.folder = folder.path / "recovery";
    how.interval = 1000.0;
    return how;
}

} // namespace

TEST_CASE("Any number of farms gives the same bits, and so does another number from a checkpoint on", "[exchange][group]") {
    const int count = GENERATE(1, 2, 4);
    CAPTURE(count);
    const Folder folder;
    Farms farms(count);
    FarmGroup group(farms.all());
    REQUIRE(run(group, folder.path / "checkpoint") == reference());
    const int others = count == 4 ? 1 : count + 1;
    Farms later(others);
    FarmGroup regrouped(later.all());
    const std::vector<double> rest = run(regrouped, {}, 6, steps, folder.path / "checkpoint");
    CHECK(rest == std::vector<double>(reference().begin() + 5 * rve_count, reference().end()));
}

TEST_CASE("A farm killed at any state is replaced, and the run ends with the same bits", "[exchange][group]") {
    const int count = GENERATE(1, 2);
    const std::string state = GENERATE(as<std::string>{}, "configure", "answer", "fourth answer", "last answer", "command", "checkpoint");
    CAPTURE(count, state);
    const Folder folder;
    int answers = 0;
    Farms farms(count, [&](int nth, const std::string& at) {
        if (nth != count - 1) return; // the last of the first ones
        if (at == "answer") ++answers;
        if (at == state || (at == "answer" && ((state == "fourth answer" && answers == 4) || (state == "last answer" && answers == steps)))) std::raise(SIGKILL);
    });
    FarmGroup group(farms.all());
    group.replace_lost_farms(by(farms, folder));
    CHECK(run(group, folder.path / "checkpoint") == reference());
    CHECK(group.replaced() == 1);
    CHECK_FALSE(std::filesystem::exists(folder.path / "recovery")); // no half-way checkpoint is left behind
}

TEST_CASE("A replacement that is lost in its turn is replaced as well, and their number is kept", "[exchange][group]") {
    const int at_most = GENERATE(2, 1);
    const Folder folder;
    Farms farms(1, [&](int nth, const std::string& at) {
        if ((nth == 0 && at == "checkpoint") || (nth == 1 && at == "answer")) std::raise(SIGKILL); // the second while it is brought up
    });
    FarmGroup group(farms.all());
    group.replace_lost_farms(by(farms, folder, at_most));
    if (at_most == 2) {
        CHECK(run(group, folder.path / "checkpoint") == reference());
        CHECK(group.replaced() == 2);
    } else {
        ExitCode code = ExitCode::done;
        CHECK(contains(error_text([&] { run(group, folder.path / "checkpoint"); }, &code), "died without a word"));
        CHECK(code == ExitCode::partner_lost);
    }
}

TEST_CASE("A farm that answers with other bits than the one it replaces is not gone on with", "[exchange][group]") {
    const Folder folder;
    Farms farms(1, [&](int nth, const std::string& at) {
        static int answers = 0;
        if (nth == 0 && at == "answer" && ++answers == 4) std::raise(SIGKILL);
    });
    FarmGroup group(farms.all());
    Replacement how = by(farms, folder);
    how.another = [&](int) -> Channel& {
        farms.children.clear(); // of the dead one
        const std::string name = unique_name("other");
        farms.channels.push_back(make_shm_channel(name, {}));
        farms.children.emplace_back([name] {
            OtherFarm farm;
            FarmEnd(*join_shm_channel(name, {}), farm, "another-farm").serve();
        });
        return *farms.channels.back();
    };
    group.replace_lost_farms(how);
    CHECK(contains(error_text([&] { run(group, {}); }), "other bits"));
}

TEST_CASE("Shares are in order, cost about the same, and leave no farm idle while there are RVEs", "[exchange][group]") {
    CHECK(equal_shares(std::vector<double>(8, 1.0), 4) == std::vector<std::uint32_t>{0, 2, 4, 6, 8});
    CHECK(equal_shares(std::vector<double>{1, 1, 1, 1, 4, 4}, 2) == std::vector<std::uint32_t>{0, 5, 6});
    CHECK(equal_shares(std::vector<double>{9, 1, 1}, 3) == std::vector<std::uint32_t>{0, 1, 2, 3});
    CHECK(equal_shares(std::vector<double>{1, 1}, 4) == std::vector<std::uint32_t>{0, 1, 2, 2, 2});
    CHECK(equal_shares({}, 2) == std::vector<std::uint32_t>{0, 0, 0});
}
