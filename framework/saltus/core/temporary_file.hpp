// Names under which files and folders are begun that shall only be seen whole.
#pragma once

#include <filesystem>
#include <string_view>
#include <system_error>

namespace saltus {

/// .NAME.RANDOM.HOST.PROCESS.part beside `path`: nobody guesses it, and whose process is over is
/// known on that machine (remove_orphans()).
std::filesystem::path temporary_beside(const std::filesystem::path& path);

/// Makes an empty file that nobody else can open, and false if that cannot be done, or if anything
/// is there already, a link included; errno says why.
bool make_private_file(const std::filesystem::path& file);

/// Writes a file whole or not at all, whoever writes at the same time; with an error what was there
/// stays. It gets the rights that new files of the process have.
void write_whole(const std::filesystem::path& file, std::string_view content,
                 std::error_code& error);

/// Removes what processes of this machine that were killed had begun in the folder; not those of
/// others that share the disk.
void remove_orphans(const std::filesystem::path& folder);

}  // namespace saltus
