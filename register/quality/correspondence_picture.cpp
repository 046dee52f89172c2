#include "register/quality/correspondence_picture.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "core/numbers/parallel.h"
#include "core/pictures/render.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/camera.h"
#include "core/values/errors.h"

namespace keypose::registration {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// A target point farther away than this has no counterpart, over the target's diagonal.
constexpr double kTooFar = 0.05;
constexpr double kElevation_deg = 12;
constexpr double kSlab = 0.04;  // share of the height that may contain the feet
const Vector3d kBackground(246, 247, 249), kGrey(150, 150, 150);

/// A surface with the data that rendering needs.
struct Surface {
  PointsX3 points, normals;
  const FacesX3& faces;
  RayScene scene;

  Surface(PointsX3 p, const FacesX3& f)
      : points(std::move(p)), normals(VertexNormals(points, f)), faces(f), scene(points, f) {}
  Vector3d Mix(const PointsX3& values, int face, const Vector3d& w) const {
    return (w[0] * values.row(faces(face, 0)) + w[1] * values.row(faces(face, 1)) +
            w[2] * values.row(faces(face, 2)))
        .transpose();
  }
};

/// Smooth colours by position, times a checker with soft borders.
class Pattern {
 public:
  Pattern(const PointsX3& points, int cells)
      : low_(points.colwise().minCoeff()), cell_(BoundingDiagonal(points) / cells) {
    extent_ = (points.colwise().maxCoeff().transpose() - low_).cwiseMax(1e-9 * cell_ * cells);
    // The cells are oblique, so that flat sides and mirror planes do not coincide with a border.
    axes_ =
        (Eigen::AngleAxisd(0.61, Vector3d::UnitX()) * Eigen::AngleAxisd(0.47, Vector3d::UnitY()) *
         Eigen::AngleAxisd(0.83, Vector3d::UnitZ()))
            .toRotationMatrix();
  }
  /// @param footprint  size of a pixel on the surface; borders are softened over this width
  Vector3d At(const Vector3d& p, double footprint) const {
    const Vector3d share = (p - low_).cwiseQuotient(extent_), q = axes_ * p / cell_;
    const double soft = std::max(footprint / cell_, 1e-6);
    double parity = 1;
    for (int k = 0; k < 3; ++k) {
      const double nearest = std::round(q[k]),
                   side = std::fmod(std::abs(nearest), 2) < 0.5 ? 1 : -1;
      parity *= side * std::clamp((q[k] - nearest) / soft, -1.0, 1.0);
    }
    const Vector3d base = Vector3d(70, 80, 90) + 165 * share;
    return base * (0.70 + 0.30 * parity);
  }

 private:
  Vector3d low_, extent_;
  double cell_;
  Matrix3d axes_;
};

using Shade = std::function<Vector3d(int face, const Vector3d& weights, const Vector3d& point,
                                     double footprint)>;

struct Ray {
  bool hit = false;
  double depth = 0;
  std::array<Vector3d, 2> colors = {kBackground, kBackground};  // one a shade
};

Ray Trace(const Surface& surface, const View& view, const Matrix3d& world_from_camera,
          const Eigen::Vector2d& pixel, const std::vector<Shade>& shades) {
  const Vector3d eye = view.Center(), direction = world_from_camera * view.camera.Unproject(pixel);
  const RayScene::Hit hit = surface.scene.Cast(eye, direction);
  Ray ray;
  if (hit.face < 0) return ray;
  const Vector3d w(1 - hit.u - hit.v, hit.u, hit.v);
  Vector3d n = surface.Mix(surface.normals, hit.face, w).normalized();
  if (!n.allFinite()) n = -direction.normalized();
  if (n.dot(direction) > 0) n = -n;
  const Vector3d lamp = (world_from_camera * Vector3d(-0.4, -0.6, -0.9)).normalized();
  const double light = 0.52 + 0.48 * std::max(0.0, n.dot(lamp));
  ray.hit = true;
  ray.depth = hit.distance;
  for (std::size_t i = 0; i < shades.size(); ++i)
    ray.colors[i] = light * shades[i](hit.face, w, eye + hit.distance * direction,
                                      hit.distance / view.camera.fx);
  return ray;
}

std::uint8_t ToByte(double x) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(x, 0.0, 255.0)));
}

