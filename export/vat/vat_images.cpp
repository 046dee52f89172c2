#include "export/vat/vat_images.h"

#include "core/io/pictures/picture_codec.h"
#include "core/values/errors.h"

namespace keypose::exporting {
namespace {

template <class T>
std::string Encoded(const ImageT<T>& image, const std::string& extension,
                    const std::string& compression) {
  const PictureHeader header{image.width, image.height, image.channels, PixelTypeOf<T>()};
  const PictureTags tags{
      {"compression", compression},
      {"DateTime", std::string()}};  // else OpenImageIO writes the time of day into EXR files
  std::string file;
  const WrittenPicture written =
      Pictures().Encode("image." + extension, header, tags, image.data.data(), &file);
  if (!written.known) throw ToolError("export: OpenImageIO cannot write ." + extension + " files");
  if (!written.done)
    throw ToolError("export: OpenImageIO could not write a ." + extension +
                    " file: " + written.reason);
  return file;
}

}  // namespace

std::string PngOf8Bits(const Image8& image) { return Encoded(image, "png", ""); }

std::string PngOf16Bits(const ImageT<std::uint16_t>& image) { return Encoded(image, "png", ""); }

std::string ExrOfFloats(const ImageF& image) { return Encoded(image, "exr", "zip"); }

}  // namespace keypose::exporting
