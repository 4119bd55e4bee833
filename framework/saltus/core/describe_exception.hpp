// What an exception of somebody else's code has to say, for messages.
#pragma once

#include <exception>
#include <string>

namespace saltus {

/// Within a catch (...): the words of what was caught, or that it has none.
inline std::string describe_exception() {
  try {
    throw;
  } catch (const std::exception& error) {
    return error.what();
  } catch (...) {
    return "something that is no std::exception";
  }
}

}  // namespace saltus
