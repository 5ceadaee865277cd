#include <algorithm>
#include <filesystem>
#include <fstream>
#include <utility>

#include "common/base/version.hpp"
#include "common/io/hdf5_handle.hpp"

namespace talik {

using namespace hdf5;

namespace {

// HDF5 prints its own faults unless told not to: ours are one line each. Old enough a layout for every reader of 1.10.
hid_t silent_access() {
    // No clean-up at exit: after a file that a full disk cut short it would end the process by SIGSEGV. Files close themselves.
    static const herr_t once = H5dont_atexit();
    static_cast<void>(once);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    H5Pset_libver_bounds(access, H5F_LIBVER_EARLIEST, H5F_LIBVER_V110);
    return access;
}

Id makes_groups() {
    const hid_t properties = H5Pcreate(H5P_LINK_CREATE);
    H5Pset_create_intermediate_group(properties, 1);
    return Id(properties, H5Pclose);
}

} // namespace

Hdf5File::Hdf5File(std::string name, std::unique_ptr<Handle> handle) : name_(std::move(name)), handle_(std::move(handle)) {}
Hdf5File::Hdf5File(Hdf5File&&) noexcept = default;
Hdf5File& Hdf5File::operator=(Hdf5File&&) noexcept = default;
Hdf5File::~Hdf5File() = default;

Hdf5File Hdf5File::create(const std::string& file, const std::string& program, const std::string& format, Layout layout) {
    const Id access(silent_access(), H5Pclose);
    if (layout == Layout::growing) H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110); // what single-writer mode asks for
    auto handle = std::make_unique<Handle>();
    handle->id = written(H5Fcreate(file.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access), file);
    Hdf5File made(file, std::move(handle));
    made.set_attribute("/", "program", program);
    made.set_attribute("/", "version", version());
    made.set_attribute("/", "format", format);
    return made;
}

Hdf5File Hdf5File::open(const std::string& file) {
    const Id access(silent_access(), H5Pclose);
    if (!std::filesystem::exists(file)) throw Error(ExitCode::bad_input, file, "does not exist", "check the path");
    auto handle = std::make_unique<Handle>();
    handle->id = H5Fopen(file.c_str(), H5F_ACC_RDONLY, access);
    if (handle->id < 0) handle->id = H5Fopen(file.c_str(), H5F_ACC_RDONLY | H5F_ACC_SWMR_READ, access); // still growing, or its writer was killed
    if (handle->id < 0) fail_to_read(file, "is not a readable HDF5 file");
    return Hdf5File(file, std::move(handle));
}

Hdf5File Hdf5File::extend(const std::string& file) {
    const Id access(silent_access(), H5Pclose);
    auto handle = std::make_unique<Handle>();
    handle->id = H5Fopen(file.c_str(), H5F_ACC_RDWR, access);
    if (handle->id < 0) fail_to_read(file, "cannot be opened for writing");
    return Hdf5File(file, std::move(handle));
}

void Hdf5File::close() {
    if (!handle_ || handle_->id < 0) return;
    flush(); // a full disk shows here, while the file can still be named
    written(H5Fclose(std::exchange(handle_->id, -1)), name_);
}

void Hdf5File::flush() { written(H5Fflush(handle_->id, H5F_SCOPE_GLOBAL), name_); }

void Hdf5File::make_group(const std::string& path) {
    if (!has(path)) Id(written(H5Gcreate2(handle_->id, path.c_str(), makes_groups(), H5P_DEFAULT, H5P_DEFAULT), name_ + ": " + path), H5Gclose);
}

bool Hdf5File::has(const std::string& path) const {
    if (path == "/") return true;
    for (std::size_t slash = path.find('/', 1);; slash = path.find('/', slash + 1)) { // each group on the way must be there
        if (H5Lexists(handle_->id, path.substr(0, slash).c_str(), H5P_DEFAULT) <= 0) return false;
        if (slash == std::string::npos) return true;
    }
}

std::vector<std::string> Hdf5File::children(const std::string& group) const {
    std::vector<std::string> names;
    const auto collect = [](hid_t, const char* name, const H5L_info_t*, void* out) -> herr_t {
        static_cast<std::vector<std::string>*>(out)->emplace_back(name);
        return 0;
    };
    if (!has(group) || H5Literate_by_name(handle_->id, group.c_str(), H5_INDEX_NAME, H5_ITER_INC, nullptr, collect, &names, H5P_DEFAULT) < 0)
        fail_to_read(name_ + ": " + group, "is missing");
    return names;
}

template <class Number>
void Hdf5File::write(const std::string& path, std::span<const Number> values, std::size_t columns) {
    ensure(columns > 0 && values.size() % columns == 0);
    const std::string place = name_ + ": " + path;
    const hsize_t sizes[2] = {values.size() / columns, columns};
    const Id space(H5Screate_simple(columns == 1 ? 1 : 2, sizes, nullptr), H5Sclose);
    const Id data(written(H5Dcreate2(handle_->id, path.c_str(), type_of<Number>(), space, makes_groups(), H5P_DEFAULT, H5P_DEFAULT), place), H5Dclose);
    if (!values.empty()) written(H5Dwrite(data, type_of<Number>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), place);
}

