// Result<T>: how every function that touches files, users or devices reports failure.
// The library never prints, never exits and never throws across its API.
#pragma once

#include <cstdint>
#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace sinew {

// What went wrong, in the terms of the program's exit codes.
enum class ErrorKind : uint8_t {
  runtime,    // exit code 1: something failed inside
  usage,      // exit code 2: an argument or option makes no sense
  bad_input,  // exit code 3: a file is missing, damaged, hostile or unsupported
  output,     // exit code 4: a result could not be written
};

struct Error {
  ErrorKind kind = ErrorKind::runtime;
  std::string file;     // the file concerned; empty if none is
  std::string element;  // the part of it: "accessor 3", "line 12", "frame 7"; may be empty
  std::string problem;  // what is wrong
  std::string remedy;   // what the user can do about it; may be empty

  // "walk.glb: accessor 3: reads past the end of its buffer (export the file again)"
  std::string message() const;
};

template <class T>
using Result = tl::expected<T, Error>;

inline tl::unexpected<Error> fail(Error error) {
  return tl::unexpected<Error>(std::move(error));
}

}  // namespace sinew

// Evaluates `expression` (a Result); on failure returns its error from the enclosing function, else
// puts the value in `target`. SINEW_CHECKED does the same for a Result<void>.
#define SINEW_TRY(target, expression) \
  SINEW_TRY_IMPL_(target, expression, SINEW_TRY_NAME_(sinew_result_, __LINE__))
#define SINEW_CHECKED(expression)                                                \
  do {                                                                           \
    if (auto sinew_status_ = (expression); !sinew_status_)                       \
      return ::tl::unexpected<::sinew::Error>(std::move(sinew_status_).error()); \
  } while (false)
#define SINEW_TRY_JOIN_(a, b) a##b
#define SINEW_TRY_NAME_(a, b) SINEW_TRY_JOIN_(a, b)
#define SINEW_TRY_IMPL_(target, expression, result)                                \
  auto result = (expression);                                                      \
  if (!result) return ::tl::unexpected<::sinew::Error>(std::move(result).error()); \
  target = std::move(*result)
