#include "common/io/csv_table.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include <fmt/format.h>

#include "common/io/text_file.hpp"

namespace talik {
namespace {

std::string trimmed(std::string_view text) {
    const auto first = text.find_first_not_of(" \t\r");
    if (first == std::string_view::npos) return "";
    return std::string(text.substr(first, text.find_last_not_of(" \t\r") - first + 1));
}

std::vector<std::string> fields_of(const std::string& line) {
    std::vector<std::string> fields;
    std::size_t begin = 0;
    while (true) {
        const auto comma = line.find(',', begin);
        fields.push_back(trimmed(std::string_view(line).substr(begin, comma - begin)));
        if (comma == std::string::npos) return fields;
        begin = comma + 1;
    }
}

Error fault_at(const std::string& file, int line, const std::string& problem, const std::string& remedy) {
    return Error(ExitCode::bad_input, fmt::format("{}:{}", file, line), problem, remedy);
}

std::vector<double> numbers_of(const CsvTable& table, const std::string& line, int number) {
    const auto fields = fields_of(line);
    if (fields.size() != table.columns.size())
        throw fault_at(table.file, number, fmt::format("{} values where the heading names {}", fields.size(), table.columns.size()),
                       "give one value for each column");
    std::vector<double> values;
    for (std::size_t i = 0; i < fields.size(); ++i) {
        char* end = nullptr;
        values.push_back(std::strtod(fields[i].c_str(), &end));
        if (fields[i].empty() || *end != '\0')
            throw fault_at(table.file, number, fmt::format("\"{}\" in column \"{}\" is not a number", fields[i], table.columns[i]),
                           "write a plain number such as 2.5e-3");
    }
    return values;
}

} // namespace

bool CsvTable::has(std::string_view name) const { return std::find(columns.begin(), columns.end(), name) != columns.end(); }

std::size_t CsvTable::column(std::string_view name) const {
    const auto found = std::find(columns.begin(), columns.end(), name);
    if (found == columns.end())
        throw Error(ExitCode::bad_input, file, fmt::format("has no column \"{}\"", name),
                    fmt::format("its columns are {}; rename or add one", fmt::join(columns, ", ")));
    return static_cast<std::size_t>(found - columns.begin());
}

std::vector<double> CsvTable::values(std::string_view name) const {
    const std::size_t c = column(name);
    std::vector<double> result;
    result.reserve(rows.size());
    for (const auto& row : rows) result.push_back(row[c]);
    return result;
}

double CsvTable::comment_value(const std::string& name, const double* otherwise) const {
    for (const auto& comment : comments) {
        const auto at = (" " + comment).find(" " + name + "=");
        if (at == std::string::npos) continue;
        const char* text = comment.c_str() + at + name.size() + 1;
        char* end = nullptr;
        const double value = std::strtod(text, &end);
        if (end == text) throw Error(ExitCode::bad_input, file, name + " in the comment line is not a number", "write " + name + "=0.15");
        return value;
    }
    if (otherwise) return *otherwise;
    throw Error(ExitCode::bad_input, file, "has no " + name + " in its first comment line", "write a line such as \"# " + name + "=0.15\"");
}

void CsvTable::require_finite() const {
    for (std::size_t i = 0; i < rows.size(); ++i)
        for (std::size_t c = 0; c < columns.size(); ++c)
            if (!std::isfinite(rows[i][c])) throw fault(i, fmt::format("{} in column \"{}\" is not a finite number", rows[i][c], columns[c]), "write a plain number such as 2.5e-3");
}

Error CsvTable::fault(std::size_t row, const std::string& problem, const std::string& remedy) const {
    return fault_at(file, lines[row], problem, remedy);
}

CsvTable read_csv(const std::string& file) {
    std::istringstream in(read_text_file(file));
    CsvTable table;
    table.file = file;
    std::string line;
    for (int number = 1; std::getline(in, line); ++number) {
        if (number == 1 && line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3); // the byte order mark that spreadsheets write
        line = trimmed(line);
        if (line.empty()) continue;
        if (line[0] == '#') {
            table.comments.push_back(trimmed(std::string_view(line).substr(1)));
        } else if (table.columns.empty()) {
            table.columns = fields_of(line);
        } else {
            table.rows.push_back(numbers_of(table, line, number));
            table.lines.push_back(number);
        }
    }
    require(!table.columns.empty(), file + ": has no line of column names", "the first line without \"#\" names the columns");
    return table;
}

CsvTable read_finite_csv(const std::string& file) {
    CsvTable table = read_csv(file);
    table.require_finite();
    return table;
}

void write_csv(const std::string& file, const std::vector<std::string>& comments, const std::vector<std::string>& columns,
               const std::vector<std::vector<double>>& rows) {
    std::string text;
    for (const auto& comment : comments) text += "# " + comment + "\n";
    text += fmt::format("{}\n", fmt::join(columns, ","));
    for (const auto& row : rows) {
        ensure(row.size() == columns.size());
        text += fmt::format("{}\n", fmt::join(row, ","));
    }
    write_file_atomically(file, text);
}

} // namespace talik
