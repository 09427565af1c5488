// JPEG (baseline and progressive) by libjpeg-turbo, behind guards that it leaves to its users: the
// file must be able to hold the size it claims, may not make the decoder pass over the image again
// and again, and must be complete. As in image_file.cpp, errors come by longjmp over trivial
// locals.
#include "sinew/io/image_jpeg.h"

#include <csetjmp>
#include <cstdio>

#include <jerror.h>
#include <jpeglib.h>  // needs <cstdio> before it

#include "sinew/io/image_buffer.h"

namespace sinew {
namespace {

// A block of 8 x 8 pixels takes at least one bit, of its DC coefficient.
constexpr uint64_t kMostPixelsPerByte = 8 * 64;
// Progressive files have about ten; each costs a pass over the image however short it is.
constexpr int kMostScans = 200;

struct JpegReader {
  jpeg_decompress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg_progress_mgr progress{};
  std::jmp_buf on_error;
  char problem[JMSG_LENGTH_MAX] = "";

  ~JpegReader() { jpeg_destroy_decompress(&jpeg); }
  tl::unexpected<Error> error(const std::string& name) const {
    return fail({ErrorKind::bad_input, name, "", std::string("is a damaged JPEG: ").append(problem),
                 "save the image again"});
  }
};

JpegReader& reader_of(j_common_ptr jpeg) {
  return *static_cast<JpegReader*>(jpeg->client_data);
}

[[noreturn]] void stop(j_common_ptr jpeg) {
  JpegReader& reader = reader_of(jpeg);
  jpeg->err->format_message(jpeg, reader.problem);
  std::longjmp(reader.on_error, 1);
}

// libjpeg fills what is missing with grey and warns; here a cut-off file is an error.
void on_message(j_common_ptr jpeg, int level) {
  const int code = jpeg->err->msg_code;
  if (level < 0 && (code == JWRN_JPEG_EOF || code == JWRN_HIT_MARKER)) stop(jpeg);
}

void on_progress(j_common_ptr common) {
  JpegReader& reader = reader_of(common);
  if (reader.jpeg.input_scan_number <= kMostScans) return;
  std::snprintf(reader.problem, sizeof(reader.problem), "it has more than %d scans", kMostScans);
  std::longjmp(reader.on_error, 1);
}

bool read_header(JpegReader& reader, const uint8_t* bytes, size_t size) {
  reader.jpeg.err = jpeg_std_error(&reader.errors);
  reader.errors.error_exit = stop;
  reader.errors.emit_message = on_message;
  reader.jpeg.client_data = &reader;
  if (setjmp(reader.on_error)) return false;
  jpeg_create_decompress(&reader.jpeg);
  reader.progress.progress_monitor = on_progress;
  reader.jpeg.progress = &reader.progress;
  jpeg_mem_src(&reader.jpeg, bytes, size);
  jpeg_read_header(&reader.jpeg, TRUE);
  return true;
}

bool read_pixels(JpegReader& reader, uint8_t* pixels) {
  if (setjmp(reader.on_error)) return false;
  reader.jpeg.out_color_space = JCS_EXT_RGBA;
  jpeg_start_decompress(&reader.jpeg);
  const size_t stride = size_t{4} * reader.jpeg.output_width;
  while (reader.jpeg.output_scanline < reader.jpeg.output_height) {
    JSAMPROW row = pixels + stride * reader.jpeg.output_scanline;
    jpeg_read_scanlines(&reader.jpeg, &row, 1);
  }
  jpeg_finish_decompress(&reader.jpeg);
  return true;
}

Result<ImageSize> checked_size(const JpegReader& reader, size_t file_bytes,
                               const std::string& name) {
  const uint32_t width = reader.jpeg.image_width, height = reader.jpeg.image_height;
  const char* problem = nullptr;
  const char* remedy = "save the image again";
  if (width > kMaxImageSide || height > kMaxImageSide) {
    problem = "is larger than 16384 pixels a side";
    remedy = "make the image smaller";
  } else if (uint64_t{width} * height > file_bytes * kMostPixelsPerByte) {
    problem = "is a damaged JPEG: it is too short for its size in pixels";
  } else if (reader.jpeg.jpeg_color_space == JCS_CMYK || reader.jpeg.jpeg_color_space == JCS_YCCK) {
    problem = "is a JPEG for print (CMYK)";
    remedy = "save the image as RGB";
  }
  if (problem) return fail({ErrorKind::bad_input, name, "", problem, remedy});
  return ImageSize{width, height};
}

}  // namespace

Result<ImageSize> jpeg_size(std::span<const uint8_t> bytes, const std::string& name) {
  JpegReader reader;
  if (!read_header(reader, bytes.data(), bytes.size())) return reader.error(name);
  return checked_size(reader, bytes.size(), name);
}

Result<Image8> decode_jpeg(std::span<const uint8_t> bytes, const std::string& name) {
  JpegReader reader;
  if (!read_header(reader, bytes.data(), bytes.size())) return reader.error(name);
  SINEW_TRY(const ImageSize size, checked_size(reader, bytes.size(), name));
  SINEW_TRY(Image8 image, make_image(size, name));
  if (!read_pixels(reader, image.pixels.data())) return reader.error(name);
  return image;
}

}  // namespace sinew