/// One ray for each pixel, row after row.
struct RayGrid {
  RayGrid(int columns, int rows)
      : width(columns), height(rows), rays(static_cast<std::size_t>(columns) * rows) {}
  Ray& at(int x, int y) { return rays[static_cast<std::size_t>(y) * width + x]; }
  const Ray& at(int x, int y) const { return rays[static_cast<std::size_t>(y) * width + x]; }
  /// Whether a neighbouring pixel differs, or its depth does by more than `jump`.
  bool OnOutline(int x, int y, double jump) const;

  int width, height;
  std::vector<Ray> rays;
};

bool RayGrid::OnOutline(int x, int y, double jump) const {
  const Ray& ray = at(x, y);
  for (const auto& [dx, dy] :
       {std::array{1, 0}, std::array{-1, 0}, std::array{0, 1}, std::array{0, -1}}) {
    const Ray& other = at(std::clamp(x + dx, 0, width - 1), std::clamp(y + dy, 0, height - 1));
    if (other.hit != ray.hit || (ray.hit && std::abs(other.depth - ray.depth) > jump)) return true;
  }
  return false;
}

/// Renders one picture for each shade (at most two). One ray per pixel, and a few more where
/// neighbouring pixels differ in depth.
std::vector<Image8> Draw(const Surface& surface, const View& view,
                         const std::vector<Shade>& shades) {
  const Camera& c = view.camera;
  const Matrix3d world_from_camera = view.camera_from_world.rotation.conjugate().toRotationMatrix();
  const PixelBox box = ProjectedBounds(surface.points, view);
  const double jump = 0.02 * BoundingDiagonal(surface.points);
  RayGrid grid(c.width, c.height);
  ParallelFor(std::max(0, box.y1 - box.y0), [&](std::int64_t row) {
    const int y = box.y0 + static_cast<int>(row);
    for (int x = box.x0; x < box.x1; ++x)
      grid.at(x, y) = Trace(surface, view, world_from_camera, {x + 0.5, y + 0.5}, shades);
  });
  std::vector<Image8> images(shades.size(), Image8(c.width, c.height, 3));
  ParallelFor(c.height, [&](std::int64_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < c.width; ++x) {
      std::array<Vector3d, 2> colors = grid.at(x, y).colors;
      if (grid.OnOutline(x, y, jump)) {
        for (int s = 0; s < 4; ++s) {
          const Ray more = Trace(surface, view, world_from_camera,
                                 {x + (s % 2 ? 0.8 : 0.3), y + (s / 2 ? 0.7 : 0.2)}, shades);
          for (int i = 0; i < 2; ++i) colors[i] += more.colors[i];
        }
        for (Vector3d& color : colors) color /= 5;
      }
      for (std::size_t i = 0; i < images.size(); ++i)
        for (int k = 0; k < 3; ++k) images[i].at(x, y)[k] = ToByte(colors[i][k]);
    }
  });
  return images;
}