template <class Number>
Hdf5Array<Number> Hdf5File::read(const std::string& path) const {
    const std::string place = name_ + ": " + path;
    if (!has(path)) fail_to_read(place, "is missing");
    const Id data(H5Dopen2(handle_->id, path.c_str(), H5P_DEFAULT), H5Dclose);
    if (data < 0) fail_to_read(place, "is not an array");
    const Id space(H5Dget_space(data), H5Sclose), type(H5Dget_type(data), H5Tclose);
    hsize_t sizes[2] = {0, 1};
    const int dimensions = H5Sget_simple_extent_ndims(space);
    const bool whole = H5Tget_class(type_of<Number>()) == H5T_INTEGER;
    if (dimensions < 1 || dimensions > 2 || (H5Tget_class(type) != H5T_INTEGER && (whole || H5Tget_class(type) != H5T_FLOAT)))
        fail_to_read(place, "is not an array of the expected kind");
    H5Sget_simple_extent_dims(space, sizes, nullptr);
    Hdf5Array<Number> result;
    result.rows = sizes[0];
    result.columns = sizes[1];
    result.values.resize(sizes[0] * sizes[1]);
    if (!result.values.empty() && H5Dread(data, type_of<Number>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, result.values.data()) < 0)
        fail_to_read(place, "is damaged");
    return result;
}

template <class Number>
void Hdf5File::append(const std::string& path, std::span<const Number> row) {
    const std::string place = name_ + ": " + path;
    const hsize_t width = row.size();
    ensure(width > 0);
    if (!has(path)) {
        const hsize_t sizes[2] = {0, width}, limits[2] = {H5S_UNLIMITED, width};
        const hsize_t chunk[2] = {std::max<hsize_t>(1, 4096 / width), width}; // about 32 kB a chunk
        const Id space(H5Screate_simple(2, sizes, limits), H5Sclose), creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
        H5Pset_chunk(creation, 2, chunk);
        Id(written(H5Dcreate2(handle_->id, path.c_str(), type_of<Number>(), space, makes_groups(), creation, H5P_DEFAULT), place), H5Dclose);
    }
    const Id data(written(H5Dopen2(handle_->id, path.c_str(), H5P_DEFAULT), place), H5Dclose);
    hsize_t sizes[2] = {0, 0};
    H5Sget_simple_extent_dims(Id(H5Dget_space(data), H5Sclose), sizes, nullptr);
    ensure(sizes[1] == width);
    const hsize_t grown[2] = {sizes[0] + 1, width}, begin[2] = {sizes[0], 0}, count[2] = {1, width};
    written(H5Dset_extent(data, grown), place);
    const Id file_space(H5Dget_space(data), H5Sclose), memory(H5Screate_simple(2, count, nullptr), H5Sclose);
    H5Sselect_hyperslab(file_space, H5S_SELECT_SET, begin, nullptr, count, nullptr);
    written(H5Dwrite(data, type_of<Number>(), memory, file_space, H5P_DEFAULT, row.data()), place);
}

void Hdf5File::write_text(const std::string& path, const std::string& text) {
    write(path, std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

std::string Hdf5File::read_text(const std::string& path) const {
    const auto bytes = read<std::uint8_t>(path).values;
    return std::string(bytes.begin(), bytes.end());
}

namespace {

bool begins_as_hdf5(const std::string& file) {
    const std::string signature = "\x89HDF\r\n\x1a\n";
    std::string begin(signature.size(), '\0');
    return std::ifstream(file, std::ios::binary).read(begin.data(), static_cast<std::streamsize>(begin.size())) && begin == signature;
}

// Empty where it cannot be told, as in a file that was cut.
std::string format_of(const std::string& file) {
    try {
        const Hdf5File old = Hdf5File::open(file);
        return old.has_attribute("/", "format") ? old.text_attribute("/", "format") : "none";
    } catch (const Error&) {
        return "";
    }
}

} // namespace

void require_replaceable(const std::string& file, const std::string& format, const std::string& remedy) {
    namespace fs = std::filesystem;
    std::error_code none;
    const auto refuse = [&](const std::string& problem) { throw Error(ExitCode::bad_input, file, problem, remedy); };
    for (const std::string& place : {file, file + ".part"}) // what is written first
        if (const fs::file_status status = fs::status(place, none); fs::exists(status) && !fs::is_regular_file(status))
            throw Error(ExitCode::bad_input, place, fs::is_directory(status) ? "is a folder" : "is no regular file", remedy);
    if (!fs::exists(file, none) || fs::file_size(file, none) == 0) return;
    if (!begins_as_hdf5(file)) refuse("is there already, and is no file of the format \"" + format + "\": it would be lost");
    if (const std::string found = format_of(file); !found.empty() && found != format) refuse("is there already, and has the format \"" + found + "\": it would be lost");
}

#define TALIK_HDF5_NUMBER(Number)                                                                        \
    template void Hdf5File::write<Number>(const std::string&, std::span<const Number>, std::size_t);     \
    template Hdf5Array<Number> Hdf5File::read<Number>(const std::string&) const;                         \
    template void Hdf5File::append<Number>(const std::string&, std::span<const Number>);
TALIK_HDF5_NUMBER(double)
TALIK_HDF5_NUMBER(std::int64_t)
TALIK_HDF5_NUMBER(std::uint32_t)
TALIK_HDF5_NUMBER(std::uint8_t)

} // namespace talik
