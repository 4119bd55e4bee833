// A name of bounded length, stored in place. Copying and assigning never allocate.
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <string>
#include <string_view>

#include "saltus/core/error.hpp"

namespace saltus {

/// Converts to std::string_view. The constructor throws DefinitionError if the text is longer than
/// max_size.
class ShortName {
 public:
  static constexpr std::size_t max_size = 63;  // with the length, one cache line

  ShortName() = default;
  /// Copies the text. Throws DefinitionError if it is longer than max_size.
  template <class Text>
    requires std::convertible_to<const Text&, std::string_view>
  ShortName(const Text& text) {  // NOLINT(google-explicit-constructor)
    assign(text);
  }

  /// The text. Valid during the lifetime of this object.
  std::string_view view() const { return {text_.data(), size_}; }
  /// The text as a std::string.
  std::string str() const { return std::string(view()); }
  /// Same as view().
  operator std::string_view() const { return view(); }  // NOLINT(google-explicit-constructor)
  /// Compares the texts.
  friend bool operator==(const ShortName& a, const ShortName& b) { return a.view() == b.view(); }

 private:
  void assign(std::string_view text) {
    if (text.size() > max_size)
      throw DefinitionError("the name '" + std::string(text) + "' has " +
                            std::to_string(text.size()) + " characters, but a name has at most " +
                            std::to_string(max_size));
    std::copy(text.begin(), text.end(), text_.begin());
    size_ = static_cast<unsigned char>(text.size());
  }

  std::array<char, max_size> text_{};
  unsigned char size_ = 0;
};

}  // namespace saltus
