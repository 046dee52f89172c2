#include "core/io/pictures/raw_io.h"

#include <memory>
#include <new>

#include "core/io/pictures/image_kind.h"
#include "core/io/pictures/picture_codec.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/memory.h"

namespace keypose {
namespace {

namespace fs = std::filesystem;

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

std::unique_ptr<PictureReader> OpenRaw(const fs::path& file) {
  RequireRawMark(file);
  const PictureTags wishes{
      {"raw:ColorSpace", std::string("sRGB")},
      {"raw:use_camera_wb", 1},
      {"raw:auto_bright", 0},
      {"raw:adjust_maximum_thr", 0.0f}};  // else the white point depends on the picture
  OpenedPicture opened = Pictures().Open(file.string(), "raw", wishes);
  if (!opened.known)
    throw ToolError("OpenImageIO was built without LibRaw; save JPEG in the camera");
  if (!opened.reader) ThrowUnread(file, opened.reason);
  const PictureHeader header = opened.reader->header();
  const std::int64_t pixels = std::int64_t{header.width} * header.height;
  if (pixels < 1 || pixels > kMostPixels || header.channels != 3)
    ThrowUnread(file, "it has " + std::to_string(header.width) + " x " +
                          std::to_string(header.height) + " pixels of " +
                          std::to_string(header.channels) + " channels");
  return std::move(opened.reader);
}

std::optional<double> Positive(const PictureReader& input, const char* name) {
  const double value = input.Float(name, 0);
  return value > 0 && value < 1e6 ? std::optional<double>(value) : std::nullopt;
}

}  // namespace

Image8 ReadRaw(const fs::path& file) try {
  const auto input = OpenRaw(file);
  const PictureHeader header = input->header();
  constexpr std::int64_t kBytesAPixel = 20;  // LibRaw's mosaic and colours of 16 bits, and ours
  RequireMemory(kBytesAPixel * header.width * header.height, "RAW file " + file.string());
  Image8 image(header.width, header.height, 3);
  if (!input->Read(0, 3, PixelType::kByte, image.data.data())) ThrowUnread(file, input->Reason());
  return image;
} catch (const std::bad_alloc&) {
  throw DiskError("not enough memory to develop " + file.string() + "; close other programs");
}

ImageInfo ReadRawInfo(const fs::path& file) {
  const auto input = OpenRaw(file);
  const PictureHeader header = input->header();
  ImageInfo info;
  info.width = header.width;
  info.height = header.height;
  info.channels = 3;
  info.focal_mm = Positive(*input, "Exif:FocalLength");
  info.focal_35mm = Positive(*input, "Exif:FocalLengthIn35mmFilm");
  const std::string make = input->Text("Make"), model = input->Text("Model");
  info.camera_model =
      WithoutOddBytes(make.empty() || model.empty() ? make + model : make + " " + model);
  info.format = "raw";
  return info;
}

}  // namespace keypose