/// Draws white dots with a dark border at the points that are visible.
void DrawDots(const Surface& surface, const View& view, const std::vector<Vector3d>& points,
              Image8& image) {
  const double near = 0.01 * BoundingDiagonal(surface.points),
               radius = std::max(2.0, image.width / 90.0);
  for (const Vector3d& p : points) {
    const Vector3d to = p - view.Center();
    const RayScene::Hit hit = surface.scene.Cast(view.Center(), to.normalized());
    if (hit.face >= 0 && hit.distance < to.norm() - near) continue;
    const Eigen::Vector2d at = view.Project(p);
    for (int y = static_cast<int>(at.y() - radius - 2); y <= at.y() + radius + 2; ++y)
      for (int x = static_cast<int>(at.x() - radius - 2); x <= at.x() + radius + 2; ++x) {
        if (x < 0 || y < 0 || x >= image.width || y >= image.height) continue;
        const double d = (Eigen::Vector2d(x + 0.5, y + 0.5) - at).norm();
        const double inside = std::clamp(radius + 0.5 - d, 0.0, 1.0),
                     rim = std::clamp(radius + 1.7 - d, 0.0, 1.0);
        for (int k = 0; k < 3; ++k)
          image.at(x, y)[k] = ToByte(image.at(x, y)[k] * (1 - rim) * (1 - inside) +
                                     20 * rim * (1 - inside) + 255 * inside);
      }
  }
}

/// A rotation after which x is right, y points away from the camera and z is up. The shortest side
/// becomes the depth. Meshes may have y or z up, so the up axis is guessed: the one whose lowest
/// points spread most, like feet.
Matrix3d Upright(const PointsX3& points) {
  const Vector3d low = points.colwise().minCoeff(),
                 extent = points.colwise().maxCoeff().transpose() - low;
  int depth = 0, up = 2;
  extent.minCoeff(&depth);
  double widest = -1;
  for (int axis : {2, 1, 0}) {
    if (axis == depth) continue;
    Vector3d from = Vector3d::Constant(1e300), to = -from;
    for (Eigen::Index v = 0; v < points.rows(); ++v) {
      if (points(v, axis) > low[axis] + kSlab * extent[axis]) continue;
      from = from.cwiseMin(points.row(v).transpose());
      to = to.cwiseMax(points.row(v).transpose());
    }
    const double width = (to - from).norm();
    if (width <= 1.02 * widest) continue;
    widest = width;
    up = axis;
  }
  Matrix3d turned;
  turned.row(2) = Vector3d::Unit(up).transpose();
  turned.row(0) = Vector3d::Unit(3 - up - depth).transpose();
  turned.row(1) = turned.row(2).cross(turned.row(0));
  return turned;
}

/// Draws a bar of the error colours at the right edge, with no error at the bottom.
void DrawScale(Image8& image) {
  const int width = std::max(3, image.width / 40), margin = image.height / 12;
  for (int y = margin; y < image.height - margin; ++y) {
    const auto color = MapColor(1 - (y - margin) / (image.height - 2.0 * margin), ColorMap::kHeat);
    for (int x = image.width - width - 2; x < image.width - 2; ++x)
      for (int k = 0; k < 3; ++k) image.at(x, y)[k] = color[k];
  }
}

void Check(const Mesh& source, const PointsX3& registered, const Mesh& target,
           const PictureOptions& options) {
  RequireUsable(source, "register: picture: source");
  RequireUsable(target, "register: picture: target");
  if (registered.rows() != source.points.rows() || !registered.allFinite())
    throw InputError(
        "register: picture: the registered points are not the source's, or not finite");
  if (options.panel < 16 || options.panel > 4096 || options.cells < 1 ||
      !(options.error_at_red > 0) || options.turns_deg.empty())
    throw InputError(
        "register: picture: panels must have 16 to 4096 pixels, and cells, error_at_red and turns "
        "must be positive");
}

/// Error colours of the registered vertices.
PointsX3 ErrorColors(const Surface& registered, const Surface& target, double at_red) {
  PointsX3 colors(registered.points.rows(), 3);
  ParallelBlocks(colors.rows(), 256, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v) {
      const double d =
          std::sqrt(target.scene.ClosestPoint(registered.points.row(v)).squared_distance);
      colors.row(v) = MapColor(d / at_red, ColorMap::kHeat).cast<double>().transpose();
    }
  });
  return colors;
}

