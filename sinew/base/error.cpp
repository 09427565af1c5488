#include "sinew/base/error.h"

namespace sinew {

std::string Error::message() const {
  std::string text;
  for (const std::string* part : {&file, &element}) {
    if (!part->empty()) text += *part + ": ";
  }
  text += problem;
  if (!remedy.empty()) text += " (" + remedy + ")";
  return text;
}

}  // namespace sinew
