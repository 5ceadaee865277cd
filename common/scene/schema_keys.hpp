#pragma once
// The kinds of keys of the schema engine (schema.hpp), one function each.
#include <fmt/format.h>

#include "common/scene/schema.hpp"

namespace talik::scene {

std::string kind_of(Dimension dimension);                          // "pressure (Pa, kPa, MPa, GPa)"
std::string kind_of(const std::vector<std::string>& choices);      // "a" or "b"
std::string standard_text(double value, Dimension dimension);      // "1e+05 Pa"
std::string literal_list(const double* values, std::size_t count); // [1, 2]

template <class S>
Table<S>& Table<S>::quantity(const std::string& name, Get<double> get, Dimension dimension, Range range, const std::string& meaning, Need need) {
    S standard{};
    const auto given = [=](double value) { return range.holds(value); }; // a default outside the range means "not given"
    return add({{name, kind_of(dimension), given(get(standard)) ? standard_text(get(standard), dimension) : "", range.text(si_unit(dimension)), meaning, need == Need::required},
                [=](const Value& v, const std::string& key, S& out, Faults& faults) { scene::read(v, key, dimension, range, get(out), faults); },
                [=](const S& content) { return given(look(get, content)) ? scene::literal(look(get, content)) : std::string(); }, {}, {}});
}

template <class S>
Table<S>& Table<S>::optional_quantity(const std::string& name, Get<std::optional<double>> get, Dimension dimension, Range range,
                                      const std::string& meaning, const std::string& word) {
    const std::string kind = kind_of(dimension) + (word.empty() ? "" : ", or \"" + word + "\"");
    return add({{name, kind, word.empty() ? "" : "\"" + word + "\"", range.text(si_unit(dimension)), meaning, false},
                [=](const Value& v, const std::string& key, S& out, Faults& faults) {
                    get(out).reset();
                    double value = 0.0;
                    if (!word.empty() && v.kind == Value::Kind::text && v.text == word) return;
                    if (scene::read(v, key, dimension, range, value, faults)) get(out) = value;
                },
                [=](const S& content) { return look(get, content) ? scene::literal(*look(get, content)) : std::string(); }, {}, {}});
}

template <class S>
template <class Whole>
Table<S>& Table<S>::whole(const std::string& name, Whole S::*member, Range range, const std::string& meaning, Need need) {
    return whole<Whole>(name, Get<Whole>(member), range, meaning, need);
}

template <class S>
template <class Whole>
Table<S>& Table<S>::whole(const std::string& name, Get<Whole> get, Range range, const std::string& meaning, Need need) {
    S standard{};
    range.least = std::max(range.least, static_cast<double>(std::numeric_limits<Whole>::lowest()));
    if (sizeof(Whole) < sizeof(std::int64_t)) range.most = std::min(range.most, static_cast<double>(std::numeric_limits<Whole>::max()));
    const bool wide = range.least < -1e9, high = range.most > 1e9; // the limits of the machine are nothing to document
    const Range shown{.least = wide ? any().least : range.least, .most = high ? any().most : range.most, .above_least = range.above_least};
    return add({{name, "whole number", std::to_string(get(standard)), shown.text(), meaning, need == Need::required},
                [=](const Value& v, const std::string& key, S& out, Faults& faults) {
                    std::int64_t value = 0;
                    if (read_whole(v, key, range, value, faults)) get(out) = static_cast<Whole>(value);
                },
                [=](const S& content) { return std::to_string(look(get, content)); }, {}, {}});
}

template <class S>
Table<S>& Table<S>::flag(const std::string& name, Get<bool> get, const std::string& meaning) {
    S standard{};
    return add({{name, "true or false", scene::literal(get(standard)), "", meaning, false},
                [=](const Value& v, const std::string& key, S& out, Faults& faults) { scene::read(v, key, get(out), faults); },
                [=](const S& content) { return scene::literal(look(get, content)); }, {}, {}});
}

template <class S>
Table<S>& Table<S>::text(const std::string& name, Get<std::string> get, const std::string& meaning, Need need) {
    S standard{};
    return add({{name, "text", get(standard).empty() ? "" : scene::literal(get(standard)), "", meaning, need == Need::required},
                [=](const Value& v, const std::string& key, S& out, Faults& faults) { scene::read(v, key, get(out), faults); },
                [=](const S& content) { return look(get, content).empty() ? std::string() : scene::literal(look(get, content)); }, {}, {}});
}

template <class S>
Table<S>& Table<S>::choice(const std::string& name, Get<std::string> get, const std::vector<std::string>& choices, const std::string& meaning, Need need) {
    S standard{};
    return add({{name, kind_of(choices), get(standard).empty() ? "" : scene::literal(get(standard)), "", meaning, need == Need::required},
                [=](const Value& v, const std::string& key, S& out, Faults& faults) { scene::read(v, key, choices, get(out), faults); },
                [=](const S& content) { return look(get, content).empty() ? std::string() : scene::literal(look(get, content)); }, {}, {}});
}

template <class S>
Table<S>& Table<S>::texts(const std::string& name, Get<std::vector<std::string>> get, const std::vector<std::string>& choices, const std::string& meaning) {
    return add({{name, choices.empty() ? "list of texts" : "list of " + kind_of(choices), "[]", "", meaning, false},
                [=](const Value& v, const std::string& key, S& out, Faults& faults) { scene::read(v, key, choices, get(out), faults); },
                [=](const S& content) {
                    std::string list;
                    for (const auto& word : look(get, content)) list += (list.empty() ? "" : ", ") + scene::literal(word);
                    return "[" + list + "]";
                }, {}, {}});
}

template <class S>
template <int N>
Table<S>& Table<S>::components(const std::string& name, Eigen::Matrix<double, N, 1> S::*member, Dimension dimension, Range range, const std::string& meaning, Need need) {
    S standard{};
    const std::string zero = (standard.*member).isZero(0.0) ? "zero" : literal_list((standard.*member).data(), N);
    return add({{name, fmt::format("list of {}, each of kind {}", N, kind_of(dimension)), zero, range.text(si_unit(dimension)), meaning, need == Need::required},
                [=](const Value& v, const std::string& key, S& out, Faults& faults) {
                    std::vector<double> values;
                    if (scene::read(v, key, dimension, range, N, values, faults)) out.*member = Eigen::Map<const Eigen::Matrix<double, N, 1>>(values.data());
                },
                [=](const S& content) { return literal_list((content.*member).data(), N); }, {}, {}});
}

template <class S>
Table<S>& Table<S>::points(const std::string& name, Get<Points> get, Dimension dimension, std::size_t count, const std::string& meaning, std::function<void(Points&)> finish) {
    const std::string kind = fmt::format("list of {} points [x, y], each of kind {}", count ? std::to_string(count) : "three or more", kind_of(dimension));
    return add({{name, kind, "", "", meaning, false},
                [=](const Value& v, const std::string& key, S& out, Faults& faults) {
                    if (v.kind != Value::Kind::list) { wrong_kind(v, key, kind, faults); return; }
                    if (count ? v.items.size() != count : v.items.size() < 3) {
                        faults.push_back({v.position, key, fmt::format("has {} points", v.items.size()), "give a " + kind});
                        return;
                    }
                    Points read_points;
                    std::vector<double> xy;
                    for (std::size_t i = 0; i < v.items.size(); ++i)
                        if (scene::read(v.items[i], joined(key, std::to_string(i)), dimension, any(), 2, xy, faults)) read_points.emplace_back(xy[0], xy[1]);
                    if (read_points.size() != v.items.size()) return;
                    if (finish) finish(read_points);
                    get(out) = read_points;
                },
                [=](const S& content) {
                    if (finish) return std::string(); // kept as what it was turned into, under that key
                    std::string list;
                    for (const auto& p : look(get, content)) list += (list.empty() ? "" : ", ") + literal_list(p.data(), 2);
                    return list.empty() ? std::string() : "[" + list + "]";
                }, {}, {}});
}

} // namespace talik::scene
