#pragma once
// A fast 64-bit checksum against accidents (not against intent): four lanes of multiply and rotate. Each step is a
// bijection of its lane, so a change in one word can never cancel.
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>

namespace talik::exchange {

inline std::uint64_t checksum(std::span<const std::byte> bytes, std::uint64_t seed = 0) {
    constexpr std::uint64_t odd = 0x9e3779b97f4a7c15u;
    std::uint64_t lane[4] = {seed ^ 0x243f6a8885a308d3u, 0x13198a2e03707344u, 0xa4093822299f31d0u, 0x082efa98ec4e6c89u};
    const auto absorb = [&](int l, std::uint64_t word) { lane[l] = std::rotl((lane[l] ^ word) * odd, 29); };
    std::size_t i = 0;
    for (; i + 32 <= bytes.size(); i += 32)
        for (int l = 0; l < 4; ++l) {
            std::uint64_t word;
            std::memcpy(&word, bytes.data() + i + 8 * static_cast<std::size_t>(l), 8);
            absorb(l, word);
        }
    for (int l = 0; i < bytes.size(); i += 8, ++l) { // the last, incomplete stripe, filled up with zeros
        std::uint64_t word = 0;
        std::memcpy(&word, bytes.data() + i, bytes.size() - i < 8 ? bytes.size() - i : 8);
        absorb(l, word);
    }
    std::uint64_t sum = bytes.size(); // the length counts, so the zeros filled up with do not pass for data
    for (std::uint64_t l : lane) sum = (sum ^ l) * odd, sum ^= sum >> 32;
    return sum;
}

inline std::uint64_t checksum(std::string_view text, std::uint64_t seed = 0) {
    return checksum(std::as_bytes(std::span(text.data(), text.size())), seed);
}

} // namespace talik::exchange
