#include "core/io/pictures/raw_io.h"

#include <OpenImageIO/imageio.h>

#include <memory>
#include <new>

#include "core/io/pictures/image_kind.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/memory.h"

namespace keypose {
namespace {

namespace fs = std::filesystem;
using OIIO::ImageInput;
using OIIO::ImageSpec;
using OIIO::TypeDesc;

[[noreturn]] void ThrowUnread(const fs::path& file, const std::string& reason) {
  throw InputError("the RAW file " + file.string() + " cannot be developed (" + reason +
                   "): copy it from the camera again; a camera newer than this machine's LibRaw "
                   "needs its files converted to DNG, or JPEG");
}

/// LibRaw opens much that is no RAW file. Each kind of these extensions begins with its own mark.
void RequireRawMark(const fs::path& file) {
  std::error_code missing;
  if (!fs::is_regular_file(file, missing))
    throw DiskError("the RAW file " + file.string() + " is not there");
  const std::string head = ReadFile(file).substr(0, 16);
  const auto starts = [&](std::string_view mark) { return head.starts_with(mark); };
  const bool tiff = starts(std::string_view("II*\0", 4)) || starts(std::string_view("MM\0*", 4));
  const bool olympus = starts("IIRO") || starts("IIRS") || starts("MMOR");
  const bool panasonic = starts(std::string_view("IIU\0", 4));
  const bool canon3 = head.size() >= 11 && head.substr(4, 7) == "ftypcrx";
  if (!tiff && !olympus && !panasonic && !canon3 && !starts("FUJIFILM"))
    ThrowUnread(file, "its first bytes are not those of a RAW file");
}

std::unique_ptr<ImageInput> OpenRaw(const fs::path& file) {
  RequireRawMark(file);
  ImageSpec wish, spec;
  wish.attribute("raw:ColorSpace", "sRGB");
  wish.attribute("raw:use_camera_wb", 1);
  wish.attribute("raw:auto_bright", 0);
  wish.attribute("raw:adjust_maximum_thr", 0.0f);  // else the white point depends on the picture
  auto input = ImageInput::create("raw");
  if (!input) throw ToolError("OpenImageIO was built without LibRaw; save JPEG in the camera");
  if (!input->open(file.string(), spec, wish)) ThrowUnread(file, input->geterror());
  const std::int64_t pixels = std::int64_t{input->spec().width} * input->spec().height;
  if (pixels < 1 || pixels > kMostPixels || input->spec().nchannels != 3)
    ThrowUnread(file, "it has " + std::to_string(input->spec().width) + " x " +
                          std::to_string(input->spec().height) + " pixels of " +
                          std::to_string(input->spec().nchannels) + " channels");
  return input;
}

std::optional<double> Positive(const ImageSpec& spec, const char* name) {
  const double value = spec.get_float_attribute(name, 0);
  return value > 0 && value < 1e6 ? std::optional<double>(value) : std::nullopt;
}

}  // namespace

Image8 ReadRaw(const fs::path& file) try {
  const auto input = OpenRaw(file);
  const ImageSpec spec = input->spec();
  constexpr std::int64_t kBytesAPixel = 20;  // LibRaw's mosaic and colours of 16 bits, and ours
  RequireMemory(kBytesAPixel * spec.width * spec.height, "RAW file " + file.string());
  Image8 image(spec.width, spec.height, 3);
  if (!input->read_image(0, 0, 0, 3, TypeDesc::UINT8, image.data.data()))
    ThrowUnread(file, input->geterror());
  return image;
} catch (const std::bad_alloc&) {
  throw DiskError("not enough memory to develop " + file.string() + "; close other programs");
}

ImageInfo ReadRawInfo(const fs::path& file) {
  const auto input = OpenRaw(file);
  const ImageSpec& spec = input->spec();
  ImageInfo info;
  info.width = spec.width;
  info.height = spec.height;
  info.channels = 3;
  info.focal_mm = Positive(spec, "Exif:FocalLength");
  info.focal_35mm = Positive(spec, "Exif:FocalLengthIn35mmFilm");
  const std::string make(spec.get_string_attribute("Make"));
  const std::string model(spec.get_string_attribute("Model"));
  info.camera_model =
      WithoutOddBytes(make.empty() || model.empty() ? make + model : make + " " + model);
  info.format = "raw";
  return info;
}

}  // namespace keypose
