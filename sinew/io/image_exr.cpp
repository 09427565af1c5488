// OpenEXR by its C++ library, to and from memory: files are written atomically by write_file, and
// read whole so that their size is known. The library's C core checks headers first, for it takes
// limits and allocates nothing before it has.
#include "sinew/io/image_exr.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfMatrixAttribute.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <half.h>
#include <openexr.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <exception>
#include <new>

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"
#include "sinew/io/output_file.h"

namespace sinew {
namespace {

constexpr uint64_t kMostFileBytes = uint64_t{1} << 32;
// Pixels may take this much more memory than their file, as deflate does at its best; small
// pictures, which other methods shrink further, may anyway.
constexpr uint64_t kMostRatio = 1032;
constexpr uint64_t kSmallImage = uint64_t{64} << 20;  // bytes
constexpr int kZipLevel = 4;  // 0..9; more takes twice the time for some per cent

class ByteSink : public Imf::OStream {
 public:
  ByteSink() : OStream("memory") {}
  void write(const char* bytes, int count) override {
    const auto size = static_cast<size_t>(count);
    if (position_ + size > bytes_.size()) bytes_.resize(position_ + size);
    std::memcpy(bytes_.data() + position_, bytes, size);
    position_ += size;
  }
  uint64_t tellp() override { return position_; }
  void seekp(uint64_t position) override { position_ = position; }
  std::span<const uint8_t> bytes() const { return bytes_; }

 private:
  std::vector<uint8_t> bytes_;
  size_t position_ = 0;
};

class ByteSource : public Imf::IStream {
 public:
  explicit ByteSource(std::span<const uint8_t> bytes) : IStream("memory"), bytes_(bytes) {}
  bool read(char* out, int count) override {
    const auto size = static_cast<uint64_t>(count);
    if (position_ > bytes_.size() || size > bytes_.size() - position_) {
      throw std::runtime_error("the file ends too early");
    }
    std::memcpy(out, bytes_.data() + position_, size);
    position_ += size;
    return position_ < bytes_.size();
  }
  uint64_t tellg() override { return position_; }
  void seekg(uint64_t position) override { position_ = position; }

 private:
  std::span<const uint8_t> bytes_;
  uint64_t position_ = 0;
};

// OpenEXR multiplies row vectors, and stores rows first: our columns.
Imath::M44f to_imath(const mat4& m) {
  Imath::M44f out;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) out[i][j] = m[i][j];
  }
  return out;
}
mat4 from_imath(const Imath::M44f& m) {
  mat4 out;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) out[i][j] = m[i][j];
  }
  return out;
}

Imf::PixelType pixel_type(ExrType type) {
  return type == ExrType::uint32 ? Imf::UINT : type == ExrType::half ? Imf::HALF : Imf::FLOAT;
}

half clamped_half(float value) {
  return half(std::isfinite(value) ? std::clamp(value, -65504.0f, 65504.0f) : value);
}

// A slice of a whole picture of size width, whose first value is at `first`.
template <class T>
Imf::Slice make_slice(Imf::PixelType type, const T* first, size_t stride, uint32_t width) {
  // The library takes a pointer that it may write to, yet only reads when it writes a file.
  auto* base = reinterpret_cast<char*>(const_cast<T*>(first));
  return Imf::Slice(type, base, stride * sizeof(T), stride * sizeof(T) * width);
}

// May throw. `halves` keeps what the slices point to.
Imf::FrameBuffer make_frame(ImageSize size, std::span<const ExrChannel> channels,
                            std::vector<std::vector<half>>& halves) {
  Imf::FrameBuffer frame;
  const size_t pixels = size_t{size.width} * size.height;
  for (const ExrChannel& channel : channels) {
    const Imf::PixelType type = pixel_type(channel.type);
    if (const auto* integers = std::get_if<const uint32_t*>(&channel.first)) {
      SINEW_CHECK(channel.type == ExrType::uint32);
      frame.insert(channel.name, make_slice(type, *integers, channel.stride, size.width));
      continue;
    }
    SINEW_CHECK(channel.type != ExrType::uint32);
    const float* const floats = std::get<const float*>(channel.first);
    if (channel.type == ExrType::float32) {
      frame.insert(channel.name, make_slice(type, floats, channel.stride, size.width));
      continue;
    }
    std::vector<half>& plane = halves.emplace_back(pixels);
    parallel_for(pixels, 8192, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) plane[i] = clamped_half(floats[i * channel.stride]);
    });
    frame.insert(channel.name, make_slice(type, plane.data(), 1, size.width));
  }
  return frame;
}

