#include "export/glb_textures.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/values/size_of.h"

namespace keypose::exporting {
namespace {

namespace fs = std::filesystem;

constexpr int kFullQuality = 92, kLightQuality = 85;

EncodedImage JpegOf(const Image8& pixels, const std::string& name, int quality,
                    const fs::path& scratch) {
  const fs::path file = scratch / "texture.jpg";
  WriteImage(file, pixels, quality);
  return {ReadFile(file), "image/jpeg", name};
}

/// Smaller, with the same shape, where it is larger than `largest`.
Image8 Within(const Image8& pixels, int largest) {
  const double scale = static_cast<double>(largest) / std::max(pixels.width, pixels.height);
  if (scale >= 1) return pixels;
  const auto scaled = [&](int side) {
    return std::max(1, static_cast<int>(std::lround(scale * side)));
  };
  return Resized(pixels, scaled(pixels.width), scaled(pixels.height));
}

/// Of a picture that was encoded, against the one it was made from.
double PsnrDb(const EncodedImage& encoded, const Image8& original, const fs::path& scratch) {
  const fs::path file = scratch / "texture.jpg";
  WriteFile(file, encoded.bytes);
  const Image8 shown = Resized(ReadImage(file, 3), original.width, original.height);
  double squares = 0;
  for (std::size_t i = 0; i < original.data.size(); ++i) {
    const double difference = static_cast<double>(shown.data[i]) - original.data[i];
    squares += difference * difference;
  }
  const double mean = squares / static_cast<double>(original.data.size());
  return mean > 0 ? 10 * std::log10(255 * 255 / mean) : std::numeric_limits<double>::infinity();
}

/// The textures that the GLB has, each as `encode` (of its number) gives it.
template <class Encode>
GlbTextures TexturesOf(const Scene& scene, bool of_poses, const Encode& encode) {
  const bool blends = !scene.texture_moments.empty() && of_poses;
  GlbTextures glb;
  for (int i = 0; i < SizeOf(scene.textures) && (i == 0 || blends); ++i) {
    glb.images.push_back(encode(i));
    glb.poses.push_back(scene.poses[i]);
  }
  if (blends) glb.moments = scene.texture_moments;
  return glb;
}

}  // namespace

GlbTextures FullTextures(const Scene& scene, const std::string& of_poses, const fs::path& scratch) {
  return TexturesOf(scene, of_poses != "none", [&](int i) {
    const EncodedImage& given = scene.textures[i];
    const bool as_it_is = i == 0 || of_poses != "jpeg" || given.mime_type == "image/jpeg";
    return as_it_is ? given : JpegOf(scene.texture_pixels[i], given.name, kFullQuality, scratch);
  });
}

LightTextures MakeLightTextures(const Scene& scene, const std::string& of_poses, int largest,
                                const fs::path& scratch) {
  LightTextures light;
  light.textures = TexturesOf(scene, of_poses != "none", [&](int i) {
    const EncodedImage& given = scene.textures[i];
    if (i > 0 && of_poses == "png") return given;
    const Image8 within = Within(scene.texture_pixels[i], largest);
    EncodedImage made = JpegOf(within, given.name, kLightQuality, scratch);
    const bool fits = within.width == scene.texture_pixels[i].width;
    if (fits && given.bytes.size() <= made.bytes.size()) made = given;
    if (i > 0) return made;
    light.width = within.width, light.height = within.height;
    light.psnr_db = PsnrDb(made, scene.texture_pixels[0], scratch);
    return made;
  });
  return light;
}

}  // namespace keypose::exporting
