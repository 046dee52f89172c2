#include "register/landmarks/landmark_picture.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <opencv2/imgproc.hpp>

#include "core/numbers/kd_tree.h"
#include "core/pictures/render.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/errors.h"

namespace keypose::registration {

namespace {

using Color = Eigen::Matrix<std::uint8_t, 3, 1>;

// A landmark is visible when it is at most this far behind the visible surface, over the diagonal.
constexpr double kVisibleWithin = 0.01;

void Set(Image8& image, int x, int y, const Color& color) {
  if (x < 0 || y < 0 || x >= image.width || y >= image.height) return;
  std::copy(color.data(), color.data() + 3, image.at(x, y));
}

/// Text on a white background with its upper left corner at (x, y).
void DrawText(Image8& image, int x, int y, const std::string& text, double scale) {
  cv::Mat canvas(image.height, image.width, CV_8UC3, image.data.data());
  const int thick = scale > 0.5 ? 2 : 1;
  int below = 0;
  const cv::Size size = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, scale, thick, &below);
  const int pad = 2 + size.height / 4;
  const cv::Rect plate(x, y, size.width + 2 * pad, size.height + below / 2 + 2 * pad);
  cv::rectangle(canvas, plate, cv::Scalar(255, 255, 255), cv::FILLED);
  cv::putText(canvas, text, {x + pad, y + pad + size.height}, cv::FONT_HERSHEY_SIMPLEX, scale,
              cv::Scalar(20, 20, 20), thick, cv::LINE_AA);
}

double TextScale(const Image8& image) { return std::max(0.35, image.width / 800.0); }

/// @param seen  false: draws a ring, because the place is hidden in this view
void DrawMark(Image8& image, const Eigen::Vector2d& at, int number, bool square, bool seen,
              const Color& color) {
  const int radius = std::max(3, image.width / 70);
  const auto cx = static_cast<int>(at.x()), cy = static_cast<int>(at.y());
  for (int y = -radius - 1; y <= radius + 1; ++y)
    for (int x = -radius - 1; x <= radius + 1; ++x) {
      const double r = square ? std::max(std::abs(x), std::abs(y)) : std::hypot(x, y);
      if (r <= radius && (seen || r > radius - 2))
        Set(image, cx + x, cy + y, color);
      else if (r > radius && r <= radius + 1.5)
        Set(image, cx + x, cy + y, {255, 255, 255});
    }
  const std::string text = std::to_string(number);
  const double scale = TextScale(image);
  const int width = static_cast<int>(26 * scale * static_cast<double>(text.size()) + 10);
  DrawText(image, std::clamp(cx + radius + 2, 0, image.width - width),
           std::clamp(cy - radius - 8, 0, image.height - radius - 20), text, scale);
}

/// A colour for each number; neighbouring numbers have very different colours.
Color MarkColor(std::size_t index) {
  const double hue = std::fmod(0.61803398875 * static_cast<double>(index), 1.0) * 6;
  const auto channel = [&](double shift) {
    const double k = std::fmod(shift + hue, 6.0);
    return static_cast<std::uint8_t>(230 - 200 * std::clamp(std::min(k, 4 - k), 0.0, 1.0));
  };
  return {channel(5), channel(3), channel(1)};
}

/// Pale colours by position in the bounding box.
ColorsX3 Tints(const PointsX3& points) {
  const Eigen::RowVector3d low = points.colwise().minCoeff(),
                           extent = (points.colwise().maxCoeff() - low).cwiseMax(1e-12);
  ColorsX3 tints(points.rows(), 3);
  for (Eigen::Index v = 0; v < points.rows(); ++v)
    tints.row(v) = (100 + 150 * (points.row(v) - low).cwiseQuotient(extent).array())
                       .cast<std::uint8_t>()
                       .matrix();
  return tints;
}

ColorsX3 CarriedTints(const ColorsX3& tints, const PointsX3& target,
                      const std::vector<int>& dense) {
  std::vector<int> mapped;
  for (std::size_t v = 0; v < dense.size(); ++v)
    if (dense[v] >= 0) mapped.push_back(static_cast<int>(v));
  ColorsX3 carried = ColorsX3::Constant(target.rows(), 3, 190);
  if (mapped.empty()) return carried;
  PointsX3 images(std::ssize(mapped), 3);
  for (std::size_t i = 0; i < mapped.size(); ++i) images.row(i) = target.row(dense[mapped[i]]);
  const KdTree tree(images);
  for (Eigen::Index v = 0; v < target.rows(); ++v)
    carried.row(v) = tints.row(mapped[tree.Nearest(target.row(v).transpose()).index]);
  return carried;
}

/// One mesh with its landmarks, which can be drawn from any side.
class Subject {
 public:
  /// @param colors  used instead of the mesh's own; empty: the mesh's own
  Subject(const Mesh& mesh, std::vector<Eigen::Vector3d> marks, ColorsX3 colors, bool plain,
          const LandmarkPictureOptions& options)
      : mesh_(mesh),
        scene_(mesh.points, mesh.faces),
        normals_(VertexNormals(mesh.points, mesh.faces)),
        marks_(std::move(marks)),
        colors_(std::move(colors)),
        plain_(plain),
        options_(options),
        diagonal_(BoundingDiagonal(mesh.points)) {}

  View ViewFrom(double azimuth_deg, double elevation_deg) const {
    return FitView(mesh_.points, azimuth_deg, elevation_deg, options_.panel, options_.panel,
                   options_.up);
  }

