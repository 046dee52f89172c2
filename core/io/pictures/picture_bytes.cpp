#include "core/io/pictures/picture_bytes.h"

#include <csetjmp>
#include <cstddef>
#include <cstdint>
#include <cstdio>

#include <fmt/format.h>
#include <jpeglib.h>
#include <png.h>
#include <webp/decode.h>

#include "core/io/pictures/image_kind.h"
#include "core/values/errors.h"

namespace keypose {
namespace {

[[noreturn]] void Refuse(const std::string& name, const std::string& why) {
  throw InputError(fmt::format(
      "the picture {} cannot be read: {}; save it anew as PNG or JPEG, and export the mesh again",
      name, why));
}

void RequireSize(const std::string& name, std::int64_t width, std::int64_t height) {
  if (width < 1 || height < 1) Refuse(name, "it has no pixels");
  if (width * height > kMostPixels)
    Refuse(name, fmt::format("it claims {} x {} pixels, and at most {} million are read", width,
                             height, kMostPixels / 1000000));
}

Image8 DecodePng(std::string_view bytes, const std::string& name) {
  if (!IsWholeImage(bytes, "png")) Refuse(name, "the PNG is truncated or damaged");
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  if (!png_image_begin_read_from_memory(&header, bytes.data(), bytes.size()))
    Refuse(name, header.message);
  const std::int64_t width = header.width, height = header.height;
  if (width < 1 || height < 1 || width * height > kMostPixels) {
    png_image_free(&header);
    RequireSize(name, width, height);
  }
  header.format = PNG_FORMAT_RGBA;  // as RGB, the library would lay it over a ground
  header.flags |= PNG_IMAGE_FLAG_16BIT_sRGB;
  Image8 stored(static_cast<int>(width), static_cast<int>(height), 4);
  if (!png_image_finish_read(&header, nullptr, stored.data.data(), 0, nullptr))
    Refuse(name, header.message);
  Image8 image(stored.width, stored.height, 3);
  const std::size_t pixels = image.data.size() / 3;
  for (std::size_t i = 0; i < pixels; ++i)
    for (std::size_t c = 0; c < 3; ++c) image.data[3 * i + c] = stored.data[4 * i + c];
  return image;
}

struct JpegFault {
  jpeg_error_mgr manager;  // first: the library knows only this
  std::jmp_buf back;
  char text[JMSG_LENGTH_MAX] = "";
};

void LeaveJpeg(j_common_ptr jpeg) {
  auto* fault = reinterpret_cast<JpegFault*>(jpeg->err);
  jpeg->err->format_message(jpeg, fault->text);
  std::longjmp(fault->back, 1);
}

void SayNothing(j_common_ptr, int) {}

/// libjpeg leaves a function that fails with a jump, which no object with a destructor may cross.
bool StartJpeg(jpeg_decompress_struct* jpeg, JpegFault* fault, std::string_view bytes) {
  if (setjmp(fault->back)) return false;
  jpeg_mem_src(jpeg, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  jpeg_read_header(jpeg, TRUE);
  jpeg->out_color_space = JCS_RGB;
  jpeg_calc_output_dimensions(jpeg);
  return true;
}

bool FinishJpeg(jpeg_decompress_struct* jpeg, JpegFault* fault, Image8* image) {
  if (setjmp(fault->back)) return false;
  jpeg_start_decompress(jpeg);
  while (jpeg->output_scanline < jpeg->output_height) {
    JSAMPROW row = image->at(0, static_cast<int>(jpeg->output_scanline));
    jpeg_read_scanlines(jpeg, &row, 1);
  }
  jpeg_finish_decompress(jpeg);
  return true;
}

Image8 DecodeJpeg(std::string_view bytes, const std::string& name) {
  if (!IsWholeImage(bytes, "jpeg")) Refuse(name, "the JPEG is truncated or damaged");
  jpeg_decompress_struct jpeg{};
  JpegFault fault{};
  jpeg.err = jpeg_std_error(&fault.manager);
  fault.manager.error_exit = LeaveJpeg;
  fault.manager.emit_message = SayNothing;
  jpeg_create_decompress(&jpeg);
  Image8 image;
  bool fine = StartJpeg(&jpeg, &fault, bytes);
  const std::int64_t width = jpeg.output_width, height = jpeg.output_height;
  if (fine && width > 0 && height > 0 && width * height <= kMostPixels) {
    image = Image8(static_cast<int>(width), static_cast<int>(height), 3);
    fine = FinishJpeg(&jpeg, &fault, &image);
  }
  jpeg_destroy_decompress(&jpeg);
  if (!fine) Refuse(name, fault.text);
  RequireSize(name, width, height);
  return image;
}

Image8 DecodeWebp(std::string_view bytes, const std::string& name) {
  const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
  WebPBitstreamFeatures features{};
  if (WebPGetFeatures(data, bytes.size(), &features) != VP8_STATUS_OK)
    Refuse(name, "the WebP is truncated or damaged");
  if (features.has_animation) Refuse(name, "it is an animated WebP");
  RequireSize(name, features.width, features.height);
  Image8 image(features.width, features.height, 3);
  if (!WebPDecodeRGBInto(data, bytes.size(), image.data.data(), image.data.size(), 3 * image.width))
    Refuse(name, "the WebP is truncated or damaged");
  return image;
}

}  // namespace

std::string PictureBytesKind(std::string_view bytes) {
  if (bytes.starts_with("\x89PNG")) return "png";
  if (bytes.starts_with("\xff\xd8\xff")) return "jpeg";
  if (bytes.starts_with("RIFF") && bytes.size() > 12 && bytes.substr(8, 4) == "WEBP") return "webp";
  return "";
}

Image8 DecodePicture(std::string_view bytes, const std::string& name) {
  const std::string kind = PictureBytesKind(bytes);
  if (kind == "png") return DecodePng(bytes, name);
  if (kind == "jpeg") return DecodeJpeg(bytes, name);
  if (kind == "webp") return DecodeWebp(bytes, name);
  const std::string other = OtherKindOf(bytes.substr(0, 4096));
  Refuse(name, other.empty() ? "it is no PNG, JPEG or WebP" : "it is " + other);
}

std::string PngBytes(const Image8& image) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = image.channels == 1 ? PNG_FORMAT_GRAY : PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(header);
  std::string bytes(size, '\0');
  if (!png_image_write_to_memory(&header, bytes.data(), &size, 0, image.data.data(), 0, nullptr))
    throw DiskError(fmt::format("cannot write a PNG: {}", header.message));
  bytes.resize(size);
  return bytes;
}

}  // namespace keypose
