#include "core/pictures/render.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/pictures/scan_conversion.h"
#include "core/pictures/srgb.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose {
namespace {

using Rgb8 = Eigen::Matrix<std::uint8_t, 3, 1>;
using Eigen::Vector2d;
using Eigen::Vector3d;

Vector3d ToLinear(const std::uint8_t* rgb) {
  return {kLinearDouble[rgb[0]], kLinearDouble[rgb[1]], kLinearDouble[rgb[2]]};
}

/// Linear light of values between bytes, 16 steps each. Linear in between: 3e-8 off at most, and
/// far cheaper than the power that each ray would need three times.
Vector3d ToLinear(const Vector3d& srgb) {
  constexpr int kSteps = 16, kLast = 255 * kSteps;
  static const std::array<double, kLast + 2> table = [] {
    std::array<double, kLast + 2> t;
    for (int i = 0; i < SizeOf(t); ++i) t[i] = LinearFromSrgb(static_cast<double>(i) / kLast);
    return t;
  }();
  return srgb.unaryExpr([](double value) {
    const double at = (value > 0 ? std::min(value, 255.0) : 0) * kSteps;  // NaN gives 0
    const int i = static_cast<int>(at);
    return table[i] + (at - i) * (table[i + 1] - table[i]);
  });
}

/// The byte nearest to a linear value in sRGB.
std::uint8_t ToByte(double linear) {
  constexpr int kCells = 1024;
  // A byte begins half a step below itself. The cells say where to begin the search.
  static const auto begins = [] {
    std::array<double, 257> t;
    for (int i = 0; i < 256; ++i) t[i] = i == 0 ? 0 : LinearFromSrgb((i - 0.5) / 255);
    t[256] = std::numeric_limits<double>::infinity();
    return t;
  }();
  static const auto first = [] {
    std::array<std::uint8_t, kCells + 1> bytes;
    for (int c = 0; c <= kCells; ++c) {
      int byte = 0;
      while (begins[byte + 1] <= static_cast<double>(c) / kCells) ++byte;
      bytes[c] = static_cast<std::uint8_t>(byte);
    }
    return bytes;
  }();
  const double clamped = linear > 0 ? std::min(linear, 1.0) : 0;  // NaN gives 0
  int byte = first[static_cast<int>(clamped * kCells)];
  while (begins[byte + 1] <= clamped) ++byte;
  return static_cast<std::uint8_t>(byte);
}

/// Everything that rays need, computed once for each picture.
struct Shader {
  const Mesh& mesh;
  const RayScene& scene;
  const View& view;
  const RenderOptions& options;
  PointsX3 vertex_normals, face_normals;  ///< those of the faces are not of unit length
  Eigen::Matrix3d world_from_camera;
  Vector3d eye;
  Vector3d key_lamp, fill_lamp;  ///< unit, in world

  Shader(const Mesh& m, const RayScene& s, const View& v, const RenderOptions& o)
      : mesh(m), scene(s), view(v), options(o) {
    if (o.smooth)
      vertex_normals =
          m.normals.rows() == m.points.rows() ? m.normals : VertexNormals(m.points, m.faces);
    face_normals.resize(m.faces.rows(), 3);
    for (Eigen::Index f = 0; f < m.faces.rows(); ++f) {
      const Vector3d a = m.points.row(m.faces(f, 0)), b = m.points.row(m.faces(f, 1)),
                     c = m.points.row(m.faces(f, 2));
      face_normals.row(f) = (b - a).cross(c - a);
    }
    world_from_camera = v.camera_from_world.rotation.conjugate().toRotationMatrix();
    eye = v.Center();
    key_lamp = world_from_camera * Vector3d(-0.45, -0.65, -0.75).normalized();
    fill_lamp = world_from_camera * Vector3d(0.75, 0.10, -0.60).normalized();
  }

  Vector3d Normal(const RayScene::Hit& hit, const Vector3d& direction) const {
    const auto f = mesh.faces.row(hit.face);
    const Vector3d flat = face_normals.row(hit.face);
    Vector3d n = Vector3d::Zero();
    if (options.smooth)
      n = (1 - hit.u - hit.v) * vertex_normals.row(f[0]) + hit.u * vertex_normals.row(f[1]) +
          hit.v * vertex_normals.row(f[2]);
    n = (n.squaredNorm() > 1e-12 ? n : flat).normalized();
    // Both sides are lit, so that holes and inverted faces remain visible.
    return flat.dot(direction) > 0 ? (-n).eval() : n;
  }

