#include "common/io/text_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

#include "common/base/error.hpp"

namespace talik {

void fail_to_write(const std::filesystem::path& path, int error_number) {
    const bool resource = error_number == ENOSPC || error_number == EDQUOT || error_number == EFBIG || error_number == EIO;
    throw Error(resource ? ExitCode::out_of_resource : ExitCode::bad_input, path.string(),
                std::string("cannot be written: ") + std::strerror(error_number),
                resource ? "free some space on that disk, or choose another folder with --output"
                         : "choose a folder you may write to with --output");
}

std::string read_text_file(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    if (!in || std::filesystem::is_directory(path))
        throw Error(ExitCode::bad_input, path.string(), "cannot be read", "check that the file exists and may be read");
    std::ostringstream content;
    content << in.rdbuf();
    return content.str();
}

void write_file_atomically(const std::filesystem::path& path, const std::string& content) {
    const std::filesystem::path temporary = path.string() + ".part";
    const int file = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (file < 0) fail_to_write(path, errno);
    int error_number = 0;
    for (std::size_t done = 0; done < content.size() && error_number == 0;) {
        const ssize_t written = ::write(file, content.data() + done, content.size() - done);
        if (written < 0 && errno != EINTR) error_number = errno;
        if (written > 0) done += static_cast<std::size_t>(written);
    }
    if (error_number == 0 && ::fsync(file) != 0) error_number = errno;
    ::close(file);
    if (error_number == 0 && ::rename(temporary.c_str(), path.c_str()) != 0) error_number = errno;
    if (error_number != 0) {
        ::unlink(temporary.c_str());
        fail_to_write(path, error_number);
    }
}

void make_folder(const std::filesystem::path& path) {
    std::error_code problem;
    std::filesystem::create_directories(path, problem);
    if (problem || !std::filesystem::is_directory(path)) fail_to_write(path, problem ? problem.value() : ENOTDIR);
}

} // namespace talik