// May throw.
Imf::Header make_header(ImageSize size, std::span<const ExrChannel> channels,
                        const ExrAttributes& attributes) {
  Imf::Header header(static_cast<int>(size.width), static_cast<int>(size.height));
  header.compression() = Imf::ZIP_COMPRESSION;
  header.zipCompressionLevel() = kZipLevel;
  for (const ExrChannel& channel : channels) {
    SINEW_CHECK(header.channels().findChannel(channel.name) == nullptr);
    header.channels().insert(channel.name, Imf::Channel(pixel_type(channel.type)));
  }
  for (const auto& [name, text] : attributes.texts) {
    header.insert(name, Imf::StringAttribute(text));
  }
  if (attributes.world_to_camera) {
    Imf::addWorldToCamera(header, to_imath(*attributes.world_to_camera));
  }
  if (attributes.world_to_ndc) Imf::addWorldToNDC(header, to_imath(*attributes.world_to_ndc));
  return header;
}

tl::unexpected<Error> damaged(const std::string& name, const std::string& problem) {
  return fail(
      {ErrorKind::bad_input, name, "", "is a damaged EXR: " + problem, "save the image again"});
}

tl::unexpected<Error> unsupported(const std::string& name, const std::string& problem) {
  return fail({ErrorKind::bad_input, name, "", problem, "save it as a flat EXR of one size"});
}

// What the core library reads from, and the last thing it complained about.
struct CoreStream {
  std::span<const uint8_t> bytes;
  std::string problem = "its header makes no sense";
};

CoreStream* stream_of(exr_const_context_t context) {
  void* data = nullptr;
  return exr_get_user_data(context, &data) == EXR_ERR_SUCCESS ? static_cast<CoreStream*>(data)
                                                              : nullptr;
}

int64_t core_read(exr_const_context_t, void* data, void* out, uint64_t size, uint64_t offset,
                  exr_stream_error_func_ptr_t) {
  const auto& bytes = static_cast<const CoreStream*>(data)->bytes;
  if (offset >= bytes.size()) return 0;
  const uint64_t count = std::min<uint64_t>(size, bytes.size() - offset);
  std::memcpy(out, bytes.data() + offset, count);
  return static_cast<int64_t>(count);
}
int64_t core_size(exr_const_context_t, void* data) {
  return static_cast<int64_t>(static_cast<const CoreStream*>(data)->bytes.size());
}
void core_error(exr_const_context_t context, exr_result_t, const char* message) {
  CoreStream* const stream = stream_of(context);
  if (stream && message) stream->problem = message;
}

// The size of the first part, if it can be held and the file is long enough for it.
Result<ImageSize> check_first_part(exr_context_t context, const CoreStream& stream,
                                   const std::string& name) {
  exr_storage_t storage{};
  exr_attr_box2i_t window{};
  int32_t chunks = 0;
  const exr_attr_chlist_t* channels = nullptr;
  if (exr_get_storage(context, 0, &storage) != EXR_ERR_SUCCESS ||
      exr_get_data_window(context, 0, &window) != EXR_ERR_SUCCESS ||
      exr_get_chunk_count(context, 0, &chunks) != EXR_ERR_SUCCESS ||
      exr_get_channels(context, 0, &channels) != EXR_ERR_SUCCESS) {
    return damaged(name, stream.problem);
  }
  if (storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED) {
    return unsupported(name, "is a deep image");
  }
  const int64_t width = int64_t{window.max.x} - window.min.x + 1;
  const int64_t height = int64_t{window.max.y} - window.min.y + 1;
  if (width < 1 || height < 1 || width > kMaxImageSide || height > kMaxImageSide) {
    return unsupported(name, "has " + std::to_string(width) + " x " + std::to_string(height) +
                                 " pixels, more than " + std::to_string(kMaxImageSide) + " a side");
  }
  const uint64_t pixel_bytes = 4 * static_cast<uint64_t>(channels->num_channels);
  const uint64_t needed = static_cast<uint64_t>(width * height) * pixel_bytes;
  const uint64_t most = std::max(kSmallImage, stream.bytes.size() * kMostRatio);
  if (static_cast<uint64_t>(chunks) * 8 > stream.bytes.size() || needed > most) {
    return damaged(name, "it is too short for " + std::to_string(width) + " x " +
                             std::to_string(height) + " pixels");
  }
  for (int i = 0; i < channels->num_channels; ++i) {
    if (channels->entries[i].x_sampling != 1 || channels->entries[i].y_sampling != 1) {
      return unsupported(name, "has channels of reduced size");
    }
  }
  return ImageSize{static_cast<uint32_t>(width), static_cast<uint32_t>(height)};
}

