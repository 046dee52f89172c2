#include "synth/photographs/damaged_photographs.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/pictures/image_turns.h"
#include "core/pictures/srgb.h"
#include "core/values/errors.h"
#include "core/values/exif_focal.h"
#include "core/values/image.h"
#include "synth/photographs/sensor.h"
#include "synth/worlds/hand.h"

namespace keypose::synth {
namespace {

namespace fs = std::filesystem;

const std::pair<const char*, DamageKind> kWords[] = {
    {"truncate", DamageKind::kTruncate}, {"empty", DamageKind::kEmpty},
    {"no-image", DamageKind::kNoImage},  {"blur", DamageKind::kBlur},
    {"dark", DamageKind::kDark},         {"drop", DamageKind::kDrop},
    {"rotate", DamageKind::kRotate},     {"upside-down", DamageKind::kUpsideDown},
    {"resize", DamageKind::kResize},     {"strip-exif", DamageKind::kStripExif},
    {"hand", DamageKind::kHand},         {"tool", DamageKind::kTool},
    {"thumb", DamageKind::kThumb}};

ExifToWrite ExifOf(const ImageInfo& info, int orientation) {
  ExifToWrite exif;
  exif.focal_mm = info.focal_mm.value_or(0);
  const double focal_px = FocalPx(info.width, info.height, info.focal_35mm.value_or(0),
                                  info.focal_mm.value_or(0), info.sensor_width_mm.value_or(0));
  exif.focal_35mm = Equivalent35mm(focal_px, info.width, info.height);
  exif.model = info.camera_model;
  exif.orientation = orientation;
  return exif;
}

// Blurs and darkens sRGB values: the damage need not be physically correct.
Image8 Blurred(const Image8& image, double sigma, double gain) {
  ImageF linear(image.width, image.height, 3);
  for (std::size_t i = 0; i < image.data.size(); ++i)
    linear.data[i] = static_cast<float>(gain * std::pow(image.data[i] / 255.0, 2.2));
  return Develop(std::move(linear), {sigma, 0, 1, 5});
}

/// @param name  of the file: decides where it reaches in
Image8 Covered(const Image8& image, DamageKind kind, const std::string& name) {
  ImageF linear(image.width, image.height, 3);
  for (std::size_t i = 0; i < image.data.size(); ++i)
    linear.data[i] = static_cast<float>(LinearFromSrgb(image.data[i] / 255.0));
  std::uint64_t seed = 0;
  for (const char c : name) seed = (seed * 31 + static_cast<unsigned char>(c)) % 1000003;
  Image8 nowhere(image.width, image.height, 1, 0);
  if (kind == DamageKind::kHand)
    HoldHand(linear, nowhere, seed);
  else if (kind == DamageKind::kTool)
    HoldTool(linear, nowhere, seed);
  else
    HoldThumb(linear, seed);
  return Develop(std::move(linear), {0, 0, 0, 5});
}

// Rotates by 90 degrees to the left; EXIF orientation 6 (rotate right to view) undoes this.
Image8 TurnedLeft(const Image8& image) {
  Image8 turned(image.height, image.width, image.channels);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      std::copy_n(image.at(x, y), image.channels, turned.at(y, image.width - 1 - x));
  return turned;
}

/// @return false: damage of pixels, which is not done here
bool SpoilFile(const fs::path& path, DamageKind kind) {
  switch (kind) {
    case DamageKind::kDrop:
      fs::remove(path);
      return true;
    case DamageKind::kEmpty:
      WriteFile(path, "");
      return true;
    case DamageKind::kNoImage:
      WriteFile(path, "This is not a photograph.\n");
      return true;
    case DamageKind::kTruncate: {
      const std::string bytes = ReadFile(path);
      WriteFile(path, std::string_view(bytes).substr(0, bytes.size() / 2));
      return true;
    }
    default:
      return false;
  }
}

void Spoil(const fs::path& path, DamageKind kind) {
  if (SpoilFile(path, kind)) return;
  const ImageInfo info = ReadImageInfo(path);
  const Image8 image = ReadImage(path, 3);
  const ExifToWrite upright = ExifOf(info, 1), turned = ExifOf(info, 6);
  constexpr int kQuality = 94;
  switch (kind) {
    case DamageKind::kBlur:
      WriteImage(path, Blurred(image, 6, 1), kQuality, &upright);
      return;
    case DamageKind::kDark:
      WriteImage(path, Blurred(image, 0, 0), kQuality, &upright);
      return;
    case DamageKind::kRotate:
      WriteImage(path, TurnedLeft(image), kQuality, &turned);
      return;
    case DamageKind::kUpsideDown:
      WriteImage(path, TurnedOver(image), kQuality, &upright);
      return;
    case DamageKind::kHand:
    case DamageKind::kTool:
    case DamageKind::kThumb:
      WriteImage(path, Covered(image, kind, path.filename().string()), kQuality, &upright);
      return;
    case DamageKind::kResize:
      WriteImage(path, Resized(image, image.width * 4 / 5, image.height * 4 / 5), kQuality,
                 &upright);
      return;
    default:
      WriteImage(path, image, kQuality);
      return;
  }
}

}  // namespace

DamageKind DamageKindNamed(const std::string& word) {
  std::string known;
  for (const auto& [name, kind] : kWords) {
    if (word == name) return kind;
    known += (known.empty() ? "" : ", ") + std::string(name);
  }
  throw UsageError("synth: there is no damage '" + word + "'; there are " + known);
}

void DamagePhotos(const fs::path& from, const fs::path& to, DamageKind kind,
                  const std::vector<std::string>& names) {
  std::error_code error;
  fs::create_directories(to, error);
  if (!error)
    fs::copy(from, to, fs::copy_options::recursive | fs::copy_options::overwrite_existing, error);
  if (error)
    throw DiskError("synth: cannot copy " + from.string() + " to " + to.string() + ": " +
                    error.message());
  std::vector<std::string> spoilt = names;
  if (spoilt.empty())
    for (const fs::directory_entry& entry : fs::directory_iterator(to))
      if (entry.is_regular_file()) spoilt.push_back(entry.path().filename().string());
  std::sort(spoilt.begin(), spoilt.end());
  for (const std::string& name : spoilt) {
    if (!fs::is_regular_file(to / name))
      throw InputError("synth: there is no photograph '" + name + "' in " + from.string());
    Spoil(to / name, kind);
  }
}

}  // namespace keypose::synth
