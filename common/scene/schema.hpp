#pragma once
// The schema engine: one table of keys per struct. Each row says name, kind, default, range, meaning and the member it fills;
// the same rows validate a document, print help, write documentation and dump the checked content.
#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <type_traits>

#include <Eigen/Dense>

#include "common/scene/describe.hpp"
#include "common/scene/reading.hpp"

namespace talik::scene {

enum class Need { optional, required };
constexpr Need required = Need::required;

// A checked struct, where it stands in its document: for checks that look at more than one key.
struct Place {
    const Value& value;
    std::string key;
    Faults& faults;
    // A fault of the named key; its position is the key's where it is written, else the table's.
    void fault(const std::string& name, const std::string& problem, const std::string& remedy) const;
    bool has(const std::string& name) const { return value.find(name) != nullptr; }
};

template <class Struct>
class Table {
public:
    template <class Member>
    using Get = std::function<Member&(Struct&)>; // a member's pointer, or a lambda to reach further in
    using Points = std::vector<Eigen::Vector2d>;

    explicit Table(std::string meaning) : meaning_(std::move(meaning)) {}

    // Keys. Defaults are those of a default-made Struct.
    Table& quantity(const std::string& name, Get<double> get, Dimension, Range, const std::string& meaning, Need = Need::optional);
    // Absent, or the word (where one is given), means empty.
    Table& optional_quantity(const std::string& name, Get<std::optional<double>> get, Dimension, Range, const std::string& meaning, const std::string& word = "");
    Table& number(const std::string& name, Get<double> get, Range range, const std::string& meaning, Need need = Need::optional) {
        return quantity(name, get, Dimension::none, range, meaning, need);
    }
    template <class Whole>
    Table& whole(const std::string& name, Whole Struct::*member, Range, const std::string& meaning, Need = Need::optional);
    template <class Whole>
    Table& whole(const std::string& name, Get<Whole> get, Range, const std::string& meaning, Need = Need::optional);
    Table& flag(const std::string& name, Get<bool> get, const std::string& meaning);
    Table& text(const std::string& name, Get<std::string> get, const std::string& meaning, Need = Need::optional);
    Table& choice(const std::string& name, Get<std::string> get, const std::vector<std::string>& choices, const std::string& meaning, Need = Need::optional);
    Table& texts(const std::string& name, Get<std::vector<std::string>> get, const std::vector<std::string>& choices, const std::string& meaning);
    template <int N>
    Table& components(const std::string& name, Eigen::Matrix<double, N, 1> Struct::*member, Dimension, Range, const std::string& meaning, Need = Need::optional);
    // A list of points; `count` of them, or any number from three on where it is 0. `finish` turns them into what is kept.
    Table& points(const std::string& name, Get<Points> get, Dimension, std::size_t count, const std::string& meaning, std::function<void(Points&)> finish = {});

    // Tables inside: always there; there or not (an effect); a list of them.
    template <class Inner>
    Table& table(const std::string& name, Get<Inner> get, const Table<Inner>& inner);
    template <class Inner>
    Table& optional_table(const std::string& name, Get<std::optional<Inner>> get, const Table<Inner>& inner);
    template <class Inner>
    Table& tables(const std::string& name, std::vector<Inner> Struct::*member, const Table<Inner>& inner, Need = Need::optional);

    // A rule that needs more than one key; it runs where every key of the table is sound.
    Table& check(std::function<void(const Struct&, const Place&)> rule);

    void read(const Value& document, const std::string& path, Struct& out, Faults& faults) const;
    void describe(const std::string& path, std::vector<Section>& sections, Shape shape = Shape::always) const;
    std::string dump(const Struct& content, const std::string& path = "") const; // canonical TOML: every value in SI, in the rows' order
    bool needed() const; // holds a required key

private:
    struct Row {
        RowText text;
        std::function<void(const Value&, const std::string& key, Struct&, Faults&)> read;
        std::function<std::string(const Struct&)> literal;                               // of a key; empty = not written
        std::function<std::string(const Struct&, const std::string& path)> inner_dump;   // of a table inside
        std::function<void(const std::string& path, std::vector<Section>&)> describe;    // of a table inside
    };
    template <class Member>
    static const Member& look(const Get<Member>& get, const Struct& content) { return get(const_cast<Struct&>(content)); }
    Table& add(Row row) { rows_.push_back(std::move(row)); return *this; }
    void missing(const Row& row, const Value& document, const std::string& path, Faults& faults) const;
    void unknown_keys(const Value& document, const std::string& path, Faults& faults) const;

    std::string meaning_;
    std::vector<Row> rows_;
    std::vector<std::function<void(const Struct&, const Place&)>> rules_;
    template <class> friend class Table;
};

} // namespace talik::scene

#include "common/scene/schema_keys.hpp"
#include "common/scene/schema_tables.hpp"
