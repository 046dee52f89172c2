#include "composite/scene/scene_plates.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/io/text/files.h"
#include "core/numbers/parallel.h"
#include "core/pictures/srgb.h"
#include "core/values/errors.h"

namespace keypose::composite {
namespace {

namespace fs = std::filesystem;

constexpr double kShare = 0.99, kMostLight = 0.92;  // of the pixels; that they may have
constexpr double kShoulder = 0.8;  // of white, from where on highlights are compressed

/// sRGB of 255 levels.
float ShownLevel(double light) {
  if (!(light > 0)) return 0;
  const double room = 1 - kShoulder;
  if (light > kShoulder) light = kShoulder + room * (1 - std::exp((kShoulder - light) / room));
  return static_cast<float>(255 * SrgbFromLinear(std::min(light, 1.0)));
}

/// What is infinite or no number would be all channels' after a matrix.
double Finite(float light) {
  return std::isnan(light) ? 0 : std::clamp(static_cast<double>(light), -1e6, 1e6);
}

std::string Words(const PictureWindow& w) {
  return fmt::format("{} x {} pixels at {}, {} of {} x {}", w.width, w.height, w.x - w.full_x,
                     w.y - w.full_y, w.full_width, w.full_height);
}

/// Calls put(x, y in the data window, x, y in the display window) where both are.
template <class Put>
void ForShared(const PictureWindow& window, const Put& put) {
  const int dx = window.x - window.full_x, dy = window.y - window.full_y;
  for (int y = std::max(0, -dy); y < std::min(window.height, window.full_height - dy); ++y)
    for (int x = std::max(0, -dx); x < std::min(window.width, window.full_width - dx); ++x)
      put(x, y, x + dx, y + dy);
}

}  // namespace

ScenePlates::ScenePlates(const StatedColors& stated, const fs::path& first)
    : first_(PrintableName(first.filename())),
      header_(ReadLightHeader(first)),
      colors_(stated, first, header_) {}

LightFile ScenePlates::RequireAlike(const fs::path& path) const {
  LightFile header = ReadLightHeader(path);
  if (!(header.window == header_.window))
    throw InputError(fmt::format(
        "{} has a window of {}, but {} of {}; all pictures of a shot must have one window: write "
        "them all with the same one",
        PrintableName(path), Words(header.window), first_, Words(header_.window)));
  if (header.exr != header_.exr || header.chromaticities != header_.chromaticities ||
      header.transfer != header_.transfer)
    throw InputError(fmt::format(
        "{} states other colours (chromaticities or transfer) than {}; all pictures of a shot must "
        "have one kind of colours: convert one of them",
        PrintableName(path), first_));
  return header;
}

ImageF ScenePlates::Light(const fs::path& path) const {
  ImageF light = ReadLightValues(path, RequireAlike(path), false);
  colors_.Decode(&light);
  if (exposure_ != 1)
    for (float& value : light.data) value *= exposure_;
  return light;
}

void ScenePlates::ExposeFor(const fs::path& path) {
  exposure_ = 1;
  std::vector<float> brightest;
  const ImageF light = Light(path);
  for (std::size_t i = 0; i + 2 < light.data.size(); i += 3)
    brightest.push_back(static_cast<float>(
        Finite(std::max({light.data[i], light.data[i + 1], light.data[i + 2]}))));
  const auto high =
      brightest.begin() + static_cast<std::ptrdiff_t>(kShare * (brightest.size() - 1));
  std::nth_element(brightest.begin(), high, brightest.end());
  if (!(*high > 0)) return;
  const double stops = std::floor(std::log2(kMostLight / *high));
  exposure_ = static_cast<float>(std::exp2(std::clamp(stops, -12.0, 12.0)));
}

ImageF ScenePlates::Alpha(const fs::path& path) const {
  const LightFile header = RequireAlike(path);
  if (!header.alpha) return {};
  const ImageF all = ReadLightValues(path, header, true);
  ImageF alpha(all.width, all.height, 1);
  for (std::size_t i = 0; i < alpha.data.size(); ++i) alpha.data[i] = all.data[4 * i + 3];
  return alpha;
}

ImageF ScenePlates::Shown(const ImageF& light) const {
  const Eigen::Matrix3d rec709 = colors_.light_from_rec709().inverse();
  ImageF levels(light.width, light.height, 3);
  ParallelFor(light.height, [&](std::int64_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < light.width; ++x) {
      const float* in = light.at(x, y);
      const Eigen::Vector3d shown =
          rec709 * Eigen::Vector3d(Finite(in[0]), Finite(in[1]), Finite(in[2]));
      for (int c = 0; c < 3; ++c) levels.at(x, y)[c] = ShownLevel(shown[c]);
    }
  });
  return levels;
}

Image8 ScenePlates::ShownWhole(const fs::path& path) const {
  const ImageF levels = Shown(Light(path));
  const PictureWindow& window = header_.window;
  Image8 whole(window.full_width, window.full_height, 3);
  ForShared(window, [&](int x, int y, int whole_x, int whole_y) {
    for (int c = 0; c < 3; ++c)
      whole.at(whole_x, whole_y)[c] = static_cast<std::uint8_t>(std::lround(levels.at(x, y)[c]));
  });
  return whole;
}

Camera ScenePlates::OfWindow(Camera camera) const {
  const PictureWindow& window = header_.window;
  if (camera.width != window.full_width || camera.height != window.full_height)
    throw InputError(fmt::format(
        "composite: {} has {} x {} pixels (its display window), but the shot was located in "
        "pictures of {} x {}; all pictures of a shot must have one size: scale or crop none of "
        "them",
        first_, window.full_width, window.full_height, camera.width, camera.height));
  camera.cx += window.full_x - window.x;
  camera.cy += window.full_y - window.y;
  camera.width = window.width;
  camera.height = window.height;
  return camera;
}

Image8 InWindow(const Image8& whole, const PictureWindow& window) {
  Image8 part(window.width, window.height, whole.channels);
  ForShared(window, [&](int x, int y, int whole_x, int whole_y) {
    std::copy_n(whole.at(whole_x, whole_y), whole.channels, part.at(x, y));
  });
  return part;
}

}  // namespace keypose::composite
