#include "common/io/vtu.hpp"

#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <cstring>

#include "common/base/error.hpp"
#include "common/base/version.hpp"
#include "common/io/text_file.hpp"

namespace talik {
namespace {

static_assert(std::endian::native == std::endian::little);

// Appended raw data: each block is its length in bytes (UInt64) and then the bytes.
class AppendedData {
public:
    template <class T>
    std::size_t add(std::span<const T> values) {
        const std::size_t offset = bytes_.size();
        const std::uint64_t length = values.size_bytes();
        bytes_.append(reinterpret_cast<const char*>(&length), sizeof length);
        bytes_.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
        return offset;
    }
    const std::string& bytes() const { return bytes_; }

private:
    std::string bytes_;
};

std::string xml_text(const std::string& text) {
    std::string out;
    for (char c : text) {
        if (c == '&') out += "&amp;";
        else if (c == '<') out += "&lt;";
        else if (c == '"') out += "&quot;";
        else out += c;
    }
    return out;
}

} // namespace

void write_vtu(const std::filesystem::path& path, std::span<const double> positions, const std::vector<PointArray>& arrays) {
    const std::size_t count = positions.size() / 3;
    std::vector<std::int64_t> connectivity(count), offsets(count);
    for (std::size_t i = 0; i < count; ++i) {
        connectivity[i] = static_cast<std::int64_t>(i);
        offsets[i] = static_cast<std::int64_t>(i) + 1;
    }
    const std::vector<std::uint8_t> types(count, 1); // VTK_VERTEX

    AppendedData data;
    const auto row = [](const char* type, const std::string& name, int components, std::size_t offset) {
        return fmt::format("<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"/>\n",
                           type, xml_text(name), components, offset);
    };
    std::string xml = fmt::format("<?xml version=\"1.0\"?>\n<!-- written by Talik {} -->\n", version());
    xml += "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
           "<UnstructuredGrid>\n";
    xml += fmt::format("<Piece NumberOfPoints=\"{0}\" NumberOfCells=\"{0}\">\n<PointData>\n", count);
    for (const auto& array : arrays) {
        ensure(array.data.size() == count * static_cast<std::size_t>(array.components));
        xml += row("Float64", array.name, array.components, data.add(array.data));
    }
    xml += "</PointData>\n<Points>\n" + row("Float64", "position", 3, data.add(positions)) + "</Points>\n<Cells>\n";
    xml += row("Int64", "connectivity", 1, data.add(std::span<const std::int64_t>(connectivity)));
    xml += row("Int64", "offsets", 1, data.add(std::span<const std::int64_t>(offsets)));
    xml += row("UInt8", "types", 1, data.add(std::span<const std::uint8_t>(types)));
    xml += "</Cells>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_" + data.bytes() +
           "\n</AppendedData>\n</VTKFile>\n";
    write_file_atomically(path, xml);
}

void write_pvd(const std::filesystem::path& path, const std::vector<SeriesEntry>& entries) {
    std::string xml = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n";
    for (const auto& entry : entries)
        xml += fmt::format("<DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", entry.time, xml_text(entry.file));
    write_file_atomically(path, xml + "</Collection>\n</VTKFile>\n");
}

} // namespace talik
