#include "register/landmark_picture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/errors.h"
#include "core/geometry.h"
#include "core/kd_tree.h"
#include "core/ray_scene.h"
#include "core/render.h"

namespace keypose::registration {

namespace {

using Color = Eigen::Matrix<std::uint8_t, 3, 1>;

constexpr double kVisibleWithin = 0.01;  // of the diagonal behind what the view sees at the landmark's pixel

/// Digits 0 to 9, three columns by five rows, a row an octal digit.
constexpr std::array<std::array<int, 5>, 10> kDigits = {{{7, 5, 5, 5, 7},
                                                         {2, 6, 2, 2, 7},
                                                         {7, 1, 7, 4, 7},
                                                         {7, 1, 7, 1, 7},
                                                         {5, 5, 7, 1, 1},
                                                         {7, 4, 7, 1, 7},
                                                         {7, 4, 7, 5, 7},
                                                         {7, 1, 1, 1, 1},
                                                         {7, 5, 7, 5, 7},
                                                         {7, 5, 7, 1, 7}}};

void Set(Image8& image, int x, int y, const Color& color) {
  if (x < 0 || y < 0 || x >= image.width || y >= image.height) return;
  std::copy(color.data(), color.data() + 3, image.at(x, y));
}

void Fill(Image8& image, int x0, int y0, int width, int height, const Color& color) {
  for (int y = y0; y < y0 + height; ++y)
    for (int x = x0; x < x0 + width; ++x) Set(image, x, y, color);
}

void DrawNumber(Image8& image, int x, int y, int number, int size, const Color& color) {
  for (const char c : std::to_string(number)) {
    const auto& rows = kDigits[static_cast<std::size_t>(c - '0')];
    for (int r = 0; r < 5; ++r)
      for (int k = 0; k < 3; ++k)
        if (rows[static_cast<std::size_t>(r)] & (4 >> k)) Fill(image, x + k * size, y + r * size, size, size, color);
    x += 4 * size;
  }
}

void DrawMark(Image8& image, const Eigen::Vector2d& at, int number, bool square, const Color& color) {
  const int radius = std::max(3, image.width / 70), size = std::max(1, image.width / 180);
  const auto cx = static_cast<int>(at.x()), cy = static_cast<int>(at.y());
  for (int y = -radius - 1; y <= radius + 1; ++y)
    for (int x = -radius - 1; x <= radius + 1; ++x) {
      const double r = square ? std::max(std::abs(x), std::abs(y)) : std::hypot(x, y);
      if (r <= radius)
        Set(image, cx + x, cy + y, color);
      else if (r <= radius + 1.5)
        Set(image, cx + x, cy + y, {255, 255, 255});
    }
  const int width = 4 * size * static_cast<int>(std::to_string(number).size()) + size;
  const int x = std::min(cx + radius + 2, image.width - width), y = std::max(0, cy - radius - 3 * size);
  Fill(image, x, y, width, 7 * size, {255, 255, 255});
  DrawNumber(image, x + size, y + size, number, size, {20, 20, 20});
}

/// Colours far apart for neighbouring numbers.
Color MarkColor(std::size_t index) {
  const double hue = std::fmod(0.61803398875 * static_cast<double>(index), 1.0) * 6;
  const auto channel = [&](double shift) {
    const double k = std::fmod(shift + hue, 6.0);
    return static_cast<std::uint8_t>(230 - 200 * std::clamp(std::min(k, 4 - k), 0.0, 1.0));
  };
  return {channel(5), channel(3), channel(1)};
}

/// Pale colours by place in the bounding box.
ColorsX3 Tints(const PointsX3& points) {
  const Eigen::RowVector3d low = points.colwise().minCoeff(), extent = (points.colwise().maxCoeff() - low).cwiseMax(1e-12);
  ColorsX3 tints(points.rows(), 3);
  for (Eigen::Index v = 0; v < points.rows(); ++v)
    tints.row(v) = (100 + 150 * (points.row(v) - low).cwiseQuotient(extent).array()).cast<std::uint8_t>().matrix();
  return tints;
}

ColorsX3 CarriedTints(const ColorsX3& tints, const PointsX3& target, const std::vector<int>& dense) {
  std::vector<int> mapped;
  for (std::size_t v = 0; v < dense.size(); ++v)
    if (dense[v] >= 0) mapped.push_back(static_cast<int>(v));
  ColorsX3 carried = ColorsX3::Constant(target.rows(), 3, 190);
  if (mapped.empty()) return carried;
  PointsX3 images(static_cast<Eigen::Index>(mapped.size()), 3);
  for (std::size_t i = 0; i < mapped.size(); ++i)
    images.row(static_cast<Eigen::Index>(i)) = target.row(dense[static_cast<std::size_t>(mapped[i])]);
  const KdTree tree(images);
  for (Eigen::Index v = 0; v < target.rows(); ++v)
    carried.row(v) = tints.row(mapped[static_cast<std::size_t>(tree.Nearest(target.row(v).transpose()).index)]);
  return carried;
}

std::vector<Image8> DrawRow(const Mesh& mesh, const std::vector<Eigen::Vector3d>& marks, const std::vector<DrawnPair>& pairs,
                            const ColorsX3& tints, const LandmarkPictureOptions& options) {
  const RayScene scene(mesh.points, mesh.faces);
  const double tolerance = kVisibleWithin * BoundingDiagonal(mesh.points);
  std::vector<Image8> views;
  for (const double azimuth : options.azimuths_deg) {
    const View view = FitView(mesh.points, azimuth, 10, options.panel, options.panel, options.up);
    RenderOptions render;
    render.vertex_colors = tints;
    render.plain = tints.rows() == 0;
    Image8 image = Render(mesh, scene, view, render);
    const Raster raster = Rasterize(mesh, scene, view);
    for (std::size_t k = 0; k < marks.size(); ++k) {
      const double depth = (view.camera_from_world * marks[k]).z();
      const Eigen::Vector2d pixel = view.Project(marks[k]);
      const int x = std::clamp(static_cast<int>(pixel.x()), 0, image.width - 1),
                y = std::clamp(static_cast<int>(pixel.y()), 0, image.height - 1);
      const float seen = *raster.depth.at(x, y);  // infinite beside the outline, where the ends of limbs fall
      if (std::isfinite(seen) && depth > seen + tolerance) continue;
      DrawMark(image, pixel, static_cast<int>(k) + 1, pairs[k].confirmed, MarkColor(k));
    }
    views.push_back(std::move(image));
  }
  return views;
}

}  // namespace

Image8 DrawLandmarks(const Mesh& source, const Mesh& target, const std::vector<DrawnPair>& pairs, const std::vector<int>& dense,
                     const LandmarkPictureOptions& options) {
  RequireUsable(source, "landmark picture: source");
  RequireUsable(target, "landmark picture: target");
  if (options.panel < 64 || options.azimuths_deg.empty()) throw InputError("landmark picture: needs views of 64 pixels or more");
  if (!dense.empty() && dense.size() != static_cast<std::size_t>(source.vertex_count()))
    throw InputError("landmark picture: the dense map must have one entry for each source vertex");
  const ColorsX3 tints = dense.empty() ? ColorsX3() : Tints(source.points);
  std::vector<Eigen::Vector3d> on_source, on_target;
  for (const DrawnPair& pair : pairs) on_source.push_back(pair.source), on_target.push_back(pair.target);
  std::vector<Image8> panels = DrawRow(source, on_source, pairs, tints, options);
  for (Image8& panel : DrawRow(target, on_target, pairs, dense.empty() ? ColorsX3() : CarriedTints(tints, target.points, dense), options))
    panels.push_back(std::move(panel));
  return TileImages(panels, static_cast<int>(options.azimuths_deg.size()));
}

}  // namespace keypose::registration
