// The attributes of an HDF5 file: small facts about the file, a group or an array.
#include "common/io/hdf5_handle.hpp"

namespace talik {

using namespace hdf5;

namespace {

Id text_type(std::size_t length) {
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, length + 1);
    H5Tset_cset(type, H5T_CSET_UTF8);
    return Id(type, H5Tclose);
}

void write_attribute(hid_t file, const std::string& place, const std::string& path, const std::string& key, hid_t type, const void* value) {
    if (H5Aexists_by_name(file, path.c_str(), key.c_str(), H5P_DEFAULT) > 0)
        written(H5Adelete_by_name(file, path.c_str(), key.c_str(), H5P_DEFAULT), place);
    const Id space(H5Screate(H5S_SCALAR), H5Sclose);
    const Id attribute(written(H5Acreate_by_name(file, path.c_str(), key.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), place), H5Aclose);
    written(H5Awrite(attribute, type, value), place);
}

hid_t open_attribute(hid_t file, const std::string& place, const std::string& path, const std::string& key) {
    const hid_t attribute = H5Aopen_by_name(file, path.c_str(), key.c_str(), H5P_DEFAULT, H5P_DEFAULT);
    if (attribute < 0) fail_to_read(place, "the attribute is missing");
    return attribute;
}

} // namespace

void Hdf5File::set_attribute(const std::string& path, const std::string& key, const std::string& value) {
    write_attribute(handle_->id, name_ + ": " + path + "@" + key, path, key, text_type(value.size()), value.c_str());
}

void Hdf5File::set_attribute(const std::string& path, const std::string& key, double value) {
    write_attribute(handle_->id, name_ + ": " + path + "@" + key, path, key, H5T_NATIVE_DOUBLE, &value);
}

void Hdf5File::set_attribute(const std::string& path, const std::string& key, std::int64_t value) {
    write_attribute(handle_->id, name_ + ": " + path + "@" + key, path, key, H5T_NATIVE_INT64, &value);
}

bool Hdf5File::has_attribute(const std::string& path, const std::string& key) const {
    return has(path) && H5Aexists_by_name(handle_->id, path.c_str(), key.c_str(), H5P_DEFAULT) > 0;
}

std::string Hdf5File::text_attribute(const std::string& path, const std::string& key) const {
    const std::string place = name_ + ": " + path + "@" + key;
    const Id attribute(open_attribute(handle_->id, place, path, key), H5Aclose);
    const Id type(H5Aget_type(attribute), H5Tclose);
    if (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) > 0) fail_to_read(place, "is not a text");
    std::string text(H5Tget_size(type), '\0');
    if (H5Aread(attribute, type, text.data()) < 0) fail_to_read(place, "is damaged");
    return text.c_str(); // up to the closing zero
}

double Hdf5File::number_attribute(const std::string& path, const std::string& key) const {
    const std::string place = name_ + ": " + path + "@" + key;
    const Id attribute(open_attribute(handle_->id, place, path, key), H5Aclose);
    double value = 0.0;
    if (H5Aread(attribute, H5T_NATIVE_DOUBLE, &value) < 0) fail_to_read(place, "is not a number");
    return value;
}

std::int64_t Hdf5File::integer_attribute(const std::string& path, const std::string& key) const {
    const std::string place = name_ + ": " + path + "@" + key;
    const Id attribute(open_attribute(handle_->id, place, path, key), H5Aclose);
    std::int64_t value = 0;
    if (H5Aread(attribute, H5T_NATIVE_INT64, &value) < 0) fail_to_read(place, "is not a whole number");
    return value;
}

void Hdf5File::require_format(const std::string& format) const {
    const std::string found = has_attribute("/", "format") ? text_attribute("/", "format") : "none";
    if (found != format) throw Error(ExitCode::bad_input, name_, "has the format \"" + found + "\"", "give a file of the format \"" + format + "\"");
}

} // namespace talik
