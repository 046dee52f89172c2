#include "core/render.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "core/errors.h"
#include "core/geometry.h"
#include "core/parallel.h"
#include "core/size_of.h"
#include "core/srgb.h"

namespace keypose {
namespace {

using Rgb8 = Eigen::Matrix<std::uint8_t, 3, 1>;
using Eigen::Vector2d;
using Eigen::Vector3d;

const std::array<double, 256>& LinearTable() {
  static const std::array<double, 256> table = [] {
    std::array<double, 256> t;
    for (int i = 0; i < 256; ++i) t[i] = LinearFromSrgb(i / 255.0);
    return t;
  }();
  return table;
}

Vector3d ToLinear(const std::uint8_t* rgb) {
  return {LinearTable()[rgb[0]], LinearTable()[rgb[1]], LinearTable()[rgb[2]]};
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
  PointsX3 vertex_normals;
  Eigen::Matrix3d world_from_camera;
  Vector3d eye;
  Vector3d key_lamp, fill_lamp;  ///< unit, in world

  Shader(const Mesh& m, const RayScene& s, const View& v, const RenderOptions& o)
      : mesh(m), scene(s), view(v), options(o) {
    if (o.smooth)
      vertex_normals =
          m.normals.rows() == m.points.rows() ? m.normals : VertexNormals(m.points, m.faces);
    world_from_camera = v.camera_from_world.rotation.conjugate().toRotationMatrix();
    eye = v.Center();
    key_lamp = world_from_camera * Vector3d(-0.45, -0.65, -0.75).normalized();
    fill_lamp = world_from_camera * Vector3d(0.75, 0.10, -0.60).normalized();
  }

  Vector3d Normal(const RayScene::Hit& hit, const Vector3d& direction) const {
    const auto f = mesh.faces.row(hit.face);
    const Vector3d a = mesh.points.row(f[0]), b = mesh.points.row(f[1]), c = mesh.points.row(f[2]);
    const Vector3d flat = (b - a).cross(c - a).normalized();
    Vector3d n = flat;
    if (options.smooth) {
      n = (1 - hit.u - hit.v) * vertex_normals.row(f[0]) + hit.u * vertex_normals.row(f[1]) +
          hit.v * vertex_normals.row(f[2]);
      n = n.squaredNorm() > 1e-12 ? n.normalized().eval() : flat;
    }
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

  /// Linear colour along the ray through a position in the image.
  /// @return  depth in the camera's frame; infinity where nothing is hit: `color` stays
  double Trace(const Vector2d& pixel, Vector3d& color) const {
    const Vector3d in_camera = view.camera.Unproject(pixel);
    const Vector3d direction = world_from_camera * in_camera;
    const RayScene::Hit hit = scene.Cast(eye, direction);
    if (hit.face < 0) return std::numeric_limits<double>::infinity();
    const Vector3d n = Normal(hit, direction);
    const double light =
        0.26 + 0.62 * std::max(0.0, n.dot(key_lamp)) + 0.24 * std::max(0.0, n.dot(fill_lamp));
    color = LinearColor(hit) * (1 - options.shading + options.shading * light);
    if (options.wireframe && EdgeDistancePixels(hit, hit.distance) < 0.6) color = 0.35 * color;
    return hit.distance;
  }
};

/// What some rays of one pixel hit.
struct PixelSample {
  Eigen::Vector3f color = Eigen::Vector3f::Zero();  ///< linear, mean over the rays that hit
  float near = std::numeric_limits<float>::infinity(), far = 0;  ///< depths; of no ray: near > far
  float covered = 0;                                             ///< share of the rays that hit
};

PixelSample SamplePixel(const Shader& shader, int x, int y, const std::vector<Vector2d>& offsets) {
  PixelSample pixel;
  Vector3d sum = Vector3d::Zero(), color;
  int hits = 0;
  for (const Vector2d& offset : offsets) {
    const double depth = shader.Trace(Vector2d(x, y) + offset, color);
    if (!std::isfinite(depth)) continue;
    sum += color;
    pixel.near = std::min(pixel.near, static_cast<float>(depth));
    pixel.far = std::max(pixel.far, static_cast<float>(depth));
    ++hits;
  }
  if (hits > 0) pixel.color = (sum / hits).cast<float>();
  pixel.covered = static_cast<float>(hits) / static_cast<float>(offsets.size());
  return pixel;
}

std::vector<Vector2d> GridOffsets(int n) {
  std::vector<Vector2d> offsets;
  for (int s = 0; s < n * n; ++s) offsets.emplace_back((s % n + 0.5) / n, (s / n + 0.5) / n);
  return offsets;
}

/// Points whose projections on both axes are evenly spaced, so that an upright or level edge has as
/// many steps of coverage as there are points. Source: Hammersley's point set in base 2.
std::vector<Vector2d> HammersleyOffsets(int bits) {
  std::vector<Vector2d> offsets;
  const int count = 1 << bits;
  for (int i = 0; i < count; ++i) {
    int reversed = 0;
    for (int bit = 0; bit < bits; ++bit) reversed |= ((i >> bit) & 1) << (bits - 1 - bit);
    offsets.emplace_back((i + 0.5) / count, (reversed + 0.5) / count);
  }
  return offsets;
}

/// The pixels of a box, sampled.
class SampledBox {
 public:
  SampledBox(const Shader& shader, const PixelBox& box, const std::vector<Vector2d>& offsets)
      : box_(box),
        width_(std::max(0, box.x1 - box.x0)),
        jump_(kJumpPixels / shader.view.camera.fx),
        pixels_(static_cast<std::size_t>(width_) * std::max(0, box.y1 - box.y0)) {
    ParallelFor(std::max(0, box.y1 - box.y0), [&](std::int64_t row) {
      const int y = box.y0 + static_cast<int>(row);
      for (int x = box.x0; x < box.x1; ++x)
        pixels_[Index(x, y)] = SamplePixel(shader, x, y, offsets);
    });
  }
  const PixelSample& At(int x, int y) const { return pixels_[Index(x, y)]; }

  /// Whether an outline, also of a part in front of another, crosses the pixel or its border.
  bool OnOutline(int x, int y) const {
    const PixelSample& here = At(x, y);
    return Between(here, here) || (x > box_.x0 && Between(here, At(x - 1, y))) ||
           (x + 1 < box_.x1 && Between(here, At(x + 1, y))) ||
           (y > box_.y0 && Between(here, At(x, y - 1))) ||
           (y + 1 < box_.y1 && Between(here, At(x, y + 1)));
  }

 private:
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

Rigid3 LookAt(const Vector3d& eye, const Vector3d& target, const Vector3d& up) {
  const Vector3d forward = target - eye;
  if (!(forward.norm() > 0))
    throw InputError(
        "render: the camera's position is the point that it should look at; move one of them");
  const Vector3d z = forward.normalized();
  Vector3d x = z.cross(up);
  if (x.norm() < 1e-9 * up.norm()) x = z.unitOrthogonal();
  x.normalize();
  Eigen::Matrix3d camera_from_world;
  camera_from_world << x.transpose(), z.cross(x).transpose(), z.transpose();
  Rigid3 result;
  result.rotation = Eigen::Quaterniond(camera_from_world).normalized();
  result.translation = -(result.rotation * eye);
  return result;
}

View FitView(const PointsX3& points, double azimuth_deg, double elevation_deg, int width,
             int height, const Vector3d& up, double fov_deg) {
  if (points.rows() == 0) throw InputError("render: nothing to look at: the mesh has no vertices");
  if (width < 1 || height < 1)
    throw InputError("render: a picture needs at least one pixel each way");
  const Vector3d z = up.normalized();
  // With z up, the front is -y. For another up axis, any fixed horizontal direction is used.
  Vector3d right = std::abs(z.x()) < 0.9 ? Vector3d::UnitX() : Vector3d::UnitY();
  right = (right - right.dot(z) * z).normalized();
  const Vector3d front = right.cross(z);
  const double a = azimuth_deg * M_PI / 180, e = elevation_deg * M_PI / 180;
  const Vector3d outward =
      std::cos(e) * (std::cos(a) * front + std::sin(a) * right) + std::sin(e) * z;
  const Vector3d center =
      0.5 * (points.colwise().minCoeff() + points.colwise().maxCoeff()).transpose();
  View view;
  view.camera.width = width;
  view.camera.height = height;
  view.camera.fx = view.camera.fy = 0.5 * height / std::tan(fov_deg * M_PI / 360);
  view.camera.cx = 0.5 * width;
  view.camera.cy = 0.5 * height;
  const Rigid3 turned = LookAt(center + outward, center, z);
  const Eigen::Matrix3d rotation = turned.rotation.toRotationMatrix();
  const double slope_x = 0.94 * 0.5 * width / view.camera.fx,
               slope_y = 0.94 * 0.5 * height / view.camera.fy;
  double distance = 0;
  for (int v = 0; v < points.rows(); ++v) {
    const Vector3d x = rotation * (points.row(v).transpose() - center);
    distance =
        std::max({distance, std::abs(x.x()) / slope_x - x.z(), std::abs(x.y()) / slope_y - x.z()});
  }
  if (!(distance > 0)) distance = 1;
  view.camera_from_world = LookAt(center + distance * outward, center, z);
  return view;
}

PixelBox ProjectedBounds(const PointsX3& points, const View& view) {
  const Camera& c = view.camera;
  const PixelBox all{0, 0, c.width, c.height};
  Vector2d low = Vector2d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  const Eigen::Matrix3d rotation = view.camera_from_world.rotation.toRotationMatrix();
  for (int v = 0; v < points.rows(); ++v) {
    const Vector3d x = rotation * points.row(v).transpose() + view.camera_from_world.translation;
    // The projection of a vertex beside or behind the camera does not bound its faces. Neither does
    // one with strong distortion far from the axis.
    if (x.z() <= 1e-3 * x.norm()) return all;
    const Vector2d p = c.Project(x);
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  // Distortion bends lines, so a face may reach a little beyond its corners.
  const double margin = 2 + (c.distorted() ? 0.02 * (high - low).norm() : 0);
  const auto clamp = [](double x, int most) {
    return static_cast<int>(std::clamp(x, 0.0, static_cast<double>(most)));
  };
  return {
      clamp(std::floor(low.x() - margin), c.width), clamp(std::floor(low.y() - margin), c.height),
      clamp(std::ceil(high.x() + margin), c.width), clamp(std::ceil(high.y() + margin), c.height)};
}

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
  const int n = std::max(1, options.samples);
  ParallelFor(c.height, [&](std::int64_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < c.width; ++x) {
      Vector3d sum = Vector3d::Zero();
      const bool inside = x >= box.x0 && x < box.x1 && y >= box.y0 && y < box.y1;
      for (int s = 0; inside && s < n * n; ++s) {
        Vector3d color = background;
        shader.Trace({x + (s % n + 0.5) / n, y + (s / n + 0.5) / n}, color);
        sum += color;
      }
      const Vector3d mean = inside ? (sum / (n * n)).eval() : background;
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
  const SampledBox sampled(shader, box, GridOffsets(samples));
  const auto many = HammersleyOffsets(kEdgeBits);
  Image8 image(view.camera.width, view.camera.height, 4);
  ParallelFor(std::max(0, box.y1 - box.y0), [&](std::int64_t row) {
    const int y = box.y0 + static_cast<int>(row);
    for (int x = box.x0; x < box.x1; ++x) {
      const PixelSample pixel =
          sampled.OnOutline(x, y) ? SamplePixel(shader, x, y, many) : sampled.At(x, y);
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
