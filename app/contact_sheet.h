// A contact sheet: small copies of frames, evenly chosen, side by side in one picture.
#pragma once

#include <vector>

#include "sinew/io/image_file.h"
#include "sinew/scene/image.h"

namespace sinew::app {

class ContactSheet {
 public:
  // For `frames` frames of one size; at most kMaxPictures of them are shown.
  ContactSheet(ImageSize frame_size, size_t frames);

  // Frame `index` (0-based, in order); copied only if it was chosen.
  void add(size_t index, const Image8& frame);
  const Image8& image() const { return sheet_; }

  static constexpr size_t kMaxPictures = 20;

 private:
  ImageSize cell_;
  uint32_t shrink_ = 1;  // this many pixels squared become one
  uint32_t columns_ = 1;
  size_t frames_ = 1;
  size_t pictures_ = 1;
  size_t added_ = 0;
  Image8 sheet_;
};

}  // namespace sinew::app
