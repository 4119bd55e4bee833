// Writes MCAP files (https://mcap.dev/spec) message by message. They have no chunks and no index,
// so the file of a killed process is readable up to its last message.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>

namespace saltus::robots::control {

/// An MCAP file with one channel of JSON messages.
class McapFile {
 public:
  /// Creates the file. `schema`: JSON Schema of the messages. Throws InputError if the file cannot
  /// be written.
  McapFile(const std::filesystem::path& file, const std::string& topic, const std::string& name,
           const std::string& schema);
  /// Completes the file.
  ~McapFile();
  McapFile(const McapFile&) = delete;
  McapFile& operator=(const McapFile&) = delete;

  /// Adds a message with this time, s.
  void add(double time, std::string_view json);
  /// Passes all messages to the operating system.
  void flush();

 private:
  std::FILE* file_;
  std::uint32_t sequence_ = 0;
};

}  // namespace saltus::robots::control
