#pragma once
// Curves of element tests as files: curves.csv of each RVE, mean and standard deviation over all, and everything in HDF5.
#include <filesystem>
#include <string>
#include <vector>

#include "rve-farm/element/element_test.hpp"

namespace talik::farm {

// Column names carry unit and sign: strains and stresses compression positive, except what says otherwise.
const std::vector<std::string>& element_columns();
std::vector<double> element_values(const ElementRow& row);

// FOLDER/rve-0000.csv, ...; mean.csv (columns NAME and NAME_sd); curves.h5 (/rve/0000/NAME, ..., /mean, /sd, /specification).
void write_element_curves(const std::filesystem::path& folder, const std::string& title, const std::string& specification,
                          const std::vector<ElementCurve>& curves);

} // namespace talik::farm
