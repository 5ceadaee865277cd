#include "common/scene/describe.hpp"

#include <fmt/format.h>

namespace talik::scene {
namespace {

std::string heading(const Section& s) {
    if (s.path.empty()) return "(top of the file)";
    return s.shape == Shape::list ? "[[" + s.path + "]]" : "[" + s.path + "]";
}

std::string nature(const Section& s) {
    if (s.shape == Shape::optional) return " Present means on.";
    return s.shape == Shape::list ? " One table for each." : "";
}

std::string standard_of(const RowText& row) { return row.required ? "required" : row.standard.empty() ? "none" : row.standard; }

std::string escaped(std::string text) { // a bar would end a cell of the table
    for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2) text.replace(at, 1, "\\|");
    return text;
}

} // namespace

std::string help_text(const std::vector<Section>& sections) {
    std::string text = "Quantities are text with a unit (\"100 kPa\") or bare numbers in SI.\n";
    for (const Section& s : sections) {
        text += fmt::format("\n{}  {}{}\n", heading(s), s.meaning, nature(s));
        for (const RowText& row : s.rows) {
            if (row.inner) continue;
            text += fmt::format("  {:<22} {}\n{:25}{}; {}{}\n", row.name, row.meaning, "", row.kind,
                                row.required ? "required" : "default " + standard_of(row), row.range.empty() ? "" : "; " + row.range);
        }
    }
    return text;
}

std::string markdown(const std::string& title, const std::string& introduction, const std::vector<Section>& sections) {
    std::string text = fmt::format("# {}\n\n{}\n", title, introduction);
    for (const Section& s : sections) {
        text += fmt::format("\n## {}{}{}\n{}{}\n\n", s.path.empty() ? "" : "`", heading(s), s.path.empty() ? "" : "`", s.meaning, nature(s));
        text += "| key | kind (units) | default | range | meaning |\n| --- | --- | --- | --- | --- |\n";
        for (const RowText& row : s.rows)
            if (!row.inner)
                text += fmt::format("| `{}` | {} | {} | {} | {} |\n", row.name, escaped(row.kind), escaped(standard_of(row)), escaped(row.range), escaped(row.meaning));
    }
    return text;
}

} // namespace talik::scene
