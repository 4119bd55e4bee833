#include "saltus/model/named_parameters.hpp"

#include <fmt/format.h>

#include "saltus/core/error.hpp"

namespace saltus::detail {

void throw_view_too_short(int size, int offset, int given) {
  throw DefinitionError(
      fmt::format("a named block needs entries {} to {} of p, but p has {} entries", offset,
                  offset + size - 1, given));
}

}  // namespace saltus::detail
