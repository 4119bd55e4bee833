// Named parameters: a struct declares entries of p (scalars, vectors, matrices), formulas read them
// by member, and values are set by name. Sizes, offsets and names follow from one list:
//
//   template <class S>
//   struct Road {
//     S slope = 0.0;                           // rad
//     Vec<S, 2> wind = Vec<S, 2>::Zero();      // m/s
//     using Entries = ParameterEntries<&Road::slope, &Road::wind>;
//   };
//   Phase<2, 1, size_of<Road>> drive{...};     // p has 3 entries
//   drive.data("road", Road<double>{.slope = 0.1});
//   [](auto t, auto x, auto u, auto p) { const auto road = view_as<Road>(p); ... road.slope ... }
//   shooting.set_data("road", Road<double>{});
//   shooting.set_data("road.slope", 0.2);
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>
#include <type_traits>

#include "saltus/core/types.hpp"

namespace saltus {

/// Position of a named entry in its block. Matrices are stored row-major, as they are written.
struct ParameterEntry {
  std::string_view name;              ///< member name
  int first = 0, rows = 1, cols = 1;  ///< index of the first number; rows and columns of the entry

  /// Number of scalars.
  constexpr int size() const { return rows * cols; }
  friend bool operator==(const ParameterEntry&, const ParameterEntry&) = default;
};

/// List of all members of the declaring struct, each once, in order of declaration.
template <auto... members>
struct ParameterEntries {};

namespace detail {

// Shape of an entry for any scalar. Types other than matrices are scalars.
template <class T>
struct EntryShape {
  static constexpr int rows = 1, cols = 1;
};
template <class S, int r, int c, int options>
struct EntryShape<Eigen::Matrix<S, r, c, options>> {
  static_assert(r > 0 && c > 0, "entries of parameters have sizes known at compile time");
  static constexpr int rows = r, cols = c;
};

template <class T>
struct MemberOf;
template <class Block, class T>
struct MemberOf<T Block::*> {
  using Type = T;
};

// Takes the name of a member from the compiler, so that no string can disagree with it.
// __PRETTY_FUNCTION__ reads "... member = &Road<double>::slope; ..." (gcc) or "... member =
// &Road<double>::slope]" (clang). Clang writes (anonymous namespace) where gcc writes {anonymous}.
template <auto member>
struct MemberName {
  static constexpr auto get() {
    std::string_view text = __PRETTY_FUNCTION__;
    text = text.substr(text.find("member = ") + 9);
    text = text.substr(0, text.find_first_of(";]"));
    text = text.substr(text.rfind("::") + 2);
    return text.substr(0, text.find(')'));
  }
};

template <class List>
struct EntryTable;
template <auto... members>
struct EntryTable<ParameterEntries<members...>> {
  template <class M>
  using Shape = EntryShape<typename MemberOf<M>::Type>;

  static constexpr std::size_t count = sizeof...(members);
  static constexpr int size =
      (0 + ... + (Shape<decltype(members)>::rows * Shape<decltype(members)>::cols));
  static constexpr std::array<ParameterEntry, count> entries = [] {
    std::array<ParameterEntry, count> all{
        {{MemberName<members>::get(), 0, Shape<decltype(members)>::rows,
          Shape<decltype(members)>::cols}...}};
    for (std::size_t i = 1; i < count; ++i) all[i].first = all[i - 1].first + all[i - 1].size();
    return all;
  }();
  // Size in bytes of a struct with exactly these members in this order.
  static constexpr std::size_t bytes = [] {
    std::size_t end = 0, largest = 1;
    const auto append = [&](std::size_t alignment, std::size_t member_bytes) {
      end = (end + alignment - 1) / alignment * alignment + member_bytes;
      largest = alignment > largest ? alignment : largest;
    };
    (append(alignof(typename MemberOf<decltype(members)>::Type),
            sizeof(typename MemberOf<decltype(members)>::Type)),
     ...);
    return (end + largest - 1) / largest * largest;
  }();

