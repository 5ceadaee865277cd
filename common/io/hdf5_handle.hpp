#pragma once
// Inside common/io only: HDF5 identifiers that close themselves, and HDF5's faults as our errors.
#include <string>

#include <hdf5.h>

#include "common/base/error.hpp"
#include "common/io/hdf5_file.hpp"

namespace talik::hdf5 {

class Id {
public:
    using Close = herr_t (*)(hid_t);
    Id(hid_t id, Close close) : id_(id), close_(close) {}
    Id(const Id&) = delete;
    Id& operator=(const Id&) = delete;
    ~Id() { if (id_ >= 0) close_(id_); }
    operator hid_t() const { return id_; }

private:
    hid_t id_;
    Close close_;
};

// The texts of HDF5's error stack, innermost last; emptied by the next call of the library.
inline std::string error_stack() {
    std::string text;
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_DOWNWARD,
             [](unsigned, const H5E_error2_t* error, void* out) -> herr_t {
                 static_cast<std::string*>(out)->append(error->desc ? error->desc : "").append("; ");
                 return 0;
             },
             &text);
    return text;
}

inline bool disk_is_full(const std::string& stack) {
    return stack.find("No space left") != std::string::npos || stack.find("quota") != std::string::npos ||
           stack.find("File too large") != std::string::npos;
}

[[noreturn]] inline void fail_to_write(const std::string& place) {
    if (disk_is_full(error_stack())) throw Error(ExitCode::out_of_resource, place, "cannot be written: the disk is full", "free some space, or write to another disk");
    throw Error(ExitCode::bad_input, place, "cannot be written", "check that the folder exists and that you may write there");
}

[[noreturn]] inline void fail_to_read(const std::string& place, const std::string& what) {
    throw Error(ExitCode::bad_input, place, what, "take a file written by this version of Talik, or write it anew");
}

template <class Result> // of a call that returns a negative number when it fails
Result written(Result result, const std::string& place) {
    if (result < 0) fail_to_write(place);
    return result;
}

template <class Number> hid_t type_of();
template <> inline hid_t type_of<double>() { return H5T_NATIVE_DOUBLE; }
template <> inline hid_t type_of<std::int64_t>() { return H5T_NATIVE_INT64; }
template <> inline hid_t type_of<std::uint32_t>() { return H5T_NATIVE_UINT32; }
template <> inline hid_t type_of<std::uint8_t>() { return H5T_NATIVE_UINT8; }

} // namespace talik::hdf5

struct talik::Hdf5File::Handle {
    hid_t id = -1;
    ~Handle() { if (id >= 0) H5Fclose(id); }
};