/// Where the landmarks are on the source, the registered mesh and the target.
std::array<std::vector<Vector3d>, 3> MarksOn(const std::vector<LandmarkGoal>& landmarks,
                                             const Surface& from, const Surface& moved,
                                             const Matrix3d& upright) {
  std::array<std::vector<Vector3d>, 3> marks;
  for (const LandmarkGoal& goal : landmarks) {
    marks[0].push_back(PositionOf(goal.source, from.points));
    marks[1].push_back(PositionOf(goal.source, moved.points));
    marks[2].emplace_back(upright * goal.target);
  }
  return marks;
}

/// What the panels of a row show.
struct RowOfPanels {
  const Surface &from, &moved, &onto;
  Shade by_source, by_error, carried;
  std::array<std::vector<Vector3d>, 3> marks;
};

void DrawRow(const RowOfPanels& row, double turn_deg, int panel, std::vector<Image8>& panels) {
  const View own = FitView(row.from.points, turn_deg, kElevation_deg, panel, panel);
  const View shared = FitView(row.onto.points, turn_deg, kElevation_deg, panel, panel);
  std::vector<Image8> first = Draw(row.from, own, {row.by_source}),
                      second = Draw(row.moved, shared, {row.by_source, row.by_error}),
                      third = Draw(row.onto, shared, {row.carried});
  DrawDots(row.from, own, row.marks[0], first[0]);
  DrawDots(row.moved, shared, row.marks[1], second[0]);
  DrawDots(row.onto, shared, row.marks[2], third[0]);
  DrawScale(second[1]);
  for (Image8* image : {&first[0], &second[0], &third[0], &second[1]})
    panels.push_back(std::move(*image));
}

}  // namespace

Image8 DrawCorrespondence(const Mesh& source, const PointsX3& registered, const Mesh& target,
                          const std::vector<LandmarkGoal>& landmarks,
                          const PictureOptions& options) {
  Check(source, registered, target, options);
  const Matrix3d upright = Upright(target.points);
  const double diagonal = BoundingDiagonal(target.points);
  // The source is aligned to the registered mesh, so that the panels can be compared.
  Similarity3 aligned;
  if (source.vertex_count() >= 3 && BoundingDiagonal(source.points) > 0)
    aligned = FitSimilarity(source.points, registered);
  const double size = aligned.scale > 0 ? aligned.scale : 1;
  const Surface from(Transformed(aligned, source.points) * upright.transpose(), source.faces);
  const Surface moved(registered * upright.transpose(), source.faces),
      onto(target.points * upright.transpose(), target.faces);
  const Pattern pattern(source.points, options.cells);
  const PointsX3 errors = ErrorColors(moved, onto, options.error_at_red * diagonal);
  const Shade by_source = [&](int face, const Vector3d& w, const Vector3d&, double footprint) {
    return pattern.At(from.Mix(source.points, face, w), footprint / size);
  };
  const Shade by_error = [&](int face, const Vector3d& w, const Vector3d&, double) {
    return moved.Mix(errors, face, w);
  };
  const Shade carried = [&](int face, const Vector3d& w, const Vector3d& p,
                            double footprint) -> Vector3d {
    const RayScene::Foot foot = moved.scene.ClosestPoint(p, kTooFar * diagonal);
    if (foot.face < 0) return kGrey;
    const Vector3d ours = moved.Mix(moved.normals, foot.face, foot.barycentric);
    return ours.dot(onto.Mix(onto.normals, face, w)) > 0
               ? pattern.At(from.Mix(source.points, foot.face, foot.barycentric), footprint / size)
               : kGrey;
  };
  const RowOfPanels row = {
      from, moved, onto, by_source, by_error, carried, MarksOn(landmarks, from, moved, upright)};
  std::vector<Image8> panels;
  for (const double turn : options.turns_deg) DrawRow(row, turn, options.panel, panels);
  return TileImages(panels, 4);
}

}  // namespace keypose::registration
