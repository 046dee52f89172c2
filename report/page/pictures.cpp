#include "report/page/pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/pictures/cloud_picture.h"
#include "core/pictures/render.h"
#include "core/surfaces/geometry.h"
#include "report/html/html.h"

namespace keypose::report {
namespace {

std::vector<Picture> Sides(const Mesh& mesh, const RenderOptions& look,
                           const SidesOptions& options) {
  const RayScene scene(mesh.points, mesh.faces);
  std::vector<Picture> pictures;
  for (const double azimuth : options.azimuths_deg) {
    const View view = FitView(mesh.points, azimuth, options.elevation_deg, options.width,
                              options.height, options.up);
    pictures.push_back(
        {fmt::format("seen from {:.0f}\u00b0", azimuth), Render(mesh, scene, view, look)});
  }
  return pictures;
}

/// A red ring with a white rim, and a dot in its middle.
void DrawRing(Image8& image, const Eigen::Vector2d& center, double radius) {
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const double r = (Eigen::Vector2d(x + 0.5, y + 0.5) - center).norm(),
                   off = std::abs(r - radius);
      if (off < 2.0 || r < 2.5) {
        image.at(x, y)[0] = 214;
        image.at(x, y)[1] = 30;
        image.at(x, y)[2] = 30;
      } else if (off < 3.5)
        std::fill_n(image.at(x, y), 3, std::uint8_t{255});
    }
}

/// The view from all round that sees the vertex and faces it most directly.
View FacingView(const Mesh& mesh, const RayScene& scene, int vertex, const SidesOptions& size) {
  const Eigen::Vector3d place = mesh.points.row(vertex),
                        normal = VertexNormals(mesh.points, mesh.faces).row(vertex);
  const double diagonal = BoundingDiagonal(mesh.points);
  View best = FitView(mesh.points, 20, 14, size.width, size.height, size.up);
  double best_score = -2;
  for (const double elevation : {10.0, -25.0, 45.0, 75.0})
    for (int k = 0; k < 16; ++k) {
      const View view = FitView(mesh.points, 22.5 * k, elevation, size.width, size.height, size.up);
      const Eigen::Vector3d to_eye = view.Center() - place;
      const bool hidden = scene.Occluded(place + 1e-3 * diagonal * normal, to_eye, 0, 1);
      // An unusual camera height is harder to read than an oblique view.
      const double score =
          normal.dot(to_eye.normalized()) - (hidden ? 1 : 0) - 0.002 * std::abs(elevation - 10);
      if (score > best_score) {
        best_score = score;
        best = view;
      }
    }
  return best;
}

}  // namespace

Image8 MarkedVertex(const Mesh& mesh, int vertex, const SidesOptions& size) {
  const RayScene scene(mesh.points, mesh.faces);
  const View view = FacingView(mesh, scene, vertex, size);
  RenderOptions look;
  look.plain = true;
  Image8 image = Render(mesh, scene, view, look);
  DrawRing(image, view.Project(mesh.points.row(vertex)), size.width / 22.0);
  return image;
}

std::vector<Picture> TexturedSides(const Mesh& mesh, const Image8* texture,
                                   const SidesOptions& options) {
  RenderOptions look;
  look.texture = mesh.has_uvs() ? texture : nullptr;
  // The colours already contain the lamps' light; a little shading shows the shape.
  if (look.texture || mesh.colors.rows() > 0) look.shading = 0.35;
  return Sides(mesh, look, options);
}

std::vector<Picture> ShapeSides(const Mesh& mesh, const SidesOptions& options) {
  RenderOptions look;
  look.plain = true;
  look.smooth = false;
  look.wireframe = mesh.face_count() <= 6000;
  return Sides(mesh, look, options);
}

std::vector<Picture> HeatSides(const Mesh& mesh, const Eigen::VectorXd& values, double highest,
                               const SidesOptions& options) {
  RenderOptions look;
  look.vertex_colors = MapColors(values, 0, highest, ColorMap::kHeat);
  look.shading = 0.6;
  return Sides(mesh, look, options);
}

std::vector<std::string> HeatStops() {
  std::vector<std::string> stops;
  for (int i = 0; i <= 10; ++i) {
    const auto c = MapColor(i / 10.0, ColorMap::kHeat);
    stops.push_back(fmt::format("rgb({},{},{})", c[0], c[1], c[2]));
  }
  return stops;
}

std::vector<Picture> Film(const Mesh& mesh, const std::vector<PointsX3>& frames,
                          const std::vector<std::string>& captions, const Image8* texture,
                          const SidesOptions& options) {
  PointsX3 all(std::ssize(frames) * mesh.points.rows(), 3);
  for (std::size_t i = 0; i < frames.size(); ++i)
    all.middleRows(static_cast<Eigen::Index>(i) * mesh.points.rows(), mesh.points.rows()) =
        frames[i];
  const View view = FitView(all, options.azimuths_deg.front(), options.elevation_deg, options.width,
                            options.height, options.up);
  RenderOptions look;
  look.texture = mesh.has_uvs() ? texture : nullptr;
  if (look.texture) look.shading = 0.35;
  std::vector<Picture> film;
  Mesh posed = mesh;
  posed.normals.resize(0, 3);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    posed.points = frames[i];
    film.push_back({captions[i], Render(posed, view, look)});
  }
  return film;
}

Picture CloudPicture(const PointCloud& cloud, const SidesOptions& options) {
  const View view = FitView(cloud.points, options.azimuths_deg.front(), options.elevation_deg,
                            options.width, options.height, options.up);
  return {Pretty(static_cast<double>(cloud.points.rows())) + " points", RenderCloud(cloud, view)};
}

Image8 MaskTile(const Image8& photograph, const Image8& mask) {
  Image8 tile = photograph;
  const auto object = [&](int x, int y) {
    x = std::clamp(x, 0, mask.width - 1);
    y = std::clamp(y, 0, mask.height - 1);
    return *mask.at(x, y) > 127;
  };
  for (int y = 0; y < tile.height; ++y)
    for (int x = 0; x < tile.width; ++x) {
      const bool inside = object(x, y);
      const bool rim =
          inside && !(object(x - 1, y) && object(x + 1, y) && object(x, y - 1) && object(x, y + 1));
      const std::uint8_t outline[3] = {255, 140, 0};
      for (int c = 0; c < 3; ++c) {
        std::uint8_t& value = tile.at(x, y)[c];
        if (!inside) value = static_cast<std::uint8_t>(value * 2 / 5);
        if (rim) value = outline[c];
      }
    }
  return tile;
}

}  // namespace keypose::report
