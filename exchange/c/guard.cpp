#include "exchange/c/guard.hpp"

#include "common/base/version.hpp"
#include "common/physics/rve_columns.hpp"

namespace talik::exchange::c {

std::string& last_error() {
    thread_local std::string text;
    return text;
}

std::vector<Column> columns_of(const talik_column* columns, std::size_t count) {
    require(columns != nullptr || count == 0, "a list of columns is missing", "give request and answer columns");
    std::vector<Column> out;
    for (std::size_t i = 0; i < count; ++i) {
        require(columns[i].name != nullptr && columns[i].unit != nullptr, "a column has no name or no unit", "\"1\" is the unit of a pure number");
        out.push_back({columns[i].name, columns[i].components, columns[i].unit, columns[i].meaning ? columns[i].meaning : ""});
    }
    (void)ColumnTable(out); // components, names twice
    return out;
}

std::string address(const char* exchange) {
    const std::string text = exchange ? exchange : "";
    const std::size_t colon = text.find(':'); // a process that is none of Talik's is in no MPI job with it
    const bool known = (text.starts_with("shm:") || text.starts_with("file:")) && colon + 1 < text.size();
    require(known, "\"" + text + "\": no such exchange", "give \"shm:NAME\" or \"file:FOLDER\"");
    return text;
}

} // namespace talik::exchange::c

using namespace talik;

extern "C" {

const char* talik_version(void) {
    static const std::string text = version();
    return text.c_str();
}

int talik_api_version(void) { return TALIK_API_VERSION; }

const char* talik_last_error(void) { return exchange::c::last_error().c_str(); }

void talik_set_error(const char* text) {
    try {
        exchange::c::last_error() = text ? text : "";
    } catch (...) { // no memory for a text: the code says enough
    }
}

const talik_column* talik_known_column(int index) {
    static const std::vector<Column> known = [] {
        std::vector<Column> all = rve_columns::requests();
        for (const Column& column : rve_columns::answers()) all.push_back(column);
        return all;
    }();
    static const std::vector<talik_column> plain = [] {
        std::vector<talik_column> all;
        for (const Column& c : known) all.push_back({c.name.c_str(), c.components, c.unit.c_str(), c.meaning.c_str()});
        return all;
    }();
    return index >= 0 && static_cast<std::size_t>(index) < plain.size() ? &plain[static_cast<std::size_t>(index)] : nullptr;
}

} // extern "C"
