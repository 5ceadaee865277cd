#include "exchange/run_board.hpp"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <memory>
#include <new>
#include <sys/mman.h>
#include <sys/stat.h>
#include <tuple>
#include <unistd.h>

namespace talik::exchange {
namespace {

constexpr const char* memory_name = "talik-board";

Board private_board;
std::atomic<Board*> board{&private_board}; // a process may hold both sides, in two threads

void put(char* to, std::size_t room, const std::string& text) { std::strncpy(to, text.c_str(), room - 1); }

// A copy of what another process shows; empty where the file is none of ours.
std::optional<Standing> look_at(const std::filesystem::path& descriptor, int pid) {
    const int file = open(descriptor.c_str(), O_RDONLY | O_CLOEXEC);
    if (file < 0) return std::nullopt;
    alignas(Board) std::array<unsigned char, sizeof(Board)> bytes{};
    const bool whole = pread(file, bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size());
    close(file);
    const auto* seen = reinterpret_cast<const Board*>(bytes.data());
    if (!whole || seen->mark != Board::right_mark) return std::nullopt;
    const auto text = [](const char* from, std::size_t room) { return std::string(from, strnlen(from, room)); };
    const double now = monotonic_seconds();
    Standing s;
    s.pid = pid;
    s.role = seen->role == 0 ? Role::driver : Role::farm;
    s.run_id = seen->run_id;
    s.exchange = text(seen->exchange, sizeof seen->exchange);
    s.title = text(seen->title, sizeof seen->title);
    s.folder = text(seen->folder, sizeof seen->folder);
    s.elapsed = std::max(0.0, now - seen->began);
    s.silent = std::max(0.0, now - seen->updated);
    s.step = seen->step, s.first_step = seen->first_step, s.requests = seen->requests, s.answers = seen->answers, s.rves = seen->rves;
    s.fraction = seen->fraction, s.first_fraction = seen->first_fraction, s.time = seen->time;
    s.computing = seen->computing, s.copying = seen->copying, s.waiting = seen->waiting;
    return s;
}

} // namespace

double monotonic_seconds() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

Board& run_board() { return *board; }

void publish_run_board(Role role, const std::string& exchange, const std::string& title, const std::string& folder) {
    static std::atomic<bool> published{false};
    if (published.exchange(true)) return;
    const int file = memfd_create(memory_name, MFD_CLOEXEC);
    if (file < 0) return;
    void* memory = ftruncate(file, sizeof(Board)) == 0 && fchmod(file, 0600) == 0 ? mmap(nullptr, sizeof(Board), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0) : MAP_FAILED;
    if (memory == MAP_FAILED) {
        close(file);
        return;
    }
    auto* shown = new (memory) Board; // stays open and mapped until the process ends
    shown->role = static_cast<std::uint64_t>(role);
    shown->run_id = run_board().run_id.load();
    put(shown->exchange, sizeof shown->exchange, exchange);
    put(shown->title, sizeof shown->title, title);
    put(shown->folder, sizeof shown->folder, folder);
    shown->began = shown->updated = monotonic_seconds();
    shown->mark = Board::right_mark;
    board = shown;
}

std::vector<Standing> running_programs() {
    namespace fs = std::filesystem;
    std::vector<Standing> found;
    std::error_code unreadable; // processes of others, and those that just ended
    for (const auto& process : fs::directory_iterator("/proc", unreadable)) {
        const std::string pid = process.path().filename().string();
        if (pid.find_first_not_of("0123456789") != std::string::npos) continue;
        std::error_code none;
        for (auto descriptor = fs::directory_iterator(process.path() / "fd", none); !none && descriptor != fs::directory_iterator(); descriptor.increment(none)) {
            const fs::path target = fs::read_symlink(descriptor->path(), unreadable);
            if (!target.string().starts_with(std::string("/memfd:") + memory_name)) continue;
            if (auto standing = look_at(descriptor->path(), std::atoi(pid.c_str()))) found.push_back(std::move(*standing));
            break;
        }
    }
    std::sort(found.begin(), found.end(), [](const Standing& a, const Standing& b) { return std::tuple(a.run_id, a.role, a.pid) < std::tuple(b.run_id, b.role, b.pid); });
    return found;
}

} // namespace talik::exchange
