#include "common/io/hdf5_series.hpp"

#include <utility>
#include <zlib.h>

#include "common/io/hdf5_handle.hpp"

namespace talik {

using namespace hdf5;

void pack_row(std::span<const double> row, std::vector<std::byte>& scratch, std::vector<std::byte>& packed) {
    const auto bytes = std::as_bytes(row);
    scratch.resize(bytes.size());
    for (std::size_t byte = 0; byte < sizeof(double); ++byte) // first bytes of all numbers, then their second ones, ...
        for (std::size_t i = 0; i < row.size(); ++i) scratch[byte * row.size() + i] = bytes[i * sizeof(double) + byte];
    uLongf size = compressBound(static_cast<uLong>(scratch.size()));
    packed.resize(size);
    const int fault = compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(scratch.data()),
                                static_cast<uLong>(scratch.size()), 1);
    ensure(fault == Z_OK);
    packed.resize(size);
}

Hdf5File create_growing_file(const std::string& file, const std::string& program, const std::string& format) {
    return Hdf5File::create(file, program, format, Hdf5File::Layout::growing);
}

void start_growth(Hdf5File& file) { written(H5Fstart_swmr_write(file.handle_->id), file.name()); }

template <class Number>
Hdf5Series<Number>::Hdf5Series(Hdf5File& file, const std::string& path, const std::vector<std::size_t>& shape, RowStorage storage,
                               std::size_t rows_per_chunk)
    : place_(file.name() + ": " + path), shape_(shape) {
    std::vector<hsize_t> sizes = {0}, limits = {H5S_UNLIMITED}, chunk = {rows_per_chunk};
    for (const std::size_t size : shape) {
        ensure(size > 0);
        for (auto* list : {&sizes, &limits, &chunk}) list->push_back(size);
        row_size_ *= size;
    }
    file.make_group(path.substr(0, path.rfind('/')));
    const Id space(H5Screate_simple(static_cast<int>(sizes.size()), sizes.data(), limits.data()), H5Sclose), creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    H5Pset_chunk(creation, static_cast<int>(chunk.size()), chunk.data());
    if (storage == RowStorage::deflated) {
        H5Pset_shuffle(creation);
        H5Pset_deflate(creation, 1);
    }
    data_ = written(H5Dcreate2(file.handle_->id, path.c_str(), type_of<Number>(), space, H5P_DEFAULT, creation, H5P_DEFAULT), place_);
}

template <class Number>
Hdf5Series<Number>::Hdf5Series(const Hdf5File& file, const std::string& path) : place_(file.name() + ": " + path) {
    if (!file.has(path)) fail_to_read(place_, "is missing");
    data_ = H5Dopen2(file.handle_->id, path.c_str(), H5P_DEFAULT);
    if (data_ < 0) fail_to_read(place_, "is not an array");
    const Id space(H5Dget_space(data_), H5Sclose);
    std::vector<hsize_t> sizes(static_cast<std::size_t>(std::max(0, H5Sget_simple_extent_ndims(space))));
    const Id type(H5Dget_type(data_), H5Tclose);
    if (sizes.empty() || H5Tget_class(type) != H5Tget_class(type_of<Number>())) fail_to_read(place_, "is not an array of the expected kind");
    H5Sget_simple_extent_dims(space, sizes.data(), nullptr);
    rows_ = sizes[0];
    for (std::size_t i = 1; i < sizes.size(); ++i) {
        shape_.push_back(sizes[i]);
        row_size_ *= sizes[i];
    }
}

template <class Number>
Hdf5Series<Number>::~Hdf5Series() {
    if (data_ >= 0) H5Dclose(data_);
}

template <class Number>
Hdf5Series<Number>::Hdf5Series(Hdf5Series&& other) noexcept
    : place_(std::move(other.place_)), shape_(std::move(other.shape_)), rows_(other.rows_), row_size_(other.row_size_),
      data_(std::exchange(other.data_, -1)) {}

template <class Number>
void Hdf5Series<Number>::grow(std::size_t more) {
    std::vector<hsize_t> sizes = {rows_ + more};
    sizes.insert(sizes.end(), shape_.begin(), shape_.end());
    written(H5Dset_extent(data_, sizes.data()), place_);
}

template <class Number>
void Hdf5Series<Number>::append(std::span<const Number> rows) {
    ensure(rows.size() % row_size_ == 0);
    const std::size_t more = rows.size() / row_size_;
    if (more == 0) return;
    grow(more);
    std::vector<hsize_t> begin(shape_.size() + 1, 0), count = {more};
    begin[0] = rows_;
    count.insert(count.end(), shape_.begin(), shape_.end());
    const Id in_file(H5Dget_space(data_), H5Sclose), in_memory(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr), H5Sclose);
    H5Sselect_hyperslab(in_file, H5S_SELECT_SET, begin.data(), nullptr, count.data(), nullptr);
    written(H5Dwrite(data_, type_of<Number>(), in_memory, in_file, H5P_DEFAULT, rows.data()), place_);
    rows_ += more;
}

template <class Number>
void Hdf5Series<Number>::append_packed(std::span<const std::byte> packed) {
    grow(1);
    std::vector<hsize_t> begin(shape_.size() + 1, 0);
    begin[0] = rows_;
    written(H5Dwrite_chunk(data_, H5P_DEFAULT, 0, begin.data(), packed.size(), packed.data()), place_);
    ++rows_;
}

template <class Number>
void Hdf5Series<Number>::append_nothing() {
    grow(1);
    ++rows_;
}

template <class Number>
void Hdf5Series<Number>::read(std::size_t row, std::span<Number> out) const {
    ensure(out.size() % row_size_ == 0 && row + out.size() / row_size_ <= rows_);
    if (out.empty()) return;
    std::vector<hsize_t> begin(shape_.size() + 1, 0), count = {out.size() / row_size_};
    begin[0] = row;
    count.insert(count.end(), shape_.begin(), shape_.end());
    const Id in_file(H5Dget_space(data_), H5Sclose), in_memory(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr), H5Sclose);
    H5Sselect_hyperslab(in_file, H5S_SELECT_SET, begin.data(), nullptr, count.data(), nullptr);
    if (H5Dread(data_, type_of<Number>(), in_memory, in_file, H5P_DEFAULT, out.data()) < 0) fail_to_read(place_, "is damaged");
}

template class Hdf5Series<double>;
template class Hdf5Series<std::int64_t>;
template class Hdf5Series<std::uint8_t>;

} // namespace talik
