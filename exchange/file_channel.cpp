#include "exchange/file_channel.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <deque>
#include <thread>

#include "common/base/error.hpp"
#include "common/base/interrupt.hpp"
#include "common/base/log.hpp"
#include "common/io/text_file.hpp"
#include "exchange/file_side.hpp"

namespace talik::exchange {
namespace {

namespace fs = std::filesystem;
constexpr int messages_kept = 8; // of each side, once read
constexpr std::chrono::microseconds shortest_nap{20}, longest_nap{2000};
constexpr const char* mark = "talik-exchange"; // of a folder that exchanges use

class FileChannel final : public Channel {
public:
    FileChannel(Role self, const WaitLimits& wait_limits, const FileOptions& options, const fs::path& folder, std::unique_ptr<OwnSide> own)
        : Channel(self, wait_limits), folder_(folder), most_unread_(options.most_unread_bytes), own_(std::move(own)), partner_(folder, partner_of(self)) {
        use_checksums(true);
        log_ = open((folder_ / fmt::format("{}.log", file_name_of(self))).c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
        own_->sign();
    }
    ~FileChannel() override {
        if (log_ >= 0) close(log_);
    }

    int rows_per_chunk() const override { return 1 << 20; } // a step is one message

    void advance_progress(std::uint64_t done, std::uint64_t total) noexcept override {
        own_->change([&](FileStanding& standing) { standing.progress = {done, total}; }, false);
    }
    PartnerProgress partner_progress() const override { return partner_.standing().progress; }
    void state_cause(const std::string& cause) noexcept override {
        own_->change([&](FileStanding& standing) {
            if (standing.cause.empty()) standing.cause = cause;
            std::replace(standing.cause.begin(), standing.cause.end(), '\n', ' ');
        }, true);
    }
    std::string partner_cause() const override { return partner_.standing().cause; }
    void wish_to_end() noexcept override {
        if (!wished_) own_->change([](FileStanding& standing) { standing.wishes_to_end = true; }, true);
        wished_ = true;
    }
    bool partner_wishes_to_end() const noexcept override { return partner_.standing().wishes_to_end; }

protected:
    std::size_t room() const override {
        while (!unread_.empty() && access(message(role(), unread_.front().number).c_str(), F_OK) != 0) {
            unread_bytes_ -= unread_.front().bytes;
            unread_.pop_front();
        }
        return most_unread_ - std::min(most_unread_, unread_bytes_);
    }
    std::size_t available() const override {
        if (at_ == incoming_.size()) load();
        return incoming_.size() - at_;
    }
    void write(std::span<const std::byte> bytes) override { outgoing_.insert(outgoing_.end(), bytes.begin(), bytes.end()); }
    void flush() override {
        own_->settle(); // progress is on the disk before the answer it led to
        wait([this] { return room() >= outgoing_.size() || unread_.empty(); }); // one larger than the room goes alone
        const std::string path = message(role(), ++written_), part = path + ".part";
        const int file = open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
        if (file < 0) fail_to_write(path, errno);
        std::size_t done = 0;
        while (done < outgoing_.size()) {
            const ssize_t n = ::write(file, outgoing_.data() + done, outgoing_.size() - done);
            if (n < 0 && errno == EINTR) continue;
            if (n < 0) {
                const int error = errno;
                close(file);
                unlink(part.c_str());
                fail_to_write(path, error);
            }
            done += static_cast<std::size_t>(n);
        }
        close(file);
        if (rename(part.c_str(), path.c_str()) != 0) fail_to_write(path, errno);
        unread_.push_back({written_, outgoing_.size()});
        unread_bytes_ += outgoing_.size();
        note('>', written_, outgoing_);
        outgoing_.clear();
    }
    void read(std::span<std::byte> bytes) override {
        while (!bytes.empty()) {
            wait([this] { return available() > 0; });
            const std::size_t n = std::min(bytes.size(), incoming_.size() - at_);
            std::memcpy(bytes.data(), incoming_.data() + at_, n);
            at_ += n;
            bytes = bytes.subspan(n);
        }
        pause_ = shortest_nap;
    }
    // Asking a file system is all that there is: less and less often while nothing comes.
    void nap(const Ready& ready, std::chrono::milliseconds longest) override {
        std::chrono::microseconds slept{0};
        do {
            std::this_thread::sleep_for(pause_);
            slept += pause_;
            pause_ = std::min(2 * pause_, longest_nap);
        } while (slept < longest && !ready());
    }
    PartnerView look() override {
        PartnerView view;
        if (partner_.came()) {
            view.process_alive = partner_.alive(); // asked first: what it wrote before it died is then there
            const FileStanding standing = partner_.standing();
            view.presence = standing.left ? PartnerView::Presence::left : PartnerView::Presence::attached;
            view.progress = standing.progress;
            view.movement = standing.beats + taken_ + (written_ - unread_.size());
            view.cause = standing.cause;
            view.pid = partner_.pid();
            view.process_state = partner_.state();
        }
        view.fate = fate();
        view.process_alive = view.process_alive && view.fate.empty();
        return view;
    }

private:
    struct Unread {
        std::uint64_t number;
        std::size_t bytes;
    };
    std::string message(Role of, std::uint64_t number) const { return (folder_ / fmt::format("{}-{:09}", file_name_of(of), number)).string(); }

    // The next message, if it has come: it is read whole, and kept under read/ for a while.
    void load() const {
        const std::string path = message(partner_of(role()), taken_ + 1);
        const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
        if (file < 0) return;
        struct stat info {};
        fstat(file, &info);
        incoming_.resize(static_cast<std::size_t>(info.st_size));
        std::size_t got = 0;
        for (ssize_t n = 1; got < incoming_.size() && n > 0; got += static_cast<std::size_t>(n)) {
            n = ::read(file, incoming_.data() + got, incoming_.size() - got);
            if (n < 0) n = 0;
        }
        close(file);
        at_ = 0;
        ++taken_;
        FrameHeader header;
        if (got >= sizeof header) std::memcpy(&header, incoming_.data(), sizeof header);
        if (got != incoming_.size() || got < sizeof header || header.payload_bytes != got - sizeof header)
            fail(ExitCode::partner_lost, fmt::format("the partner sends nonsense: {} holds {} bytes, which is no whole message", path, got),
                 "see that nothing else writes into that folder, and restart from the last checkpoint");
        note('<', taken_, incoming_);
        const std::string name = path.substr(path.rfind('/') + 1);
        if (rename(path.c_str(), (folder_ / "read" / name).c_str()) != 0) unlink(path.c_str());
        if (taken_ > messages_kept) unlink((folder_ / "read" / fmt::format("{}-{:09}", file_name_of(partner_of(role())), taken_ - messages_kept)).c_str());
    }

    // A line of the log: "14:07:33.512 > 000000012 step request of step 3, 808112 bytes".
    void note(char way, std::uint64_t number, const std::vector<std::byte>& bytes) const {
        if (log_ < 0) return;
        FrameHeader header;
        std::memcpy(&header, bytes.data(), sizeof header);
        timespec now{};
        clock_gettime(CLOCK_REALTIME, &now);
        tm local{};
        localtime_r(&now.tv_sec, &local);
        char line[160];
        const auto end = fmt::format_to_n(line, sizeof line, "{:02}:{:02}:{:02}.{:03} {} {:09} {} of step {}, {} bytes\n", local.tm_hour, local.tm_min, local.tm_sec,
                                          now.tv_nsec / 1000000, way, number, name_of(static_cast<FrameType>(header.type)), header.step, bytes.size());
        [[maybe_unused]] const auto written = ::write(log_, line, std::min(end.size, sizeof line));
    }

    fs::path folder_;
    std::size_t most_unread_;
    std::unique_ptr<OwnSide> own_;
    PartnerSide partner_;
    int log_ = -1;
    bool wished_ = false;
    std::vector<std::byte> outgoing_;
    std::uint64_t written_ = 0;
    mutable std::deque<Unread> unread_;
    mutable std::size_t unread_bytes_ = 0;
    mutable std::vector<std::byte> incoming_;
    mutable std::size_t at_ = 0;
    mutable std::uint64_t taken_ = 0;
    std::chrono::microseconds pause_ = shortest_nap;
};

void require_own(const fs::path& folder) {
    struct stat info {};
    require(stat(folder.c_str(), &info) == 0 && S_ISDIR(info.st_mode), folder.string() + " is not a folder", "give --exchange file:FOLDER a folder of its own");
    require(info.st_uid == geteuid(), "the exchange folder " + folder.string() + " belongs to another user", "choose another one with --exchange file:FOLDER");
}

// Ours, and nobody else's: what an earlier run left there goes.
std::unique_ptr<OwnSide> claim(const fs::path& folder) {
    if (!fs::exists(folder)) {
        make_folder(folder);
        fs::permissions(folder, fs::perms::owner_all);
    }
    require_own(folder);
    require(fs::is_empty(folder) || fs::exists(folder / mark), "the folder " + folder.string() + " holds files that are no exchange's", "give --exchange file:FOLDER a folder of its own");
    write_file_atomically(folder / mark, "an exchange of mpm-driver and rve-farm; may be removed once neither runs\n");
    auto own = std::make_unique<OwnSide>(folder, Role::driver);
    require(own->held(), "the exchange folder " + folder.string() + " is in use by another run", "choose another one with --exchange file:FOLDER, or end that run");
    std::vector<fs::path> old;
    for (const auto& entry : fs::directory_iterator(folder)) {
        const std::string name = entry.path().filename().string();
        if ((name.starts_with("driver") || name.starts_with("farm")) && entry.is_regular_file() && !name.ends_with(".lock")) old.push_back(entry.path());
    }
    for (const fs::path& path : old) fs::remove(path);
    fs::remove_all(folder / "read");
    make_folder(folder / "read");
    return own;
}

} // namespace

std::unique_ptr<Channel> make_file_channel(const std::string& folder, const WaitLimits& limits, const FileOptions& options) {
    const fs::path path = fs::absolute(folder);
    auto own = claim(path);
    return std::make_unique<FileChannel>(Role::driver, limits, options, path, std::move(own));
}

std::unique_ptr<Channel> join_file_channel(const std::string& folder, const WaitLimits& limits, const FileOptions& options) {
    const fs::path path = fs::absolute(folder);
    const auto begin = std::chrono::steady_clock::now();
    for (bool said = false;;) { // until a driver that lives has signed, and no farm of an earlier run is still about to leave
        const double waited = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        PartnerSide driver(path, Role::driver);
        if (fs::exists(path)) require_own(path);
        if (fs::exists(path / "driver.id") && driver.came() && driver.alive() && !driver.standing().left) {
            auto own = std::make_unique<OwnSide>(path, Role::farm);
            if (own->held()) return std::make_unique<FileChannel>(Role::farm, limits, options, path, std::move(own));
            require(waited < 1.0, "the exchange folder " + path.string() + " already has a farm", "give each run a folder of its own");
        }
        if (!said && waited > 0.5) log::info("waiting for a driver to open the exchange in {}", path.string()), said = true;
        if (waited > limits.attach_seconds)
            fail(ExitCode::partner_lost, fmt::format("no driver opened the exchange in {} within {:g} s", path.string(), limits.attach_seconds), "start mpm-driver with the same --exchange file:FOLDER");
        if (interrupted()) fail(ExitCode::failed, fmt::format("interrupted by {} while waiting for a driver", interrupt_name()), "start again");
        std::this_thread::sleep_for(std::chrono::milliseconds(waited < 0.2 ? 2 : 20));
    }
}

} // namespace talik::exchange
