#include "saltus/robots/control/mcap_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "saltus/core/error.hpp"

namespace saltus::robots::control {
namespace {

constexpr std::string_view magic{"\x89MCAP0\r\n", 8};
constexpr char header = 0x01, footer = 0x02, schema_record = 0x03, channel_record = 0x04,
               message_record = 0x05, data_end = 0x0f;
constexpr std::uint16_t schema_id = 1, channel_id = 0;

// Fields of a record, little-endian.
class Content {
 public:
  template <class Integer>
  Content& number(Integer value) {
    for (std::size_t i = 0; i < sizeof value; ++i)
      bytes_ += static_cast<char>((static_cast<std::uint64_t>(value) >> (8 * i)) & 0xffU);
    return *this;
  }
  Content& text(std::string_view value) {
    number(static_cast<std::uint32_t>(value.size()));
    bytes_ += value;
    return *this;
  }
  void write(char opcode, std::FILE* file) const {
    const std::string head = Content()
                                 .number(static_cast<std::uint8_t>(opcode))
                                 .number(std::uint64_t{bytes_.size()})
                                 .bytes_;
    std::fwrite(head.data(), 1, head.size(), file);
    std::fwrite(bytes_.data(), 1, bytes_.size(), file);
  }

 private:
  std::string bytes_;
};

}  // namespace

McapFile::McapFile(const std::filesystem::path& file, const std::string& topic,
                   const std::string& name, const std::string& schema)
    : file_(std::fopen(file.c_str(), "wb")) {
  if (file_ == nullptr)
    throw InputError(fmt::format("{}: cannot be written: {}", file.string(), std::strerror(errno)));
  std::fwrite(magic.data(), 1, magic.size(), file_);
  Content().text("").text("saltus").write(header, file_);
  Content()
      .number(schema_id)
      .text(name)
      .text("jsonschema")
      .text(schema)
      .write(schema_record, file_);
  Content()
      .number(channel_id)
      .number(schema_id)
      .text(topic)
      .text("json")
      .number(std::uint32_t{0})  // no metadata
      .write(channel_record, file_);
}

McapFile::~McapFile() {
  Content().number(std::uint32_t{0}).write(data_end, file_);
  Content()
      .number(std::uint64_t{0})
      .number(std::uint64_t{0})
      .number(std::uint32_t{0})
      .write(footer, file_);
  std::fwrite(magic.data(), 1, magic.size(), file_);
  std::fclose(file_);
}

void McapFile::add(double time, std::string_view json) {
  const auto nanoseconds = static_cast<std::uint64_t>(std::max(0LL, std::llround(1e9 * time)));
  const std::uint64_t size = 2 + 4 + 8 + 8 + json.size();
  char head[31];
  char* at = head;
  const auto put = [&at](auto value, int bytes) {
    for (int i = 0; i < bytes; ++i)
      *at++ = static_cast<char>((static_cast<std::uint64_t>(value) >> (8 * i)) & 0xffU);
  };
  put(message_record, 1);
  put(size, 8);
  put(channel_id, 2);
  put(sequence_++, 4);
  put(nanoseconds, 8);
  put(nanoseconds, 8);
  std::fwrite(head, 1, sizeof head, file_);
  std::fwrite(json.data(), 1, json.size(), file_);
}

void McapFile::flush() { std::fflush(file_); }

}  // namespace saltus::robots::control
