#include "problems/library/npz.hpp"

#include <bit>
#include <cstdint>
#include <cstring>
#include <optional>
#include <regex>
#include <string_view>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/core/file_content.hpp"

namespace saltus::library {
namespace {

static_assert(std::endian::native == std::endian::little, "the files are little-endian");

class Bytes {
 public:
  Bytes(std::string_view data, const std::string& path) : data_(data), path_(path) {}
  std::string_view at(std::size_t offset, std::size_t size) const {
    if (offset > data_.size() || size > data_.size() - offset) fail("it ends too early");
    return data_.substr(offset, size);
  }
  template <class T>
  T number(std::size_t offset) const {
    T value;
    std::memcpy(&value, at(offset, sizeof(T)).data(), sizeof(T));
    return value;
  }
  std::size_t size() const { return data_.size(); }
  [[noreturn]] void fail(const std::string& why) const {
    throw InputError("'" + path_ + "' cannot be read: " + why + ".");
  }

 private:
  std::string_view data_;
  const std::string& path_;
};

// One member: magic number, version, length of the header, a header in Python syntax, numbers by
// rows.
std::optional<MatrixXd> parse_npy(const Bytes& file, std::size_t offset) {
  if (file.at(offset, 6) != std::string_view("\x93NUMPY", 6)) file.fail("a member is not an array");
  const bool first_version = file.number<std::uint8_t>(offset + 6) == 1;
  const std::size_t begin = offset + (first_version ? 10 : 12);
  const std::size_t length = first_version ? file.number<std::uint16_t>(offset + 8)
                                           : file.number<std::uint32_t>(offset + 8);
  constexpr std::size_t longest_header = 1000;  // numpy's are below 200; std::regex recurses
  if (length > longest_header) file.fail("the header of an array is too long");
  const std::string header(file.at(begin, length));
  if (header.find("'<f8'") == std::string::npos) return std::nullopt;
  static const std::regex sizes(R"('shape': \((\d+),(?: (\d+))?\))");
  std::smatch shape;
  if (!std::regex_search(header, shape, sizes) ||
      header.find("'fortran_order': False") == std::string::npos)
    file.fail("an array is neither a vector nor a matrix stored by rows");
  const auto size = [&](const std::string& digits) {
    if (digits.size() > 9) file.fail("an array is too large");  // no product overflows
    return static_cast<std::size_t>(std::stoul(digits));
  };
  const std::size_t rows = size(shape[1]), cols = shape[2].matched ? size(shape[2]) : 1;
  const std::string_view numbers = file.at(begin + length, rows * cols * sizeof(double));
  if (numbers.empty()) return MatrixXd(rows, cols);
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> M(rows, cols);
  std::memcpy(M.data(), numbers.data(), numbers.size());
  return MatrixXd(M);
}

}  // namespace

std::map<std::string, MatrixXd> read_npz(const std::string& path) {
  const std::string data = file_content(path);
  const Bytes file(data, path);

  // The directory of the archive is located from the end of the file.
  const std::size_t end = data.rfind("PK\x05\x06");
  if (end == std::string::npos) file.fail("it is not a zip archive");
  const int members = file.number<std::uint16_t>(end + 10);
  std::size_t entry = file.number<std::uint32_t>(end + 16);
  std::map<std::string, MatrixXd> arrays;
  std::size_t bytes = 0;
  for (int i = 0; i < members; ++i) {
    if (file.at(entry, 4) != "PK\x01\x02") file.fail("its directory is damaged");
    if (file.number<std::uint16_t>(entry + 10) != 0) file.fail("a member is compressed");
    const std::size_t name_length = file.number<std::uint16_t>(entry + 28);
    const std::size_t local = file.number<std::uint32_t>(entry + 42);
    std::string name(file.at(entry + 46, name_length));
    entry += 46 + name_length + file.number<std::uint16_t>(entry + 30) +
             file.number<std::uint16_t>(entry + 32);
    const std::size_t content = local + 30 + file.number<std::uint16_t>(local + 26) +
                                file.number<std::uint16_t>(local + 28);
    auto array = parse_npy(file, content);
    if (array) bytes += sizeof(double) * static_cast<std::size_t>(array->size());
    if (bytes > data.size()) file.fail("its members overlap");
    if (array) arrays[name.substr(0, name.rfind(".npy"))] = std::move(*array);
  }
  return arrays;
}

}  // namespace saltus::library
