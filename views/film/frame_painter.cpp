#include "views/film/frame_painter.h"

#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/pictures/render.h"
#include "core/values/errors.h"

namespace keypose {
namespace {

/// Share of its light that the table keeps where the sky is hidden: it comes back from the figure.
constexpr double kBounce = 0.15;
/// A smaller share of the sky than this may be hidden without a shadow.
constexpr double kUnseen = 0.06;

Image8 Blended(const std::vector<Image8>& textures, const std::vector<double>& weights) {
  Image8 blended = textures[0];
  const auto size = std::ssize(blended.data);
  ParallelBlocks(size, 1 << 16, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      double sum = 0.5;
      for (std::size_t k = 0; k < textures.size(); ++k) sum += weights[k] * textures[k].data[i];
      blended.data[i] = static_cast<std::uint8_t>(std::clamp(sum, 0.0, 255.0));
    }
  });
  return blended;
}

bool SameSize(const std::vector<Image8>& textures) {
  return std::all_of(textures.begin(), textures.end(), [&](const Image8& texture) {
    return texture.width == textures[0].width && texture.height == textures[0].height &&
           texture.channels == textures[0].channels;
  });
}

/// Thresholds in (0, 1) that differ between neighbours, so that a slow gradient has no bands of
/// equal values. Source: Bayer, An optimum method for two-level rendition, 1973.
double BayerThreshold(int x, int y) {
  int rank = 0;
  for (int bit = 0; bit < 3; ++bit) {
    const int a = (x >> bit) & 1, b = (y >> bit) & 1;
    rank = 4 * rank + 2 * (a ^ b) + b;
  }
  return (rank + 0.5) / 64;
}

/// Alpha of black, for mixing stored values: the stored value is about the light's root of 2.2. The
/// curve is for the eye: an even sky alone makes a weak shadow that greys the whole table, up to
/// the borders of the picture.
double ShadowAlpha(double hidden) {
  const double seen = std::max(0.0, (hidden - kUnseen) / (1 - kUnseen));
  const double dark = seen * seen * (3 - 2 * seen);
  return 1 - std::pow(1 - (1 - kBounce) * dark, 1 / 2.2);
}

/// ShadowAlpha, linear between values that are computed once: 1e-6 off at most.
double FastShadowAlpha(double hidden) {
  constexpr int kSteps = 1024;
  static const std::array<double, kSteps + 2> table = [] {
    std::array<double, kSteps + 2> t;
    for (int i = 0; i <= kSteps; ++i) t[i] = ShadowAlpha(static_cast<double>(i) / kSteps);
    t[kSteps + 1] = t[kSteps];
    return t;
  }();
  const double at = std::clamp(hidden, 0.0, 1.0) * kSteps;
  const int i = static_cast<int>(at);
  return table[i] + (at - i) * (table[i + 1] - table[i]);
}

/// Puts a black layer of the given alpha behind a pixel.
void PutBehind(std::uint8_t* rgba, double alpha, double threshold) {
  if (rgba[3] == 0) {
    rgba[3] = static_cast<std::uint8_t>(std::min(255.0, 255 * alpha + threshold));
    return;
  }
  const double figure = rgba[3] / 255.0, sum = figure + (1 - figure) * alpha;
  for (int k = 0; k < 3; ++k)
    rgba[k] = static_cast<std::uint8_t>(std::lround(rgba[k] * figure / sum));
  rgba[3] = static_cast<std::uint8_t>(std::lround(255 * sum));
}