  Vector3d LinearColor(const RayScene::Hit& hit) const {
    static const Vector3d kClay = ToLinear(Vector3d(188, 184, 178));
    if (options.plain) return kClay;
    const double w[3] = {1 - hit.u - hit.v, hit.u, hit.v};
    if (options.texture && mesh.has_uvs()) {
      Vector2d uv = Vector2d::Zero();
      for (int k = 0; k < 3; ++k) uv += w[k] * mesh.uvs.row(mesh.uv_faces(hit.face, k)).transpose();
      return ToLinear(SampleTexture(*options.texture, uv));
    }
    if (options.face_colors.rows() > 0) return ToLinear(options.face_colors.row(hit.face).data());
    const ColorsX3& colors = options.vertex_colors.rows() > 0 ? options.vertex_colors : mesh.colors;
    if (colors.rows() == 0) return kClay;
    Vector3d sum = Vector3d::Zero();
    for (int k = 0; k < 3; ++k)
      sum += w[k] * colors.row(mesh.faces(hit.face, k)).cast<double>().transpose();
    return ToLinear(sum);
  }

  double EdgeDistancePixels(const RayScene::Hit& hit, double depth) const {
    const auto f = mesh.faces.row(hit.face);
    const Vector3d p[3] = {mesh.points.row(f[0]), mesh.points.row(f[1]), mesh.points.row(f[2])};
    const double w[3] = {1 - hit.u - hit.v, hit.u, hit.v};
    const double twice_area = (p[1] - p[0]).cross(p[2] - p[0]).norm();
    double nearest = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k)
      nearest = std::min(
          nearest, w[k] * twice_area / std::max((p[(k + 1) % 3] - p[(k + 2) % 3]).norm(), 1e-300));
    return nearest * view.camera.fx / depth;
  }

  Vector3d Direction(const Vector2d& pixel) const {
    return world_from_camera * view.camera.Unproject(pixel);
  }

  /// What the ray through a position in the image hits; the distance is the depth in the camera's
  /// frame.
  RayScene::Hit Cast(const Vector2d& pixel) const { return scene.Cast(eye, Direction(pixel)); }

  /// Linear colour of what is hit at a position in the image.
  Vector3d Color(const RayScene::Hit& hit, const Vector2d& pixel) const {
    Vector3d color = LinearColor(hit);
    if (options.shading > 0) {
      const Vector3d n = Normal(hit, Direction(pixel));
      const double light =
          0.26 + 0.62 * std::max(0.0, n.dot(key_lamp)) + 0.24 * std::max(0.0, n.dot(fill_lamp));
      color *= 1 - options.shading + options.shading * light;
    }
    const bool on_wire = options.wireframe && EdgeDistancePixels(hit, hit.distance) < 0.6;
    return on_wire ? (0.35 * color).eval() : color;
  }
};

/// What the samples of pixels hit. By scan conversion where the camera allows it, else by rays.
class SampleHits {
 public:
  SampleHits(const Shader& shader, std::vector<Vector2d> pattern)
      : shader_(shader),
        pattern_(std::move(pattern)),
        scan_(ScanConversion::Of(shader.mesh.points, shader.mesh.faces, shader.view, pattern_)) {}

  int per_pixel() const { return SizeOf(pattern_); }
  /// Where in the image a sample lies.
  Vector2d Place(int x, int y, int s) const { return Vector2d(x, y) + pattern_[s]; }

  /// The hits of some rows of pixels.
  class Rows {
   public:
    /// @param places  see ScanConversion::Fill; of pixels that are not wanted, nothing may be asked
    Rows(const SampleHits& samples, const PixelBox& box, std::vector<int> places = {})
        : samples_(samples), box_(box), places_(std::move(places)) {
      if (samples.scan_) samples.scan_->Fill(box, places_, hits_);
    }
    RayScene::Hit At(int x, int y, int s) const {
      if (!samples_.scan_) return samples_.shader_.Cast(samples_.Place(x, y, s));
      const int pixel = (y - box_.y0) * (box_.x1 - box_.x0) + (x - box_.x0);
      const std::size_t place = places_.empty() ? pixel : places_[pixel];
      return hits_[place * samples_.per_pixel() + s];
    }

   private:
    const SampleHits& samples_;
    PixelBox box_;
    std::vector<int> places_;
    std::vector<RayScene::Hit> hits_;
  };

 private:
  const Shader& shader_;
  std::vector<Vector2d> pattern_;
  std::optional<ScanConversion> scan_;
};

