#include "core/io/png_io.h"

#include <png.h>

#include <string>

#include "core/errors.h"
#include "core/io/files.h"

namespace keypose {

void WritePng(const std::filesystem::path& path, const Image8& image) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = image.channels == 1 ? PNG_FORMAT_GRAY : PNG_FORMAT_RGB;
  std::string bytes;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(header);
  bytes.resize(size);
  if (!png_image_write_to_memory(&header, bytes.data(), &size, 0, image.data.data(), 0, nullptr))
    throw DiskError("cannot write " + path.string() + ": " + header.message);
  bytes.resize(size);
  WriteFile(path, bytes);
}

}  // namespace keypose
