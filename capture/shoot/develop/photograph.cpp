#include "capture/shoot/develop/photograph.h"

#include "core/io/pictures/photograph_files.h"
#include "core/io/pictures/picture_codec.h"
#include "core/io/pictures/raw_io.h"
#include "core/io/text/files.h"

namespace keypose::capture::shoot {

namespace fs = std::filesystem;

Image8 ReadPhotograph(const fs::path& file) {
  return IsRawName(file) ? ReadRaw(file) : ReadImage(file, 3);
}

ImageInfo ReadPhotographInfo(const fs::path& file) {
  return IsRawName(file) ? ReadRawInfo(file) : ReadImageInfo(file);
}

ExposureSettings ReadSettings(const fs::path& file) {
  const ImageInfo info = ReadPhotographInfo(file);  // also refuses what is no photograph
  ExposureSettings settings;
  settings.focal_mm = info.focal_mm.value_or(0);
  settings.focal_35mm = info.focal_35mm.value_or(0);
  if (info.format == "heif") return settings;
  const OpenedPicture opened = Pictures().Open(file.string(), info.format, {});
  if (!opened.reader) return settings;
  const auto positive = [&](const char* name) {
    const double value = opened.reader->Float(name, 0);
    return value > 0 && value < 1e7 ? value : 0.0;
  };
  settings.exposure_s = positive("ExposureTime");
  settings.aperture = positive("FNumber");
  settings.iso = positive("Exif:PhotographicSensitivity");
  if (settings.iso == 0) settings.iso = positive("Exif:ISOSpeedRatings");
  return settings;
}

}  // namespace keypose::capture::shoot
