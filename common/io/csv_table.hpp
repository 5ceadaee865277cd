#pragma once
// A table of numbers as text: "#" lines, one line of column names, rows of numbers. Positions are kept for error messages.
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.hpp"

namespace talik {

struct CsvTable {
    std::string file;
    std::vector<std::string> comments; // the "#" lines, without the "#"
    std::vector<std::string> columns;
    std::vector<std::vector<double>> rows;
    std::vector<int> lines; // of each row, in the file

    bool has(std::string_view column) const;
    std::size_t column(std::string_view name) const; // an error names the file and its columns where there is none
    std::vector<double> values(std::string_view column) const;
    // A value of the form "name=1.5" in the comments; an error where it is missing and `otherwise` is null.
    double comment_value(const std::string& name, const double* otherwise = nullptr) const;
    void require_finite() const; // an error names the first that is not
    Error fault(std::size_t row, const std::string& problem, const std::string& remedy) const;
};

CsvTable read_csv(const std::string& file);
CsvTable read_finite_csv(const std::string& file); // an input: a NaN or an infinity in it is refused

// Rows of equal length under the names; numbers are written so that reading them returns the same bits.
void write_csv(const std::string& file, const std::vector<std::string>& comments, const std::vector<std::string>& columns,
               const std::vector<std::vector<double>>& rows);

} // namespace talik
