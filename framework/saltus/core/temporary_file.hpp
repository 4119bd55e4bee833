// Temporary files for atomic writes: readers see a file completely written or not at all.
#pragma once

#include <filesystem>
#include <string_view>
#include <system_error>

namespace saltus {

/// Path of a temporary file in the folder of `path`, called .NAME.RANDOM.HOST.PROCESS.part. The
/// random part is hard to guess. Host and process allow remove_orphans() to detect dead writers.
std::filesystem::path temporary_path(const std::filesystem::path& path);

/// Creates an empty file that only the user can access. Returns false and sets errno if this fails
/// or if the path exists, even as a link.
bool make_private_file(const std::filesystem::path& file);

/// Writes a file atomically, also with concurrent writers. On error, the old content remains and
/// `error` is set. The file gets the default permissions of the process.
void write_atomically(const std::filesystem::path& file, std::string_view content,
                      std::error_code& error);

/// The same, in a folder that is created if it does not exist. Throws InputError naming the file.
void write_atomically(const std::filesystem::path& file, std::string_view content);

/// Removes temporary files of dead processes of this machine from the folder. Files of other
/// machines on a shared disk remain.
void remove_orphans(const std::filesystem::path& folder);

}  // namespace saltus
