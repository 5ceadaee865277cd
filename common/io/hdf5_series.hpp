#pragma once
// Arrays that grow row by row in a file that is readable at any moment, by other programs too, also after its writer was
// killed: HDF5's single-writer mode keeps what is on disk whole after every flush. Declare every array, start the growth,
// then append. A row is a chunk of its own, so that a reader takes one row at a time.
//
//     Hdf5File file = create_growing_file("record.h5", "mpm-driver", "talik-record 1");
//     Hdf5Series<double> values(file, "/values", {4, 298}, RowStorage::deflated);
//     start_growth(file);
//     values.append(row); flush
#include <cstddef>
#include <vector>

#include "common/io/hdf5_file.hpp"

namespace talik {

enum class RowStorage { plain, deflated };

// Chunks of rows already packed as HDF5's shuffle and deflate filters would: the work may then be done by another thread.
// scratch and packed keep their memory from row to row.
void pack_row(std::span<const double> row, std::vector<std::byte>& scratch, std::vector<std::byte>& packed);

Hdf5File create_growing_file(const std::string& file, const std::string& program, const std::string& format);
void start_growth(Hdf5File& file); // after the last array and attribute was made

template <class Number> // double, std::int64_t, std::uint8_t
class Hdf5Series {
public:
    // Makes the array [0, shape...]; rows_per_chunk > 1 for rows that are small.
    Hdf5Series(Hdf5File& file, const std::string& path, const std::vector<std::size_t>& shape, RowStorage storage, std::size_t rows_per_chunk = 1);
    // To read one that is there.
    Hdf5Series(const Hdf5File& file, const std::string& path);
    ~Hdf5Series();
    Hdf5Series(Hdf5Series&&) noexcept;
    Hdf5Series& operator=(Hdf5Series&&) = delete;

    std::size_t rows() const { return rows_; }
    std::size_t row_size() const { return row_size_; }
    const std::vector<std::size_t>& shape() const { return shape_; } // of a row

    void append(std::span<const Number> rows);             // any number of whole rows
    void append_packed(std::span<const std::byte> packed); // one row, from pack_row(); storage: deflated
    void append_nothing();                                 // one row of zeros, which takes no space
    void read(std::size_t row, std::span<Number> out) const; // out.size(): one or more whole rows

private:
    void grow(std::size_t more);
    std::string place_;
    std::vector<std::size_t> shape_;
    std::size_t rows_ = 0, row_size_ = 1;
    std::int64_t data_ = -1; // HDF5's identifier
};

} // namespace talik
