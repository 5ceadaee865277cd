#pragma once
// TOML with positions: a tree of values, each knowing its line. The only place that names toml++.
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace talik::scene {

struct Value {
    enum class Kind { table, list, text, integer, number, flag, date };
    Kind kind = Kind::table;
    std::string position; // "scene.toml:12"; "--set" where it came from the command line
    std::string text;
    std::int64_t integer = 0;
    double number = 0.0;
    bool flag = false;
    std::vector<Value> items;       // of a list; of a table, the values of `names`
    std::vector<std::string> names; // of a table

    const Value* find(std::string_view name) const; // in a table; null = absent
    std::string_view kind_name() const;             // "a text", for messages
};

// A fault of syntax is one Error "FILE:LINE: ...".
Value read_document(const std::string& file);
Value parse_document(const std::string& text, const std::string& file_name);

// Overrides such as `rve.contact.friction=0.3`, `stage.0.duration="0.1 s"`; text without quotes is taken as text where it is
// no other TOML value. Absent tables on the way are made; places in a list must exist.
void apply_override(Value& document, const std::string& key_equals_value);

} // namespace talik::scene