std::vector<Vector2d> GridPattern(int n) {
  std::vector<Vector2d> pattern;
  for (int s = 0; s < n * n; ++s) pattern.emplace_back((s % n + 0.5) / n, (s / n + 0.5) / n);
  return pattern;
}

/// Points whose projections on both axes are evenly spaced, so that an upright or level edge has as
/// many steps of coverage as there are points. Source: Hammersley's point set in base 2.
std::vector<Vector2d> HammersleyPattern(int bits) {
  std::vector<Vector2d> pattern;
  const int count = 1 << bits;
  for (int i = 0; i < count; ++i) {
    int reversed = 0;
    for (int bit = 0; bit < bits; ++bit) reversed |= ((i >> bit) & 1) << (bits - 1 - bit);
    pattern.emplace_back((i + 0.5) / count, (reversed + 0.5) / count);
  }
  return pattern;
}

/// Calls `body` for all of the box, a few rows of pixels at a time, in parallel.
void ForRows(const PixelBox& box, const std::function<void(const PixelBox&)>& body) {
  constexpr int kRows = 8;
  const int blocks = std::max(0, box.y1 - box.y0 + kRows - 1) / kRows;
  ParallelFor(blocks, [&](std::int64_t block) {
    PixelBox part = box;
    part.y0 = box.y0 + kRows * static_cast<int>(block);
    part.y1 = std::min(box.y1, part.y0 + kRows);
    body(part);
  });
}

/// What the samples of one pixel hit.
struct PixelSample {
  Eigen::Vector3f color = Eigen::Vector3f::Zero();  ///< linear, mean over the samples that hit
  float near = std::numeric_limits<float>::infinity(), far = 0;  ///< depths; of none: near > far
  float covered = 0;                                             ///< share of the samples that hit
};

PixelSample SamplePixel(const Shader& shader, const SampleHits& samples,
                        const SampleHits::Rows& rows, int x, int y) {
  PixelSample pixel;
  Vector3d sum = Vector3d::Zero();
  int hits = 0;
  for (int s = 0; s < samples.per_pixel(); ++s) {
    const RayScene::Hit hit = rows.At(x, y, s);
    if (hit.face < 0) continue;
    sum += shader.Color(hit, samples.Place(x, y, s));
    pixel.near = std::min(pixel.near, static_cast<float>(hit.distance));
    pixel.far = std::max(pixel.far, static_cast<float>(hit.distance));
    ++hits;
  }
  if (hits > 0) pixel.color = (sum / hits).cast<float>();
  pixel.covered = static_cast<float>(hits) / static_cast<float>(samples.per_pixel());
  return pixel;
}

/// The pixels of a box, sampled.
class SampledBox {
 public:
  SampledBox(const Shader& shader, const PixelBox& box, int samples)
      : box_(box),
        width_(std::max(0, box.x1 - box.x0)),
        jump_(kJumpPixels / shader.view.camera.fx),
        pixels_(static_cast<std::size_t>(width_) * std::max(0, box.y1 - box.y0)) {
    const SampleHits hits(shader, GridPattern(samples));
    ForRows(box, [&](const PixelBox& part) {
      const SampleHits::Rows rows(hits, part);
      for (int y = part.y0; y < part.y1; ++y)
        for (int x = part.x0; x < part.x1; ++x)
          pixels_[Index(x, y)] = SamplePixel(shader, hits, rows, x, y);
    });
  }
  const PixelSample& At(int x, int y) const { return pixels_[Index(x, y)]; }

  /// The pixels that an outline crosses, or whose border it crosses, as places for
  /// ScanConversion::Fill.
  std::vector<int> Outline(const PixelBox& part) const {
    std::vector<int> places;
    int found = 0;
    for (int y = part.y0; y < part.y1; ++y)
      for (int x = part.x0; x < part.x1; ++x) places.push_back(OnOutline(x, y) ? found++ : -1);
    return places;
  }

 private:
  /// Also the outline of a part in front of another.
  bool OnOutline(int x, int y) const {
    const PixelSample& here = At(x, y);
    return Between(here, here) || (x > box_.x0 && Between(here, At(x - 1, y))) ||
           (x + 1 < box_.x1 && Between(here, At(x + 1, y))) ||
           (y > box_.y0 && Between(here, At(x, y - 1))) ||
           (y + 1 < box_.y1 && Between(here, At(x, y + 1)));
  }

