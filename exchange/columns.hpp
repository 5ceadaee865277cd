#pragma once
// The negotiated tables: what a request carries per RVE, and what an answer brings back. One side asks, the other
// offers; whatever does not fit is named field by field, all of it at once.
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/column.hpp"

namespace talik::exchange {

using talik::Column;

// Columns in the order in which a batch carries them.
class ColumnTable {
public:
    ColumnTable() = default;
    explicit ColumnTable(std::vector<Column> columns);

    const std::vector<Column>& columns() const { return columns_; }
    int size() const { return static_cast<int>(columns_.size()); }
    int components() const { return components_; } // of all columns together
    int index(std::string_view name) const;        // -1: not in the table
    int first_component(int column) const { return first_component_[static_cast<std::size_t>(column)]; }

private:
    std::vector<Column> columns_;
    std::vector<int> first_component_;
    int components_ = 0;
};

// The least that every pair of programs exchanges.
std::vector<Column> mandatory_request_columns(); // displacement_gradient_increment[4]
std::vector<Column> mandatory_answer_columns();  // stress[3], status[1]

// One sentence per column that is asked for and not offered, or offered in another shape or unit.
std::vector<std::string> mismatches(const std::vector<Column>& asked, const std::vector<Column>& offered);
// One sentence per mandatory column that `table` lacks or has in another shape or unit.
std::vector<std::string> missing(const std::vector<Column>& table, const std::vector<Column>& mandatory);

// Equal on both sides exactly if both lay out their batches alike.
std::uint64_t layout_hash(const ColumnTable& request, const ColumnTable& answer);

} // namespace talik::exchange
