// PNG by libpng, and the comparison of images. libpng reports errors by longjmp: every function
// that calls setjmp here has only trivial locals, so nothing is left undestroyed. Gamma and colour
// profiles in files are ignored, as glTF 2.0 (section 3.8.3) asks for textures.
#include "sinew/io/image_file.h"

#include <png.h>

#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstring>
#include <limits>
#include <new>

#include "sinew/base/check.h"
#include "sinew/io/image_buffer.h"
#include "sinew/io/image_jpeg.h"
#include "sinew/io/output_file.h"

namespace sinew {
namespace {

// Deflate shrinks by no more than this.
constexpr uint64_t kMostDeflateRatio = 1032;
constexpr uint64_t kMostFileBytes = uint64_t{1} << 31;

// What libpng's callbacks share with us.
struct PngStream {
  std::span<const uint8_t> input;
  std::vector<uint8_t>* output = nullptr;
  char problem[128] = "";
};

void on_error(png_structp png, png_const_charp message) {
  auto* stream = static_cast<PngStream*>(png_get_error_ptr(png));
  std::strncpy(stream->problem, message, sizeof(stream->problem) - 1);
  png_longjmp(png, 1);
}
void on_warning(png_structp, png_const_charp) {}

void on_read(png_structp png, png_bytep out, size_t size) {
  auto* stream = static_cast<PngStream*>(png_get_io_ptr(png));
  if (size > stream->input.size()) png_error(png, "the file ends too early");
  std::memcpy(out, stream->input.data(), size);
  stream->input = stream->input.subspan(size);
}

void on_write(png_structp png, png_bytep bytes, size_t size) {
  auto* stream = static_cast<PngStream*>(png_get_io_ptr(png));
  bool stored = true;
  try {
    stream->output->insert(stream->output->end(), bytes, bytes + size);
  } catch (const std::bad_alloc&) {
    stored = false;
  }
  if (!stored) png_error(png, "out of memory");
}
void on_flush(png_structp) {}

struct PngReader {
  PngStream stream;
  png_structp png = nullptr;
  png_infop info = nullptr;

