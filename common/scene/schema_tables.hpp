#pragma once
// The schema engine (schema.hpp): tables inside tables, and what a table does with its rows.
#include "common/scene/schema.hpp"

namespace talik::scene {

template <class S>
template <class Inner>
Table<S>& Table<S>::table(const std::string& name, Get<Inner> get, const Table<Inner>& inner) {
    const auto kept = std::make_shared<Table<Inner>>(inner);
    return add({{name, "table", "", "", inner.meaning_, inner.needed(), true},
                [=](const Value& v, const std::string& key, S& out, Faults& faults) { kept->read(v, key, get(out), faults); }, {},
                [=](const S& content, const std::string& path) { return "\n[" + path + "]\n" + kept->dump(look(get, content), path); },
                [=](const std::string& path, std::vector<Section>& sections) { kept->describe(path, sections); }});
}

template <class S>
template <class Inner>
Table<S>& Table<S>::optional_table(const std::string& name, Get<std::optional<Inner>> get, const Table<Inner>& inner) {
    const auto kept = std::make_shared<Table<Inner>>(inner);
    return add({{name, "table", "", "", inner.meaning_, false, true},
                [=](const Value& v, const std::string& key, S& out, Faults& faults) { kept->read(v, key, get(out).emplace(), faults); }, {},
                [=](const S& content, const std::string& path) {
                    return look(get, content) ? "\n[" + path + "]\n" + kept->dump(*look(get, content), path) : std::string();
                },
                [=](const std::string& path, std::vector<Section>& sections) { kept->describe(path, sections, Shape::optional); }});
}

template <class S>
template <class Inner>
Table<S>& Table<S>::tables(const std::string& name, std::vector<Inner> S::*member, const Table<Inner>& inner, Need need) {
    const auto kept = std::make_shared<Table<Inner>>(inner);
    return add({{name, "list of tables", "", "", inner.meaning_, need == Need::required, true},
                [=](const Value& v, const std::string& key, S& out, Faults& faults) {
                    if (v.kind != Value::Kind::list) { wrong_kind(v, key, "it as [[" + key + "]], once for each", faults); return; }
                    for (std::size_t i = 0; i < v.items.size(); ++i)
                        kept->read(v.items[i], joined(key, std::to_string(i)), (out.*member).emplace_back(), faults);
                }, {},
                [=](const S& content, const std::string& path) {
                    std::string text;
                    for (const Inner& item : content.*member) text += "\n[[" + path + "]]\n" + kept->dump(item, path);
                    return text;
                },
                [=](const std::string& path, std::vector<Section>& sections) { kept->describe(path, sections, Shape::list); }});
}

template <class S>
Table<S>& Table<S>::check(std::function<void(const S&, const Place&)> rule) {
    rules_.push_back(std::move(rule));
    return *this;
}

template <class S>
bool Table<S>::needed() const {
    for (const Row& row : rows_)
        if (row.text.required) return true;
    return false;
}

template <class S>
void Table<S>::unknown_keys(const Value& document, const std::string& path, Faults& faults) const {
    std::vector<std::string> known;
    for (const Row& row : rows_) known.push_back(row.text.name);
    for (std::size_t i = 0; i < document.names.size(); ++i) {
        const std::string& name = document.names[i];
        if (std::find(known.begin(), known.end(), name) != known.end()) continue;
        const std::string near = nearest(name, known);
        faults.push_back({document.items[i].position, joined(path, name), "is no key of " + (path.empty() ? "this file" : "[" + path + "]"),
                          near.empty() ? fmt::format("known here: {}", fmt::join(known, ", ")) : fmt::format("did you mean \"{}\"?", near)});
    }
}

template <class S>
void Table<S>::missing(const Row& row, const Value& document, const std::string& path, Faults& faults) const {
    const std::string key = joined(path, row.text.name);
    const std::string remedy = !row.text.inner                     ? fmt::format("add {} = ..., of kind {}: {}", row.text.name, row.text.kind, row.text.meaning)
                               : row.text.kind == "list of tables" ? fmt::format("add at least one [[{}]]: {}", key, row.text.meaning)
                                                                   : fmt::format("add the table [{}]: {}", key, row.text.meaning);
    faults.push_back({document.position, key, "is missing", remedy});
}

template <class S>
void Table<S>::read(const Value& document, const std::string& path, S& out, Faults& faults) const {
    if (document.kind != Value::Kind::table) {
        wrong_kind(document, path, "a table", faults);
        return;
    }
    const std::size_t before = faults.size();
    unknown_keys(document, path, faults);
    for (const Row& row : rows_) {
        const Value* value = document.find(row.text.name);
        const bool nothing = !value || (row.text.kind == "list of tables" && value->kind == Value::Kind::list && value->items.empty());
        if (!nothing) row.read(*value, joined(path, row.text.name), out, faults);
        else if (row.text.required) missing(row, document, path, faults);
    }
    if (faults.size() == before)
        for (const auto& rule : rules_) rule(out, Place{document, path, faults});
}

template <class S>
void Table<S>::describe(const std::string& path, std::vector<Section>& sections, Shape shape) const {
    Section section{path, shape, meaning_, {}};
    for (const Row& row : rows_) section.rows.push_back(row.text);
    sections.push_back(section);
    for (const Row& row : rows_)
        if (row.describe) row.describe(joined(path, row.text.name), sections);
}

template <class S>
std::string Table<S>::dump(const S& content, const std::string& path) const {
    std::string text;
    for (const Row& row : rows_) {
        const std::string value = row.literal ? row.literal(content) : "";
        if (!value.empty()) text += row.text.name + " = " + value + "\n";
    }
    for (const Row& row : rows_)
        if (row.inner_dump) text += row.inner_dump(content, joined(path, row.text.name));
    return text;
}

} // namespace talik::scene