  // Calls f(member, entry) for each member.
  template <class F>
  static constexpr void visit(F&& f) {
    std::size_t i = 0;
    (f(members, entries[i++]), ...);
  }
};

[[noreturn]] void throw_view_too_short(int size, int offset, int given);

// A scalar with an odd size, so that padding cannot hide a missing member.
struct OddScalar {
  char bytes[17];
};

}  // namespace detail

/// A block of parameters with values, e.g. Road<double>.
template <class T>
concept NamedParameters = requires { typename T::Entries; };

namespace detail {
template <NamedParameters B>
using TableOf = EntryTable<typename B::Entries>;

template <template <class> class Block>
constexpr int checked_size() {
  static_assert(sizeof(Block<OddScalar>) == TableOf<Block<OddScalar>>::bytes,
                "Entries must list every member of the struct once, in the order of declaration");
  return TableOf<Block<double>>::size;
}

template <class B>
inline constexpr bool lists_every_member = false;
template <template <class> class Block, class S>
inline constexpr bool lists_every_member<Block<S>> = checked_size<Block>() >= 0;
}  // namespace detail

/// Number of entries of p in a block.
template <template <class> class Block>
inline constexpr int size_of = detail::checked_size<Block>();

/// Offset of a block declared after the given blocks: view_as<Tyres>(p, after<Road>).
template <template <class> class... Before>
inline constexpr int after = (0 + ... + size_of<Before>);

/// Names and offsets of the entries of a block.
template <NamedParameters B>
constexpr std::span<const ParameterEntry> entries_of() {
  static_assert(detail::lists_every_member<B>);
  return detail::TableOf<B>::entries;
}

/// The values of a block in the order of p.
template <NamedParameters B>
Vec<double, detail::TableOf<B>::size> packed(const B& block) {
  static_assert(detail::lists_every_member<B>);
  Vec<double, detail::TableOf<B>::size> p;
  detail::TableOf<B>::visit([&](auto member, const ParameterEntry& entry) {
    using Shape = detail::EntryShape<typename detail::MemberOf<decltype(member)>::Type>;
    if constexpr (Shape::rows * Shape::cols == 1 &&
                  std::is_convertible_v<decltype(block.*member), double>) {
      p[entry.first] = block.*member;
    } else {
      for (int r = 0; r < Shape::rows; ++r)
        for (int c = 0; c < Shape::cols; ++c)
          p[entry.first + r * Shape::cols + c] = (block.*member)(r, c);
    }
  });
  return p;
}

/// Reads the entries of p into the struct. `offset` is the number of entries in preceding blocks,
/// see after<>. If the size of p is known at run time only, as in a Solution, throws
/// DefinitionError if the block does not fit.
template <template <class> class Block, class P>
Block<typename P::Scalar> view_as(const Eigen::MatrixBase<P>& p, int offset = 0) {
  using S = typename P::Scalar;
  constexpr int size = size_of<Block>;
  static_assert(P::SizeAtCompileTime == Eigen::Dynamic || P::SizeAtCompileTime >= size,
                "the block has more entries than p: is it declared in this phase, and is size_of "
                "part of the phase's np?");
  if constexpr (P::SizeAtCompileTime == Eigen::Dynamic)
    if (offset < 0 || p.size() < offset + size)
      detail::throw_view_too_short(size, offset, static_cast<int>(p.size()));
  Block<S> block;
  detail::TableOf<Block<S>>::visit([&](auto member, const ParameterEntry& entry) {
    using Shape = detail::EntryShape<typename detail::MemberOf<decltype(member)>::Type>;
    if constexpr (Shape::rows * Shape::cols == 1 &&
                  std::is_same_v<typename detail::MemberOf<decltype(member)>::Type, S>) {
      block.*member = p(offset + entry.first);
    } else {
      for (int r = 0; r < Shape::rows; ++r)
        for (int c = 0; c < Shape::cols; ++c)
          (block.*member)(r, c) = p(offset + entry.first + r * Shape::cols + c);
    }
  });
  return block;
}

}  // namespace saltus
