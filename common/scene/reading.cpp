#include "common/scene/reading.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "common/base/error.hpp"

namespace talik::scene {
namespace {

// Levenshtein: insertions, deletions and replacements that lead from one word to the other.
std::size_t edits_between(const std::string& a, const std::string& b) {
    std::vector<std::size_t> row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t replaced = diagonal + (a[i - 1] != b[j - 1]);
            diagonal = row[j];
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
        }
    }
    return row[b.size()];
}

std::string with_unit(Dimension dimension) {
    return dimension == Dimension::none ? "a number" : fmt::format("{} such as \"1.5 {}\"", one(dimension), si_unit(dimension));
}

std::string quoted(const std::vector<std::string>& words) { return fmt::format("\"{}\"", fmt::join(words, "\", \"")); }

} // namespace

std::string Fault::text() const { return one_line(fmt::format("{}: {}{}{} ({})", position, key, key.empty() ? "" : ": ", problem, remedy)); }

void throw_if_any(const Faults& faults, const std::string& how_to_list_all) {
    if (faults.empty()) return;
    const Fault& first = faults.front();
    const std::string more = faults.size() == 1 ? "" : fmt::format("; and {} more: {}", faults.size() - 1, how_to_list_all);
    throw Error(ExitCode::bad_input, first.key.empty() ? first.position : first.position + ": " + first.key, first.problem, first.remedy + more);
}

std::string Range::text(std::string_view unit) const {
    const std::string tail = unit.empty() || unit == "-" ? "" : fmt::format(" {}", unit);
    const bool below = std::isfinite(least), above = std::isfinite(most);
    if (below && above) return fmt::format("in {}{:g}, {:g}]{}", above_least ? "(" : "[", least, most, tail);
    if (below) return fmt::format("{} {:g}{}", above_least ? ">" : ">=", least, tail);
    if (above) return fmt::format("<= {:g}{}", most, tail);
    return "";
}

bool wrong_kind(const Value& v, const std::string& key, const std::string& wanted, Faults& faults) {
    faults.push_back({v.position, key, fmt::format("is {}", v.kind_name()), "give " + wanted});
    return false;
}

bool read(const Value& v, const std::string& key, Dimension dimension, const Range& range, double& out, Faults& faults) {
    double value = v.number;
    if (v.kind == Value::Kind::text) {
        const ReadQuantity quantity = read_quantity(v.text, dimension);
        if (!quantity.problem.empty()) {
            faults.push_back({v.position, key, quantity.problem, quantity.remedy});
            return false;
        }
        value = quantity.value;
    } else if (v.kind != Value::Kind::number && v.kind != Value::Kind::integer) {
        return wrong_kind(v, key, with_unit(dimension), faults);
    }
    if (!std::isfinite(value) || !range.holds(value)) {
        const std::string allowed = range.text(si_unit(dimension));
        const std::string unit = dimension == Dimension::none ? "" : fmt::format(" {}", si_unit(dimension));
        faults.push_back({v.position, key, fmt::format("{:g}{} is out of range", value, unit),
                          "give a value " + (allowed.empty() ? "that is finite" : allowed)});
        return false;
    }
    out = value;
    return true;
}

bool read_whole(const Value& v, const std::string& key, const Range& range, std::int64_t& out, Faults& faults) {
    if (v.kind != Value::Kind::integer) return wrong_kind(v, key, "a whole number", faults);
    if (!range.holds(static_cast<double>(v.integer))) {
        faults.push_back({v.position, key, fmt::format("{} is out of range", v.integer), "give a whole number " + range.text()});
        return false;
    }
    out = v.integer;
    return true;
}

bool read(const Value& v, const std::string& key, bool& out, Faults& faults) {
    if (v.kind != Value::Kind::flag) return wrong_kind(v, key, "true or false", faults);
    out = v.flag;
    return true;
}

bool read(const Value& v, const std::string& key, std::string& out, Faults& faults) {
    if (v.kind != Value::Kind::text) return wrong_kind(v, key, "a text in quotes", faults);
    out = v.text;
    return true;
}

bool read(const Value& v, const std::string& key, const std::vector<std::string>& choices, std::string& out, Faults& faults) {
    std::string word;
    if (!read(v, key, word, faults)) return false;
    if (std::find(choices.begin(), choices.end(), word) == choices.end()) {
        const std::string near = nearest(word, choices);
        faults.push_back({v.position, key, fmt::format("\"{}\" is not one of its choices", word),
                          (near.empty() ? "" : fmt::format("did you mean \"{}\"? ", near)) + "choose from " + quoted(choices)});
        return false;
    }
    out = word;
    return true;
}

bool read(const Value& v, const std::string& key, const std::vector<std::string>& choices, std::vector<std::string>& out, Faults& faults) {
    if (v.kind != Value::Kind::list) return wrong_kind(v, key, "a list of texts such as [\"plate\"]", faults);
    std::vector<std::string> words(v.items.size());
    bool sound = true;
    for (std::size_t i = 0; i < words.size(); ++i) {
        const std::string place = joined(key, std::to_string(i));
        sound = (choices.empty() ? read(v.items[i], place, words[i], faults) : read(v.items[i], place, choices, words[i], faults)) && sound;
    }
    if (sound) out = words;
    return sound;
}

bool read(const Value& v, const std::string& key, Dimension dimension, const Range& range, std::size_t count, std::vector<double>& out, Faults& faults) {
    const std::string wanted = fmt::format("a list of {}{} values, each {}", count ? std::to_string(count) : "", count ? "" : "any number of", with_unit(dimension));
    if (v.kind != Value::Kind::list) return wrong_kind(v, key, wanted, faults);
    if (count != 0 && v.items.size() != count) {
        faults.push_back({v.position, key, fmt::format("has {} values", v.items.size()), "give " + wanted});
        return false;
    }
    std::vector<double> values(v.items.size());
    bool sound = true;
    for (std::size_t i = 0; i < values.size(); ++i)
        sound = read(v.items[i], joined(key, std::to_string(i)), dimension, range, values[i], faults) && sound;
    if (sound) out = values;
    return sound;
}

std::string nearest(const std::string& word, const std::vector<std::string>& known) {
    std::string best;
    std::size_t fewest = std::max<std::size_t>(2, word.size() / 3) + 1; // further away is another word, not a slip
    for (const auto& candidate : known) {
        const std::size_t edits = edits_between(word, candidate);
        if (edits < fewest && edits < candidate.size()) fewest = edits, best = candidate;
    }
    return best;
}

std::string joined(const std::string& path, const std::string& name) { return path.empty() ? name : path + "." + name; }

std::string literal(double value) { return fmt::format("{}", value); }
std::string literal(bool value) { return value ? "true" : "false"; }

std::string literal(const std::string& value) {
    std::string text = "\"";
    for (char c : value) {
        if (c == '"' || c == '\\') text += '\\';
        if (static_cast<unsigned char>(c) < 0x20) text += fmt::format("\\u{:04x}", c);
        else text += c;
    }
    return text + "\"";
}

std::string fingerprint(const std::string& text) {
    std::uint64_t hash = 0xcbf29ce484222325u;
    for (unsigned char c : text) hash = (hash ^ c) * 0x100000001b3u;
    return fmt::format("{:016x}", hash);
}

} // namespace talik::scene
