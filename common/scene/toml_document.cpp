#include "common/scene/toml_document.hpp"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>
#include <toml++/toml.h>

#include "common/base/error.hpp"
#include "common/io/text_file.hpp"

namespace talik::scene {

namespace fs = std::filesystem;

namespace {

Value converted(const toml::node& node, const std::string& file) {
    Value v;
    v.position = file == "--set" ? file : fmt::format("{}:{}", file, node.source().begin.line);
    if (const auto* table = node.as_table()) {
        v.kind = Value::Kind::table;
        for (const auto& [key, child] : *table) {
            v.names.emplace_back(key.str());
            v.items.push_back(converted(child, file));
        }
    } else if (const auto* list = node.as_array()) {
        v.kind = Value::Kind::list;
        for (const auto& child : *list) v.items.push_back(converted(child, file));
    } else if (const auto* text = node.as_string()) {
        v.kind = Value::Kind::text;
        v.text = text->get();
    } else if (const auto* whole = node.as_integer()) {
        v.kind = Value::Kind::integer;
        v.integer = whole->get();
        v.number = static_cast<double>(v.integer);
    } else if (const auto* number = node.as_floating_point()) {
        v.kind = Value::Kind::number;
        v.number = number->get();
    } else if (const auto* flag = node.as_boolean()) {
        v.kind = Value::Kind::flag;
        v.flag = flag->get();
    } else {
        v.kind = Value::Kind::date;
    }
    return v;
}

// The parser's text ends in a sentence on what it met; one line is enough for us.
std::string one_line(std::string_view text) {
    std::string line(text.substr(0, text.find('\n')));
    if (!line.empty() && line.back() == '.') line.pop_back();
    return line;
}

std::vector<std::string> steps_of(const std::string& key) {
    std::vector<std::string> steps;
    std::size_t begin = 0;
    while (true) {
        const auto dot = key.find('.', begin);
        steps.push_back(key.substr(begin, dot - begin));
        if (dot == std::string::npos) return steps;
        begin = dot + 1;
    }
}

// As TOML's parser sees it, which takes any text in a comment.
bool is_utf8(std::string text) {
    std::replace_if(text.begin(), text.end(), [](char c) { return (c >= 0 && c < 32) || c == 127; }, ' ');
    try {
        static_cast<void>(toml::parse("# " + text));
        return true;
    } catch (const toml::parse_error&) {
        return false;
    }
}

Value value_of_override(const std::string& text) {
    try {
        return converted(*toml::parse("value = " + text, std::string("--set")).get("value"), "--set");
    } catch (const toml::parse_error&) {
        Value v;
        v.kind = Value::Kind::text;
        v.position = "--set";
        v.text = text;
        return v;
    }
}

Value& place_in_list(Value& list, const std::string& step, const std::string& key) {
    const bool digits = !step.empty() && step.size() < 9 && std::all_of(step.begin(), step.end(), [](char c) { return c >= '0' && c <= '9'; });
    if (!digits || std::stoul(step) >= list.items.size())
        throw Error(ExitCode::bad_input, "--set: " + key, fmt::format("there is no place \"{}\" in a list of {}", step, list.items.size()),
                    "count the places from 0, as in stage.0.duration");
    return list.items[std::stoul(step)];
}

Value& place_of(Value& parent, const std::string& step, const std::string& key) {
    if (parent.kind == Value::Kind::list) return place_in_list(parent, step, key);
    if (parent.kind != Value::Kind::table)
        throw Error(ExitCode::bad_input, "--set: " + key, fmt::format("\"{}\" lies inside {}", step, parent.kind_name()), "give the path of a key");
    for (std::size_t i = 0; i < parent.names.size(); ++i)
        if (parent.names[i] == step) return parent.items[i];
    parent.names.push_back(step);
    parent.items.emplace_back().position = "--set";
    return parent.items.back();
}

} // namespace

const Value* Value::find(std::string_view name) const {
    for (std::size_t i = 0; i < names.size(); ++i)
        if (names[i] == name) return &items[i];
    return nullptr;
}

std::string_view Value::kind_name() const {
    switch (kind) {
    case Kind::table: return "a table";
    case Kind::list: return "a list";
    case Kind::text: return "a text";
    case Kind::integer: return "a whole number";
    case Kind::number: return "a number";
    case Kind::flag: return "true or false";
    case Kind::date: return "a date";
    }
    return "";
}

Value read_document(const std::string& file) {
    std::error_code none;
    const fs::file_status status = fs::status(file, none);
    // A pipe holds its text for one reader only, and a scene is read more than once.
    if (fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status))
        throw Error(ExitCode::bad_input, file, "is no regular file but a pipe or a device", "save the text in a file and name that");
    return parse_document(read_text_file(file), file);
}

Value parse_document(const std::string& text, const std::string& file_name) {
    try {
        Value document = converted(toml::parse(text, file_name), file_name);
        document.position = file_name + ":1";
        return document;
    } catch (const toml::parse_error& e) {
        throw Error(ExitCode::bad_input, fmt::format("{}:{}", file_name, e.source().begin.line), one_line(e.description()), "mend the TOML syntax there");
    }
}

void apply_override(Value& document, const std::string& key_equals_value) {
    const auto equals = key_equals_value.find('=');
    require(equals != std::string::npos && equals > 0, "--set " + key_equals_value + ": there is no \"=\"", "write --set key=value");
    const std::string key = key_equals_value.substr(0, equals);
    if (!is_utf8(key_equals_value)) throw Error(ExitCode::bad_input, "--set: " + key, "is no text in UTF-8", "write it in UTF-8, as TOML files are");
    Value* place = &document;
    for (const auto& step : steps_of(key)) place = &place_of(*place, step, key);
    *place = value_of_override(key_equals_value.substr(equals + 1));
}

} // namespace talik::scene
