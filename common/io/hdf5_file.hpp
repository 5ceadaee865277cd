#pragma once
// The only place that names HDF5. Groups, arrays of numbers in one or two dimensions, texts, attributes, and time series
// that grow by a row at a time. Paths inside a file read "/group/array"; missing groups are made on the way.
// A fault is an Error naming file and path: exit code 2 where an input cannot be read, 4 where the disk is full.
// HDF5 is not thread-safe as packaged: use all files from one thread.
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace talik {

template <class Number> class Hdf5Series;

// Rows by columns, one row after the other.
template <class Number>
struct Hdf5Array {
    std::vector<Number> values;
    std::size_t rows = 0, columns = 1;
};

class Hdf5File {
public:
    // growing: for the arrays of hdf5_series.hpp, readable while they grow.
    enum class Layout { fixed, growing };
    // Every file says what wrote it: attributes `program`, `version`, and `format` (its layout, "talik-packing 1").
    static Hdf5File create(const std::string& file, const std::string& program, const std::string& format, Layout layout = Layout::fixed);
    static Hdf5File open(const std::string& file);   // to read
    static Hdf5File extend(const std::string& file); // an existing file, to write on

    Hdf5File(Hdf5File&&) noexcept;
    Hdf5File& operator=(Hdf5File&&) noexcept;
    ~Hdf5File(); // closes; close() says so where that fails
    void close();
    void flush(); // what was written so far survives the end of the process

    const std::string& name() const { return name_; }
    void make_group(const std::string& path);
    bool has(const std::string& path) const;
    std::vector<std::string> children(const std::string& group) const; // in the order of their names

    // Number: double, std::int64_t, std::uint32_t, std::uint8_t. columns = 1 makes a one-dimensional array.
    template <class Number>
    void write(const std::string& path, std::span<const Number> values, std::size_t columns = 1);
    template <class Number>
    void write(const std::string& path, const std::vector<Number>& values, std::size_t columns = 1) {
        write(path, std::span<const Number>(values), columns);
    }
    template <class Number>
    Hdf5Array<Number> read(const std::string& path) const;

    // Adds one row to a series (rows by row.size()); the first call makes it.
    template <class Number>
    void append(const std::string& path, std::span<const Number> row);

    void write_text(const std::string& path, const std::string& text);
    std::string read_text(const std::string& path) const;

    // Attributes of the object at `path` ("/" is the file itself).
    void set_attribute(const std::string& path, const std::string& key, const std::string& value);
    void set_attribute(const std::string& path, const std::string& key, double value);
    void set_attribute(const std::string& path, const std::string& key, std::int64_t value);
    bool has_attribute(const std::string& path, const std::string& key) const;
    std::string text_attribute(const std::string& path, const std::string& key) const;
    double number_attribute(const std::string& path, const std::string& key) const;
    std::int64_t integer_attribute(const std::string& path, const std::string& key) const;
    void require_format(const std::string& format) const; // the attribute `format` must read so

private:
    template <class Number> friend class Hdf5Series;
    friend void start_growth(Hdf5File& file);
    struct Handle;
    Hdf5File(std::string name, std::unique_ptr<Handle> handle);
    std::string name_;
    std::unique_ptr<Handle> handle_;
};

// Of a file that is about to be replaced: there is none, an empty one, or one of this format (of a damaged one the first bytes
// tell). Anything else, a scene or a device, is somebody's, and refused.
void require_replaceable(const std::string& file, const std::string& format, const std::string& remedy);

} // namespace talik