  /// A smooth surface rarely changes its depth by more pixels than this from pixel to pixel.
  static constexpr double kJumpPixels = 8;

  std::size_t Index(int x, int y) const {
    return static_cast<std::size_t>(y - box_.y0) * width_ + (x - box_.x0);
  }
  bool Between(const PixelSample& a, const PixelSample& b) const {
    if (a.covered != b.covered || (a.covered > 0 && a.covered < 1)) return true;
    return a.covered > 0 && std::max(a.far, b.far) - std::min(a.near, b.near) > jump_ * a.near;
  }

  PixelBox box_;
  int width_;
  double jump_;  ///< relative to the depth
  std::vector<PixelSample> pixels_;
};

void CheckColors(const Mesh& mesh, const RenderOptions& options) {
  const auto check = [](Eigen::Index have, Eigen::Index want, const char* what) {
    if (have > 0 && have != want)
      throw InputError("render: " + std::to_string(have) + " colours for " + std::to_string(want) +
                       " " + what + "; give one each, or none");
  };
  check(options.vertex_colors.rows(), mesh.points.rows(), "vertices");
  check(options.face_colors.rows(), mesh.faces.rows(), "faces");
}

Rgb8 Between(const Vector3d* anchors, int count, double t) {
  if (!(t == t)) return {160, 160, 160};
  const double x = std::clamp(t, 0.0, 1.0) * (count - 1);
  const int i = std::min(static_cast<int>(x), count - 2);
  const Vector3d c = anchors[i] + (x - i) * (anchors[i + 1] - anchors[i]);
  return c.array().round().cast<std::uint8_t>().matrix();
}

}  // namespace

Raster Rasterize(const Mesh& mesh, const RayScene& scene, const View& view) {
  const Camera& c = view.camera;
  Raster raster{ImageT<int>(c.width, c.height, 1, -1),
                ImageF(c.width, c.height, 1, std::numeric_limits<float>::infinity())};
  const PixelBox box = ProjectedBounds(mesh.points, view);
  const Eigen::Matrix3d world_from_camera =
      view.camera_from_world.rotation.conjugate().toRotationMatrix();
  const Vector3d eye = view.Center();
  ParallelFor(std::max(0, box.y1 - box.y0), [&](std::int64_t row) {
    const int y = box.y0 + static_cast<int>(row);
    for (int x = box.x0; x < box.x1; ++x) {
      // z is 1 along the unprojected ray, so the hit's distance is the depth.
      const RayScene::Hit hit =
          scene.Cast(eye, world_from_camera * c.Unproject({x + 0.5, y + 0.5}));
      if (hit.face < 0) continue;
      *raster.face.at(x, y) = hit.face;
      *raster.depth.at(x, y) = static_cast<float>(hit.distance);
    }
  });
  return raster;
}

Rgb8 MapColor(double t, ColorMap map) {
  static const Vector3d kViridisAnchors[] = {
      {68, 1, 84}, {59, 82, 139}, {33, 145, 140}, {94, 201, 98}, {253, 231, 37}};
  static const Vector3d kHeatAnchors[] = {{44, 82, 150},  {66, 160, 190}, {150, 205, 140},
                                          {250, 220, 90}, {240, 130, 50}, {180, 25, 35}};
  static const Vector3d kDivergingAnchors[] = {
      {40, 80, 160}, {140, 175, 215}, {242, 242, 242}, {225, 150, 125}, {165, 30, 40}};
  switch (map) {
    case ColorMap::kHeat:
      return Between(kHeatAnchors, 6, t);
    case ColorMap::kDiverging:
      return Between(kDivergingAnchors, 5, t);
    case ColorMap::kViridis:
      break;
  }
  return Between(kViridisAnchors, 5, t);
}

ColorsX3 MapColors(const Eigen::VectorXd& values, double lowest, double highest, ColorMap map) {
  const double range = highest > lowest ? highest - lowest : 1;
  ColorsX3 colors(values.size(), 3);
  for (Eigen::Index i = 0; i < values.size(); ++i)
    colors.row(i) = MapColor((values[i] - lowest) / range, map).transpose();
  return colors;
}

