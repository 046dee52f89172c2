#include "core/io/pictures/png_io.h"

#include <png.h>
#include <zlib.h>

#include <cstdint>
#include <string>
#include <vector>

#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose {
namespace {

/// Eight pixels to a byte, the first in the highest bit; rows begin with whole bytes.
std::vector<std::uint8_t> Packed(const Image8& mask) {
  const std::size_t stride = (static_cast<std::size_t>(mask.width) + 7) / 8;
  std::vector<std::uint8_t> bits(stride * mask.height, 0);
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      if (*mask.at(x, y) > 127) bits[stride * y + x / 8] |= 0x80 >> x % 8;
  return bits;
}

void Append(png_structp png, png_bytep data, png_size_t size) {
  static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<char*>(data), size);
}

/// Rows of a grey picture.
struct GreyRows {
  int width = 0, height = 0, bits = 8;
  const std::uint8_t* data = nullptr;
  std::size_t stride = 0;  // bytes
};

/// libpng leaves a function that fails with a jump, which no object with a destructor may cross:
/// all of them belong to the caller.
bool WriteRows(png_structp png, png_infop info, const GreyRows& rows, std::string* bytes) {
  if (setjmp(png_jmpbuf(png))) return false;
  png_set_write_fn(png, bytes, Append, nullptr);
  png_set_IHDR(png, info, static_cast<png_uint_32>(rows.width),
               static_cast<png_uint_32>(rows.height), rows.bits, PNG_COLOR_TYPE_GRAY,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  if (rows.bits == 8) {  // runs of one value
    png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_NONE);
    png_set_compression_strategy(png, Z_RLE);
    png_set_compression_level(png, 1);
  }
  png_write_info(png, info);
  for (int y = 0; y < rows.height; ++y) png_write_row(png, rows.data + rows.stride * y);
  png_write_end(png, info);
  return true;
}

void WriteGrey(const std::filesystem::path& path, const GreyRows& rows) {
  std::string bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  const bool written = info && WriteRows(png, info, rows, &bytes);
  png_destroy_write_struct(&png, &info);
  if (!written) throw DiskError("cannot write " + path.string() + ": not enough memory");
  WriteFile(path, bytes);
}

}  // namespace

void WritePng(const std::filesystem::path& path, const Image8& image) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  constexpr png_uint_32 kFormats[] = {0, PNG_FORMAT_GRAY, PNG_FORMAT_GA, PNG_FORMAT_RGB,
                                      PNG_FORMAT_RGBA};
  header.format = kFormats[image.channels];
  std::string bytes;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(header);
  bytes.resize(size);
  if (!png_image_write_to_memory(&header, bytes.data(), &size, 0, image.data.data(), 0, nullptr))
    throw DiskError("cannot write " + path.string() + ": " + header.message);
  bytes.resize(size);
  WriteFile(path, bytes);
}

void WriteMaskPng(const std::filesystem::path& path, const Image8& mask) {
  const std::vector<std::uint8_t> bits = Packed(mask);
  WriteGrey(path, {mask.width, mask.height, 1, bits.data(),
                   (static_cast<std::size_t>(mask.width) + 7) / 8});
}

void WriteGreyMaskPng(const std::filesystem::path& path, const Image8& mask) {
  WriteGrey(path,
            {mask.width, mask.height, 8, mask.data.data(), static_cast<std::size_t>(mask.width)});
}

}  // namespace keypose
