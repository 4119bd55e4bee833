// Messages of errors that a test expects.
#pragma once

#include <gtest/gtest.h>

#include <initializer_list>
#include <string>

#include "saltus/core/error.hpp"

namespace saltus {

/// Message of the error that the call throws, or `none` if it throws nothing.
template <class Error, class Call>
std::string error_of(const Call& call, const std::string& none = "no error") {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return none;
}

/// Expects an error whose message contains all parts. A failure names the caller's line.
template <class Error, class Call>
void expect_error(const Call& call, std::initializer_list<std::string> parts,
                  const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
  const ::testing::ScopedTrace trace(file, line, "here");
  const std::string message = error_of<Error>(call);
  for (const std::string& part : parts)
    EXPECT_NE(message.find(part), std::string::npos) << "'" << part << "' is not in: " << message;
}

}  // namespace saltus
