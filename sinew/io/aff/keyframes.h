// The keyframes of one transform: what a statement `k NAME { ... }` holds.
#pragma once

#include <string>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/io/aff/text.h"
#include "sinew/scene/clip.h"

namespace sinew::aff {

struct Keyframes {
  std::string name;               // of the transforms that it moves
  std::vector<Channel> channels;  // at most one a path; their node is not set
  uint64_t line = 0;              // of the statement
};

// Reads what follows `k`. Keys that go back in time are named in `warnings`.
Result<Keyframes> read_keyframes(Words& words, std::vector<std::string>& warnings);

}  // namespace sinew::aff
