#pragma once
// Points over time: fields.h5 (a group per output time) and fields.pvd with one .vtu each, which ParaView opens directly.
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "common/io/hdf5_file.hpp"
#include "common/io/vtu.hpp"

namespace talik::driver {

// One quantity of all points.
struct FieldColumn {
    std::string name;        // "equivalent_strain"
    std::string unit;        // "Pa", "-"
    int components = 1;
    std::vector<double> data; // `components` values per point, one point after the other
};

class FieldsWriter {
public:
    // keep_through_step: outputs of an earlier run in the same folder up to this step stay (restart); -1 = all anew.
    FieldsWriter(std::filesystem::path folder, std::int64_t keep_through_step);

    // columns must hold "position" (2 components). The file is closed after each output: readable after a kill.
    void write(std::int64_t step, double time, double thickness, const std::vector<FieldColumn>& columns);

private:
    void keep_outputs(const std::filesystem::path& from, std::int64_t through_step, Hdf5File& to);

    std::filesystem::path folder_;
    std::vector<SeriesEntry> series_;
    int next_ = 0;
};

} // namespace talik::driver