Image8 Render(const Mesh& mesh, const RayScene& scene, const View& view,
              const RenderOptions& options) {
  CheckColors(mesh, options);
  const Shader shader(mesh, scene, view, options);
  const Camera& c = view.camera;
  Image8 image(c.width, c.height, 3);
  const PixelBox box = ProjectedBounds(mesh.points, view);
  const Vector3d background = ToLinear(options.background.data());
  for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = options.background[i % 3];
  const SampleHits samples(shader, GridPattern(std::max(1, options.samples)));
  ForRows(box, [&](const PixelBox& part) {
    const SampleHits::Rows rows(samples, part);
    for (int y = part.y0; y < part.y1; ++y)
      for (int x = part.x0; x < part.x1; ++x) {
        Vector3d sum = Vector3d::Zero();
        for (int s = 0; s < samples.per_pixel(); ++s) {
          const RayScene::Hit hit = rows.At(x, y, s);
          sum += hit.face < 0 ? background : shader.Color(hit, samples.Place(x, y, s));
        }
        const Vector3d mean = sum / samples.per_pixel();
        for (int k = 0; k < 3; ++k) image.at(x, y)[k] = ToByte(mean[k]);
      }
  });
  return image;
}

Image8 RenderCutout(const Mesh& mesh, const RayScene& scene, const View& view,
                    const RenderOptions& options) {
  constexpr int kEdgeBits = 5;
  CheckColors(mesh, options);
  const Shader shader(mesh, scene, view, options);
  const PixelBox box = ProjectedBounds(mesh.points, view);
  const int samples = std::max(1, options.samples);
  const SampledBox sampled(shader, box, samples);
  const SampleHits many(shader, HammersleyPattern(kEdgeBits));
  Image8 image(view.camera.width, view.camera.height, 4);
  ForRows(box, [&](const PixelBox& part) {
    const std::vector<int> outline = sampled.Outline(part);
    const SampleHits::Rows rows(many, part, outline);
    std::size_t at = 0;
    for (int y = part.y0; y < part.y1; ++y)
      for (int x = part.x0; x < part.x1; ++x, ++at) {
        const PixelSample pixel =
            outline[at] >= 0 ? SamplePixel(shader, many, rows, x, y) : sampled.At(x, y);
        std::uint8_t* out = image.at(x, y);
        for (int k = 0; k < 3 && pixel.covered > 0; ++k) out[k] = ToByte(pixel.color[k]);
        out[3] = static_cast<std::uint8_t>(std::lround(255 * pixel.covered));
      }
  });
  return image;
}

Image8 Render(const Mesh& mesh, const View& view, const RenderOptions& options) {
  return Render(mesh, RayScene(mesh.points, mesh.faces), view, options);
}

Vector3d SampleTexture(const Image8& texture, const Vector2d& uv) {
  const double x = std::clamp(uv.x() * texture.width - 0.5, 0.0, texture.width - 1.0);
  const double y = std::clamp((1 - uv.y()) * texture.height - 0.5, 0.0, texture.height - 1.0);
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const int x1 = std::min(x0 + 1, texture.width - 1), y1 = std::min(y0 + 1, texture.height - 1);
  const double fx = x - x0, fy = y - y0;
  Vector3d color;
  for (int k = 0; k < 3; ++k) {
    const int c = std::min(k, texture.channels - 1);
    color[k] = (1 - fy) * ((1 - fx) * texture.at(x0, y0)[c] + fx * texture.at(x1, y0)[c]) +
               fy * ((1 - fx) * texture.at(x0, y1)[c] + fx * texture.at(x1, y1)[c]);
  }
  return color;
}

Image8 TileImages(const std::vector<Image8>& images, int columns, int gap, Rgb8 background) {
  if (images.empty() || columns < 1)
    throw InputError("render: a contact sheet needs at least one image and one column");
  int cell_width = 0, cell_height = 0;
  for (const Image8& image : images) {
    cell_width = std::max(cell_width, image.width);
    cell_height = std::max(cell_height, image.height);
  }
  const int count = SizeOf(images), across = std::min(columns, count),
            rows = (count + across - 1) / across;
  Image8 sheet(across * cell_width + (across - 1) * gap, rows * cell_height + (rows - 1) * gap, 3);
  for (std::size_t i = 0; i < sheet.data.size(); ++i)
    sheet.data[i] = background[static_cast<int>(i % 3)];
  for (int i = 0; i < count; ++i) {
    const Image8& image = images[i];
    const int left = (i % across) * (cell_width + gap) + (cell_width - image.width) / 2;
    const int top = (i / across) * (cell_height + gap) + (cell_height - image.height) / 2;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        for (int k = 0; k < 3; ++k)
          sheet.at(left + x, top + y)[k] = image.at(x, y)[std::min(k, image.channels - 1)];
  }
  return sheet;
}

}  // namespace keypose
