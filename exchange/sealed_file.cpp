#include "exchange/sealed_file.hpp"

#include <cerrno>
#include <cstdio>
#include <memory>
#include <vector>

#include "common/base/error.hpp"
#include "common/io/text_file.hpp"
#include "exchange/checksum.hpp"

namespace talik::exchange {
namespace {

constexpr char mark[9] = "TalikSum"; // 8 bytes of it, then the 8 of the checksum
constexpr std::uintmax_t seal_bytes = 16;

struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, Close>;

[[noreturn]] void fail_damaged(const std::filesystem::path& path, const std::string& problem) {
    throw Error(ExitCode::bad_input, path.string(), problem, "take another checkpoint");
}

// Of the first `size` bytes, a piece at a time: the state of a large farm need not fit into memory twice.
std::uint64_t sum_of(std::FILE* file, std::uintmax_t size, const std::filesystem::path& path) {
    std::vector<std::byte> piece(1 << 20);
    std::uint64_t sum = 0;
    for (std::uintmax_t left = size; left > 0;) {
        const std::size_t wanted = left < piece.size() ? static_cast<std::size_t>(left) : piece.size();
        if (std::fread(piece.data(), 1, wanted, file) != wanted) fail_damaged(path, "cannot be read to its end");
        sum = checksum(std::span<const std::byte>(piece.data(), wanted), sum);
        left -= wanted;
    }
    return sum;
}

} // namespace

void seal(const std::filesystem::path& path) {
    File file(std::fopen(path.c_str(), "r+be"));
    if (!file) fail_to_write(path, errno);
    const std::uint64_t sum = sum_of(file.get(), std::filesystem::file_size(path), path);
    std::fseek(file.get(), 0, SEEK_END); // between reading and writing C asks for a seek
    const bool written = std::fwrite(mark, 1, 8, file.get()) == 8 && std::fwrite(&sum, 1, sizeof sum, file.get()) == sizeof sum;
    if (!written || std::fclose(file.release()) != 0) fail_to_write(path, errno); // a full disk may show only at the close
}

void require_sealed(const std::filesystem::path& path) {
    const File file(std::fopen(path.c_str(), "rbe"));
    if (!file) fail_damaged(path, "cannot be read, the checkpoint is damaged");
    std::error_code none;
    const std::uintmax_t size = std::filesystem::file_size(path, none);
    if (none || size < seal_bytes) fail_damaged(path, "is damaged: it is not whole");
    const std::uint64_t sum = sum_of(file.get(), size - seal_bytes, path);
    char found_mark[8];
    std::uint64_t found_sum = 0;
    const bool read = std::fread(found_mark, 1, sizeof found_mark, file.get()) == sizeof found_mark &&
                      std::fread(&found_sum, 1, sizeof found_sum, file.get()) == sizeof found_sum;
    if (!read || std::memcmp(found_mark, mark, sizeof found_mark) != 0) fail_damaged(path, "is damaged: its end, with the checksum, is missing");
    if (found_sum != sum) fail_damaged(path, "is damaged: its checksum is not that of its bytes");
}

} // namespace talik::exchange
