// Takes the values of a PLY file's body one after the other, whatever their form and type.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "sinew/io/ply/header.h"

namespace sinew {

class PlyValues {
 public:
  PlyValues(PlyFormat format, std::string_view body) : format_(format), rest_(body) {}

  // The next value (doubles hold each type exactly), or false: see problem().
  bool take(PlyType type, double& out);
  // Passes over `count` values.
  bool skip(PlyType type, uint64_t count);

  // Bytes behind the last value taken; blanks around text do not count.
  uint64_t left();
  // Why the last call gave false.
  std::string problem() const;

 private:
  std::string_view take_word();
  void skip_blanks();

  PlyFormat format_;
  std::string_view rest_;
  std::string_view wrong_;  // a word that is not a number
};

}  // namespace sinew
