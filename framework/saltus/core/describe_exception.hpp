// The message of an exception of unknown type.
#pragma once

#include <exception>
#include <string>

namespace saltus {

/// Message of the exception being handled. Call it only inside a catch block.
inline std::string describe_exception() {
  try {
    throw;
  } catch (const std::exception& error) {
    return error.what();
  } catch (...) {
    return "an exception that is not a std::exception";
  }
}

}  // namespace saltus