void AddShadow(Image8& picture, const View& view, const GroundShadow& shadow,
               const Ground& ground) {
  const Eigen::Matrix3d world_from_camera =
      view.camera_from_world.rotation.conjugate().toRotationMatrix();
  const Eigen::Vector3d eye = view.Center();
  const double height = (eye - ground.origin).dot(ground.up);
  ParallelFor(picture.height, [&](std::int64_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < picture.width; ++x) {
      std::uint8_t* pixel = picture.at(x, y);
      if (pixel[3] == 255) continue;
      const Eigen::Vector3d direction =
          world_from_camera * view.camera.Unproject({x + 0.5, y + 0.5});
      const double down = -direction.dot(ground.up);
      if (!(down * height > 0)) continue;  // above the horizon
      const double hidden = shadow.Hidden(eye + height / down * direction);
      if (hidden > 0) PutBehind(pixel, FastShadowAlpha(hidden), BayerThreshold(x, y));
    }
  });
}

}  // namespace

struct FramePainter::State {
  Mesh mesh;
  Image8 blended;
  RenderOptions look;
  RayScene rays;
  Ground ground;
  std::unique_ptr<GroundShadow> shadow;

  explicit State(const Mesh& frame) : mesh(frame), rays(frame.points, frame.faces) {}
};

FramePainter::FramePainter(const FilmScene& scene, int frame, const Ground* ground)
    : state_(std::make_unique<State>(scene.frames[frame])) {
  State& s = *state_;
  s.mesh.uvs = scene.frames[0].uvs;
  s.mesh.uv_faces = scene.frames[0].uv_faces;
  s.look.samples = 2;
  s.look.shading = scene.shading;
  const bool own = scene.texture_of_frame != nullptr;
  const bool textured = s.mesh.has_uvs() && (own || !scene.textures.empty());
  const bool blends = textured && !own && !scene.blend.empty() && SameSize(scene.textures);
  if (textured && own) s.blended = scene.texture_of_frame(frame);
  if (blends) s.blended = Blended(scene.textures, scene.blend[frame]);
  if (textured)
    s.look.texture = own || blends ? &s.blended : &scene.textures[0];
  else {
    s.look.plain = s.mesh.colors.rows() == 0;
    s.look.shading = 1;
  }
  if (!ground) return;
  s.ground = *ground;
  s.shadow = std::make_unique<GroundShadow>(s.rays, s.ground);
}

FramePainter::~FramePainter() = default;

Image8 FramePainter::Picture(const View& view) const {
  const State& s = *state_;
  Image8 picture = RenderCutout(s.mesh, s.rays, view, s.look);
  if (s.shadow) AddShadow(picture, view, *s.shadow, s.ground);
  return picture;
}

Image8 RenderPicture(const FilmScene& scene, int frame, const View& view, const Ground* ground) {
  return FramePainter(scene, frame, ground).Picture(view);
}

Image8 LaidOver(const Image8& picture, const Eigen::Matrix<std::uint8_t, 3, 1>& background) {
  if (picture.channels == 3) return picture;
  if (picture.channels != 4)
    throw InputError("film: a picture of the film has " + std::to_string(picture.channels) +
                     " channels; it must be RGB or RGBA");
  Image8 flat(picture.width, picture.height, 3);
  const std::size_t pixels = flat.data.size() / 3;
  for (std::size_t i = 0; i < pixels; ++i) {
    const std::uint8_t* from = picture.data.data() + 4 * i;
    for (int k = 0; k < 3; ++k) {
      const int mixed = from[k] * from[3] + background[k] * (255 - from[3]);
      flat.data[3 * i + k] = static_cast<std::uint8_t>((mixed + 127) / 255);
    }
  }
  return flat;
}

std::string EncodePng(const Image8& picture) {
  if (picture.empty() || (picture.channels != 3 && picture.channels != 4))
    throw InputError("film: a picture of the film is not RGB or RGBA with at least one pixel");
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(picture.width);
  header.height = static_cast<png_uint_32>(picture.height);
  header.format = picture.channels == 4 ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(header);
  std::string bytes(size, '\0');
  if (!png_image_write_to_memory(&header, bytes.data(), &size, 0, picture.data.data(), 0, nullptr))
    throw ToolError(std::string("film: libpng could not encode a picture: ") + header.message);
  bytes.resize(size);
  return bytes;
}

}  // namespace keypose
