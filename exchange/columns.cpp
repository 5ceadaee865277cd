#include "exchange/columns.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "common/base/error.hpp"
#include "common/physics/rve_columns.hpp"
#include "exchange/checksum.hpp"

namespace talik::exchange {
namespace {

const Column* find(const std::vector<Column>& columns, const std::string& name) {
    const auto found = std::find_if(columns.begin(), columns.end(), [&](const Column& c) { return c.name == name; });
    return found == columns.end() ? nullptr : &*found;
}

// How `column` differs from its namesake; empty where it does not.
std::string difference(const Column& wanted, const Column& found, const char* wanted_verb, const char* found_verb) {
    std::vector<std::string> parts;
    if (wanted.components != found.components)
        parts.push_back(fmt::format("components: {} {}, {} {}", wanted.components, wanted_verb, found.components, found_verb));
    if (wanted.unit != found.unit)
        parts.push_back(fmt::format("unit: '{}' {}, '{}' {}", wanted.unit, wanted_verb, found.unit, found_verb));
    return fmt::format("{}", fmt::join(parts, "; "));
}

std::vector<std::string> compare(const std::vector<Column>& wanted, const std::vector<Column>& found, const char* absent,
                                 const char* wanted_verb, const char* found_verb) {
    std::vector<std::string> sentences;
    for (const Column& column : wanted) {
        const Column* other = find(found, column.name);
        if (!other)
            sentences.push_back(fmt::format("column '{}' is {}", column.name, absent));
        else if (const std::string text = difference(column, *other, wanted_verb, found_verb); !text.empty())
            sentences.push_back(fmt::format("column '{}': {}", column.name, text));
    }
    return sentences;
}

} // namespace

ColumnTable::ColumnTable(std::vector<Column> columns) : columns_(std::move(columns)) {
    for (std::size_t i = 0; i < columns_.size(); ++i) {
        const Column& column = columns_[i];
        require(!column.name.empty() && column.components >= 1 && column.components <= 1024,
                fmt::format("column '{}' of the exchange has {} components", column.name, column.components),
                "a column has a name and 1 to 1024 components");
        require(find(columns_, column.name) == &column, "column '" + column.name + "' is named twice",
                "name each column of the exchange once");
        first_component_.push_back(components_);
        components_ += column.components;
    }
}

int ColumnTable::index(std::string_view name) const {
    for (int i = 0; i < size(); ++i)
        if (columns_[static_cast<std::size_t>(i)].name == name) return i;
    return -1;
}

std::vector<Column> mandatory_request_columns() { return {rve_columns::displacement_gradient_increment}; }
std::vector<Column> mandatory_answer_columns() { return {rve_columns::stress, rve_columns::status}; }

std::vector<std::string> mismatches(const std::vector<Column>& asked, const std::vector<Column>& offered) {
    return compare(asked, offered, "asked for, but not offered", "asked for", "offered");
}

std::vector<std::string> missing(const std::vector<Column>& table, const std::vector<Column>& mandatory) {
    return compare(mandatory, table, "mandatory, but not asked for", "mandatory", "asked for");
}

std::uint64_t layout_hash(const ColumnTable& request, const ColumnTable& answer) {
    std::string text;
    for (const ColumnTable* table : {&request, &answer}) {
        for (const Column& c : table->columns()) text += fmt::format("{}[{}] {}\n", c.name, c.components, c.unit);
        text += '\n';
    }
    return checksum(text);
}

} // namespace talik::exchange
