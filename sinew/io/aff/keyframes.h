// The keyframes of one transform: what a statement `k NAME { ... }` holds.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/io/aff/text.h"
#include "sinew/scene/clip.h"

namespace sinew::aff {

struct Keyframes {
  std::string name;               // of the transforms that it moves
  std::vector<Channel> channels;  // at most one a path; their node is not set
};

// Reads what follows `k`. Keys that go back in time are named in `warnings`. An error if the
// channels might take more than `memory` bytes, before they do.
Result<Keyframes> read_keyframes(Words& words, uint64_t memory, std::vector<std::string>& warnings);

}  // namespace sinew::aff
