// The problems of the library cause no warnings, although some look like typical mistakes.
#include <gtest/gtest.h>

#include "problems/library/catalogue.hpp"

namespace saltus {
namespace {

TEST(Library, HasNoWarnings) {
  for (const ReferenceCase& c : reference_cases())
    for (const std::string& warning : c.problem().warnings())
      ADD_FAILURE() << c.id << ": " << warning;
}

}  // namespace
}  // namespace saltus