  /// Whether the mark is visible: nothing of the mesh is in front of it, except within 1 % of the
  /// mesh's diagonal.
  bool Sees(const View& view, std::size_t mark) const {
    const Eigen::Vector3d way = marks_[mark] - view.Center();
    const RayScene::Hit hit = scene_.Cast(view.Center(), way.normalized());
    return hit.face < 0 || hit.distance > way.norm() - kVisibleWithin * diagonal_;
  }

  /// The view that faces the mark most directly. Views that see the mark are preferred.
  View Squarest(std::size_t mark) const {
    const RayScene::Foot foot = scene_.ClosestPoint(marks_[mark]);
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k)
      normal += foot.barycentric[k] * normals_.row(mesh_.faces(foot.face, k)).transpose();
    View best;
    double best_score = -10;
    for (double elevation = -70; elevation <= 70; elevation += 20)
      for (double azimuth = 0; azimuth < 360; azimuth += 15) {
        const View view = ViewFrom(azimuth, elevation);
        const double score =
            normal.dot((view.Center() - marks_[mark]).normalized()) + (Sees(view, mark) ? 2 : 0);
        if (score > best_score) {
          best_score = score;
          best = view;
        }
      }
    return best;
  }

  /// @param own  the pair that the view was made for, which is drawn even if hidden; -1: none
  Image8 Draw(const View& view, const std::vector<DrawnPair>& pairs, int own) const {
    RenderOptions render;
    render.vertex_colors = colors_;
    render.plain = plain_;
    Image8 image = Render(mesh_, scene_, view, render);
    for (std::size_t k = 0; k < marks_.size(); ++k) {
      const bool seen = Sees(view, k);
      if (!seen && static_cast<int>(k) != own) continue;
      DrawMark(image, view.Project(marks_[k]), static_cast<int>(k) + 1, pairs[k].confirmed, seen,
               MarkColor(k));
    }
    return image;
  }

 private:
  const Mesh& mesh_;
  RayScene scene_;
  PointsX3 normals_;
  std::vector<Eigen::Vector3d> marks_;
  ColorsX3 colors_;
  bool plain_;
  LandmarkPictureOptions options_;
  double diagonal_;
};

/// One column of the picture: a view of each mesh.
struct Column {
  View source, target;
  int own = -1;  // the pair that this column was added for, or -1
};

/// The requested sides, then a column for each pair that the columns before do not show on both
/// meshes.
std::vector<Column> Columns(const Subject& source, const Subject& target, std::size_t pairs,
                            const LandmarkPictureOptions& options) {
  std::vector<Column> columns;
  for (const double azimuth : options.azimuths_deg)
    columns.push_back({source.ViewFrom(azimuth, 10), target.ViewFrom(azimuth, 10), -1});
  for (std::size_t k = 0; k < pairs; ++k) {
    const auto in_source = [&](const Column& column) { return source.Sees(column.source, k); };
    const auto in_target = [&](const Column& column) { return target.Sees(column.target, k); };
    if (std::any_of(columns.begin(), columns.end(), in_source) &&
        std::any_of(columns.begin(), columns.end(), in_target))
      continue;
    columns.push_back({source.Squarest(k), target.Squarest(k), static_cast<int>(k)});
  }
  return columns;
}

}  // namespace

Image8 DrawLandmarks(const Mesh& source, const Mesh& target, const std::vector<DrawnPair>& pairs,
                     const std::vector<int>& dense, const LandmarkPictureOptions& options) {
  RequireUsable(source, "landmark picture: source");
  RequireUsable(target, "landmark picture: target");
  if (options.panel < 64 || options.azimuths_deg.empty())
    throw InputError("landmark picture: needs views of 64 pixels or more");
  if (!dense.empty() && dense.size() != static_cast<std::size_t>(source.vertex_count()))
    throw InputError("landmark picture: the dense map must have one entry for each source vertex");
  std::vector<Eigen::Vector3d> on_source, on_target;
  for (const DrawnPair& pair : pairs) {
    on_source.push_back(pair.source);
    on_target.push_back(pair.target);
  }
  // Meshes with colours are drawn in them. Meshes without get tints by position.
  const bool colored = source.colors.rows() > 0 || target.colors.rows() > 0,
             tinted = !colored && !dense.empty();
  ColorsX3 tints, carried;
  if (tinted) {
    tints = Tints(source.points);
    carried = CarriedTints(tints, target.points, dense);
  }
  const Subject from(source, on_source, tints, !tinted && source.colors.rows() == 0, options);
  const Subject to(target, on_target, carried, !tinted && target.colors.rows() == 0, options);
  const std::vector<Column> columns = Columns(from, to, pairs.size(), options);
  const std::size_t wide = options.azimuths_deg.size();
  std::vector<Image8> panels;
  for (std::size_t first = 0; first < columns.size(); first += wide) {
    for (const bool is_source : {true, false}) {
      for (std::size_t c = first; c < first + wide; ++c) {
        Image8 panel(options.panel, options.panel, 3);
        std::fill(panel.data.begin(), panel.data.end(), std::uint8_t{255});
        if (c < columns.size())
          panel = is_source ? from.Draw(columns[c].source, pairs, columns[c].own)
                            : to.Draw(columns[c].target, pairs, columns[c].own);
        if (c == first)
          DrawText(panel, 0, 0, is_source ? options.source_name : options.target_name,
                   TextScale(panel));
        panels.push_back(std::move(panel));
      }
    }
  }
  return TileImages(panels, static_cast<int>(wide));
}

}  // namespace keypose::registration