  explicit PngReader(std::span<const uint8_t> bytes) {
    stream.input = bytes;
    png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &stream, on_error, on_warning);
    if (png) info = png_create_info_struct(png);
  }
  ~PngReader() { png_destroy_read_struct(&png, &info, nullptr); }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  tl::unexpected<Error> error(const std::string& name) const {
    return fail({ErrorKind::bad_input, name, "", std::string("is a damaged PNG: ") + stream.problem,
                 "save the image again"});
  }
};

bool read_header(PngReader& reader) {
  if (!reader.info) return false;
  if (setjmp(png_jmpbuf(reader.png))) return false;
  png_set_read_fn(reader.png, &reader.stream, on_read);
  png_set_user_limits(reader.png, kMaxImageSide, kMaxImageSide);
  png_set_chunk_malloc_max(reader.png, 1 << 24);
  // What says nothing about pixels is skipped unread: some of libpng's handlers allocate what a
  // chunk claims to hold.
  png_set_keep_unknown_chunks(reader.png, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
  png_read_info(reader.png, reader.info);
  return true;
}

// Any colour type and depth becomes RGBA of 8 bits.
bool read_pixels(PngReader& reader, uint8_t* pixels, size_t stride) {
  if (setjmp(png_jmpbuf(reader.png))) return false;
  png_set_expand(reader.png);
  png_set_scale_16(reader.png);
  png_set_gray_to_rgb(reader.png);
  png_set_add_alpha(reader.png, 0xff, PNG_FILLER_AFTER);
  const int passes = png_set_interlace_handling(reader.png);
  png_read_update_info(reader.png, reader.info);
  if (png_get_rowbytes(reader.png, reader.info) != stride) {
    png_error(reader.png, "its pixel format is unknown");
  }
  const uint32_t height = png_get_image_height(reader.png, reader.info);
  for (int pass = 0; pass < passes; ++pass) {
    for (uint32_t y = 0; y < height; ++y) png_read_row(reader.png, pixels + y * stride, nullptr);
  }
  png_read_end(reader.png, nullptr);
  return true;
}

bool is_png(std::span<const uint8_t> bytes) {
  return bytes.size() >= 8 && png_sig_cmp(bytes.data(), 0, 8) == 0;
}

// The size, once the header is read; an error if the file is too short for it.
Result<ImageSize> checked_size(const PngReader& reader, size_t file_bytes,
                               const std::string& name) {
  const ImageSize size{png_get_image_width(reader.png, reader.info),
                       png_get_image_height(reader.png, reader.info)};
  if (png_get_rowbytes(reader.png, reader.info) * size.height > file_bytes * kMostDeflateRatio) {
    return fail({ErrorKind::bad_input, name, "",
                 "is a damaged PNG: it is too short for " + std::to_string(size.width) + " x " +
                     std::to_string(size.height) + " pixels",
                 "save the image again"});
  }
  return size;
}

Result<ImageSize> png_size(std::span<const uint8_t> bytes, const std::string& name) {
  PngReader reader(bytes);
  if (!read_header(reader)) return reader.error(name);
  return checked_size(reader, bytes.size(), name);
}

Result<Image8> decode_png(std::span<const uint8_t> bytes, const std::string& name) {
  PngReader reader(bytes);
  if (!read_header(reader)) return reader.error(name);
  SINEW_TRY(const ImageSize size, checked_size(reader, bytes.size(), name));
  SINEW_TRY(Image8 image, make_image(size, name));
  if (!read_pixels(reader, image.pixels.data(), size_t{4} * size.width)) return reader.error(name);
  return image;
}

struct PngWriter {
  PngStream stream;
  png_structp png = nullptr;
  png_infop info = nullptr;

  explicit PngWriter(std::vector<uint8_t>& output) {
    stream.output = &output;
    png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &stream, on_error, on_warning);
    if (png) info = png_create_info_struct(png);
  }
  ~PngWriter() { png_destroy_write_struct(&png, &info); }
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;
};

bool is_opaque(const Image8& image) {
  for (size_t i = 3; i < image.pixels.size(); i += 4) {
    if (image.pixels[i] != 255) return false;
  }
  return true;
}

// Opaque images are stored without alpha. Level 3 with the cheap filters makes rendered images 10
// to 15% larger than level 9 with all filters does, in a tenth of its time.
bool encode(PngWriter& writer, const Image8& image, std::span<png_text> texts, bool opaque) {
  if (!writer.info) return false;
  if (setjmp(png_jmpbuf(writer.png))) return false;
  png_set_write_fn(writer.png, &writer.stream, on_write, on_flush);
  png_set_user_limits(writer.png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
  png_set_compression_level(writer.png, 3);
  png_set_filter(writer.png, PNG_FILTER_TYPE_BASE, PNG_FAST_FILTERS);
  png_set_IHDR(writer.png, writer.info, image.width, image.height, 8,
               opaque ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_RGB_ALPHA, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB(writer.png, writer.info, PNG_sRGB_INTENT_PERCEPTUAL);
  png_set_text(writer.png, writer.info, texts.data(), static_cast<int>(texts.size()));
  png_write_info(writer.png, writer.info);
  if (opaque) png_set_filler(writer.png, 0, PNG_FILLER_AFTER);
  for (uint32_t y = 0; y < image.height; ++y) png_write_row(writer.png, image.at(0, y));
  png_write_end(writer.png, nullptr);
  return true;
}

// tEXt holds Latin-1 only, so anything beyond ASCII goes to iTXt (UTF-8).
std::vector<png_text> png_texts(const ImageMetadata& metadata) {
  std::vector<png_text> texts;
  for (const auto& [keyword, text] : metadata) {
    SINEW_CHECK(!keyword.empty() && keyword.size() < 80);
    const bool ascii = std::all_of(text.begin(), text.end(), [](char c) { return c >= 0; });
    png_text entry{};
    entry.compression = ascii ? PNG_TEXT_COMPRESSION_NONE : PNG_ITXT_COMPRESSION_NONE;
    entry.key = const_cast<char*>(keyword.c_str());
    entry.text = const_cast<char*>(text.c_str());
    entry.text_length = text.size();
    texts.push_back(entry);
  }
  return texts;
}

}  // namespace

Result<std::vector<uint8_t>> encode_png(const Image8& image, const std::string& name,
                                        const ImageMetadata& metadata) {
  SINEW_CHECK(image.pixels.size() == size_t{4} * image.width * image.height);
  if (image.pixels.empty()) {
    return fail({ErrorKind::usage, name, "", "the image has no pixels", "give it a size"});
  }
  std::vector<uint8_t> bytes;
  std::vector<png_text> texts = png_texts(metadata);
  PngWriter writer(bytes);
  if (!encode(writer, image, texts, is_opaque(image))) {
    return fail({ErrorKind::output, name, "",
                 std::string("cannot be encoded as PNG: ") + writer.stream.problem, ""});
  }
  return bytes;
}

Result<void> write_png(const std::string& path, const Image8& image,
                       const ImageMetadata& metadata) {
  SINEW_TRY(const std::vector<uint8_t> bytes, encode_png(image, path, metadata));
  return write_file(path, bytes);
}

Result<Image8> read_png(const std::string& path) {
  SINEW_TRY(const std::string file, read_file(path, kMostFileBytes));
  const std::span bytes(reinterpret_cast<const uint8_t*>(file.data()), file.size());
  if (!is_png(bytes)) {
    return fail({ErrorKind::bad_input, path, "", "is no PNG image", "convert it to PNG"});
  }
  return decode_png(bytes, path);
}

bool is_image(std::span<const uint8_t> bytes) {
  return is_png(bytes) || is_jpeg(bytes);
}

Result<ImageSize> image_size(std::span<const uint8_t> bytes, const std::string& name) {
  if (is_png(bytes)) return png_size(bytes, name);
  if (is_jpeg(bytes)) return jpeg_size(bytes, name);
  return fail({ErrorKind::bad_input, name, "", "is neither PNG nor JPEG", "convert it to PNG"});
}

Result<Image8> decode_image(std::span<const uint8_t> bytes, const std::string& name) {
  if (is_png(bytes)) return decode_png(bytes, name);
  if (is_jpeg(bytes)) return decode_jpeg(bytes, name);
  return fail({ErrorKind::bad_input, name, "", "is neither PNG nor JPEG", "convert it to PNG"});
}

Result<void> check_same_size(const Image8& a, const Image8& b) {
  if (a.width == b.width && a.height == b.height) return {};
  const auto text = [](const Image8& image) {
    return std::to_string(image.width) + " x " + std::to_string(image.height);
  };
  return fail({ErrorKind::bad_input, "", "",
               "the images differ in size: " + text(a) + " and " + text(b) + " pixels",
               "compare images of the same size"});
}

Result<ImageDifference> compare_images(const Image8& a, const Image8& b, int tolerance) {
  SINEW_CHECK(a.pixels.size() == size_t{4} * a.width * a.height);
  SINEW_CHECK(b.pixels.size() == size_t{4} * b.width * b.height);
  SINEW_CHECKED(check_same_size(a, b));
  ImageDifference result;
  uint64_t sum = 0, sum_of_squares = 0;
  int largest = 0;
  for (size_t i = 0; i < a.pixels.size(); i += 4) {
    int pixel = 0;
    for (size_t channel = 0; channel < 4; ++channel) {
      const int difference = std::abs(a.pixels[i + channel] - b.pixels[i + channel]);
      pixel = std::max(pixel, difference);
      if (channel == 3) continue;
      sum += static_cast<uint64_t>(difference);
      sum_of_squares += static_cast<uint64_t>(difference * difference);
    }
    largest = std::max(largest, pixel);
    result.pixels_over += pixel > tolerance;
  }
  const double values = 3.0 * a.width * a.height;
  result.mean = values > 0 ? static_cast<double>(sum) / values / 255.0 : 0.0;
  result.largest = largest / 255.0;
  result.psnr =
      sum_of_squares == 0
          ? std::numeric_limits<double>::infinity()
          : 10.0 * std::log10(255.0 * 255.0 * values / static_cast<double>(sum_of_squares));
  return result;
}

}  // namespace sinew
