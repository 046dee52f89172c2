#include "export/vat/vat_images.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include "core/values/errors.h"

namespace keypose::exporting {
namespace {

template <class T>
std::string Encoded(const ImageT<T>& image, const std::string& extension,
                    const std::string& compression) {
  const std::string name = "image." + extension;
  OIIO::ImageSpec spec(image.width, image.height, image.channels, OIIO::BaseTypeFromC<T>::value);
  spec.attribute("compression", compression);
  spec.attribute("DateTime", "");  // else OpenImageIO writes the time of day into EXR files
  OIIO::Filesystem::IOVecOutput file;
  const auto output = OIIO::ImageOutput::create(name, &file);
  if (!output) throw ToolError("export: OpenImageIO cannot write ." + extension + " files");
  if (!output->open(name, spec) || !output->write_image(spec.format, image.data.data()) ||
      !output->close())
    throw ToolError("export: OpenImageIO could not write a ." + extension +
                    " file: " + output->geterror());
  return std::string(file.buffer().begin(), file.buffer().end());
}

}  // namespace

std::string PngOf8Bits(const Image8& image) { return Encoded(image, "png", ""); }

std::string PngOf16Bits(const ImageT<std::uint16_t>& image) { return Encoded(image, "png", ""); }

std::string ExrOfFloats(const ImageF& image) { return Encoded(image, "exr", "zip"); }

}  // namespace keypose::exporting