Result<ImageSize> check_header(std::span<const uint8_t> bytes, const std::string& name) {
  CoreStream stream{bytes};
  exr_context_initializer_t options = EXR_DEFAULT_CONTEXT_INITIALIZER;
  options.error_handler_fn = core_error;
  options.user_data = &stream;
  options.read_fn = core_read;
  options.size_fn = core_size;
  options.max_tile_width = options.max_tile_height = static_cast<int>(kMaxImageSide);
  exr_context_t context = nullptr;
  if (exr_start_read(&context, "memory", &options) != EXR_ERR_SUCCESS) {
    return damaged(name, stream.problem);
  }
  Result<ImageSize> size = check_first_part(context, stream, name);
  exr_finish(&context);
  return size;
}

// May throw.
ExrImage read_pixels(std::span<const uint8_t> bytes, ImageSize size) {
  ByteSource source(bytes);
  Imf::InputFile file(source, 0);
  const Imf::Header& header = file.header();
  ExrImage image;
  image.size = size;
  const size_t pixels = size_t{size.width} * size.height;
  for (auto it = header.channels().begin(); it != header.channels().end(); ++it) {
    const Imf::PixelType type = it.channel().type;
    ExrPlane& plane = image.planes.emplace_back();
    plane.name = it.name();
    plane.type = type == Imf::UINT   ? ExrType::uint32
                 : type == Imf::HALF ? ExrType::half
                                     : ExrType::float32;
    type == Imf::UINT ? plane.integers.resize(pixels) : plane.floats.resize(pixels);
  }
  const Imath::Box2i window = header.dataWindow();
  Imf::FrameBuffer frame;
  for (ExrPlane& plane : image.planes) {
    const bool whole = plane.type == ExrType::uint32;
    void* const values = whole ? static_cast<void*>(plane.integers.data()) : plane.floats.data();
    frame.insert(plane.name, Imf::Slice::Make(whole ? Imf::UINT : Imf::FLOAT, values, window));
  }
  file.setFrameBuffer(frame);
  file.readPixels(window.min.y, window.max.y);

  for (auto it = header.begin(); it != header.end(); ++it) {
    if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&it.attribute())) {
      image.attributes.texts.emplace_back(it.name(), text->value());
    }
  }
  if (Imf::hasWorldToCamera(header)) {
    image.attributes.world_to_camera = from_imath(Imf::worldToCamera(header));
  }
  if (Imf::hasWorldToNDC(header)) {
    image.attributes.world_to_ndc = from_imath(Imf::worldToNDC(header));
  }
  return image;
}

}  // namespace

Result<void> write_exr(const std::string& path, ImageSize size,
                       std::span<const ExrChannel> channels, const ExrAttributes& attributes) {
  if (size.width == 0 || size.height == 0 || channels.empty()) {
    return fail({ErrorKind::usage, path, "", "the image is empty", "give it a size and channels"});
  }
  try {
    ByteSink sink;
    {
      std::vector<std::vector<half>> halves;
      const Imf::FrameBuffer frame = make_frame(size, channels, halves);
      Imf::OutputFile file(sink, make_header(size, channels, attributes), 0);
      file.setFrameBuffer(frame);
      file.writePixels(static_cast<int>(size.height));
    }  // the file is complete when it is closed
    return write_file(path, sink.bytes());
  } catch (const std::bad_alloc&) {
    return fail(
        {ErrorKind::runtime, path, "", "there is no memory to encode it", "choose a smaller size"});
  } catch (const std::exception& error) {
    return fail({ErrorKind::output, path, "",
                 std::string("cannot be encoded as EXR: ") + error.what(), ""});
  }
}

const ExrPlane* ExrImage::find(std::string_view name) const {
  const auto it = std::find_if(planes.begin(), planes.end(),
                               [&](const ExrPlane& plane) { return plane.name == name; });
  return it == planes.end() ? nullptr : &*it;
}

bool is_exr(std::span<const uint8_t> bytes) {
  constexpr uint8_t kMagic[4] = {0x76, 0x2f, 0x31, 0x01};
  return bytes.size() >= 4 && std::equal(kMagic, kMagic + 4, bytes.begin());
}

Result<ExrImage> decode_exr(std::span<const uint8_t> bytes, const std::string& name) {
  if (!is_exr(bytes)) {
    return fail({ErrorKind::bad_input, name, "", "is no OpenEXR file", "give an .exr"});
  }
  SINEW_TRY(const ImageSize size, check_header(bytes, name));
  try {
    return read_pixels(bytes, size);
  } catch (const std::bad_alloc&) {
    return fail({ErrorKind::bad_input, name, "", "is too large for this machine's memory", ""});
  } catch (const std::exception& error) {
    return damaged(name, error.what());
  }
}

Result<ExrImage> read_exr(const std::string& path) {
  SINEW_TRY(const std::string file, read_file(path, kMostFileBytes));
  return decode_exr({reinterpret_cast<const uint8_t*>(file.data()), file.size()}, path);
}

}  // namespace sinew
