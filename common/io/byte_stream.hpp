#pragma once
// Payloads that are not batches: written and read field by field, in the machine's byte order (the handshake compares
// it). Reading is bounds checked: a malformed payload is an error with a name, never a crash.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "common/base/error.hpp"

namespace talik {

class ByteWriter {
public:
    template <class T>
    void put(const T& value) {
        static_assert(std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>);
        append(&value, sizeof(T));
    }
    void text(std::string_view value) {
        put(static_cast<std::uint64_t>(value.size()));
        append(value.data(), value.size());
    }
    template <class T>
    void array(std::span<const T> values) {
        static_assert(std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>);
        put(static_cast<std::uint64_t>(values.size()));
        append(values.data(), values.size_bytes());
    }
    template <class T>
    void array(const std::vector<T>& values) {
        array(std::span<const T>(values));
    }

    const std::vector<std::byte>& bytes() const { return bytes_; }
    std::vector<std::byte> take() { return std::move(bytes_); }

private:
    void append(const void* data, std::size_t size) {
        const auto* first = static_cast<const std::byte*>(data);
        bytes_.insert(bytes_.end(), first, first + size);
    }
    std::vector<std::byte> bytes_;
};

class ByteReader {
public:
    // what: the name of the payload in an error, such as "hello".
    ByteReader(std::span<const std::byte> bytes, std::string what) : rest_(bytes), what_(std::move(what)) {}

    template <class T>
    T get() {
        static_assert(std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>);
        T value;
        std::memcpy(&value, take(sizeof(T)).data(), sizeof(T));
        return value;
    }
    std::string text() {
        const auto bytes = take(count_of(1));
        return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    }
    template <class T>
    std::vector<T> array() {
        static_assert(std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>);
        const std::size_t count = count_of(sizeof(T)); // checked against the rest before anything is allocated
        std::vector<T> values(count);
        const auto bytes = take(count * sizeof(T));
        if (count > 0) std::memcpy(values.data(), bytes.data(), bytes.size());
        return values;
    }

    std::span<const std::byte> rest() const { return rest_; }
    void finish() const { check(rest_.empty(), "longer than its fields"); }

private:
    std::size_t count_of(std::size_t size) {
        const auto count = get<std::uint64_t>();
        check(count <= rest_.size() / size, "shorter than its fields");
        return static_cast<std::size_t>(count);
    }
    std::span<const std::byte> take(std::size_t size) {
        check(size <= rest_.size(), "shorter than its fields");
        const auto bytes = rest_.first(size);
        rest_ = rest_.subspan(size);
        return bytes;
    }
    void check(bool holds, const char* problem) const {
        if (!holds)
            fail(ExitCode::partner_lost, "malformed message: the payload of " + what_ + " is " + problem,
                 "both programs must come from the same version of Talik");
    }
    std::span<const std::byte> rest_;
    std::string what_;
};

} // namespace talik
