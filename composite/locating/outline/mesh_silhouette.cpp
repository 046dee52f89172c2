#include "composite/locating/outline/mesh_silhouette.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/numbers/parallel.h"
#include "core/pictures/render.h"
#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"
#include "deform/levels/edge_collapse.h"

namespace keypose::composite {
namespace {

constexpr double kBeyond = 1.5;   // px from an outline to where the picture is looked at
constexpr double kBehind = 0.02;  // of the radius: what lies deeper is another part
constexpr double kSkin = 2e-3;    // of the radius: a surface does not hide itself

std::vector<char> FacesTowards(const Figure& figure, const Eigen::Vector3d& eye) {
  std::vector<char> towards(figure.faces.rows());
  for (Eigen::Index f = 0; f < figure.faces.rows(); ++f) {
    const Eigen::Vector3d p = figure.points.row(figure.faces(f, 0)),
                          q = figure.points.row(figure.faces(f, 1)),
                          r = figure.points.row(figure.faces(f, 2));
    towards[f] = (q - p).cross(r - p).dot(eye - p) > 0;
  }
  return towards;
}

/// What the picture shows just beyond an outline.
enum class Beyond { kNothing, kPartBehind, kHidden };

class Looker {
 public:
  Looker(const Figure& figure, const Placement& at)
      : figure_(figure),
        at_(at),
        eye_(at.camera_from_mesh.Inverse().translation),
        turn_(at.camera_from_mesh.rotation.conjugate().toRotationMatrix()) {}
  const Eigen::Vector3d& eye() const { return eye_; }

  Beyond Look(const Eigen::Vector3d& position, const Eigen::Vector2d& beyond) const {
    const RayScene::Hit hit = figure_.scene.Cast(eye_, turn_ * at_.camera.Unproject(beyond));
    if (hit.face < 0) return Beyond::kNothing;
    const double depth = (at_.camera_from_mesh * position).z();
    if (hit.distance < depth + kBehind * figure_.radius) return Beyond::kHidden;
    const double near_end = 1 - kSkin * figure_.radius / depth;
    const bool hidden = figure_.scene.Occluded(eye_, position - eye_, 0, near_end);
    return hidden ? Beyond::kHidden : Beyond::kPartBehind;
  }

 private:
  const Figure& figure_;
  const Placement& at_;
  Eigen::Vector3d eye_;
  Eigen::Matrix3d turn_;
};

/// Adds the visible pieces of one edge.
/// @param sign  1 when the outside lies to the right of the way from a to b, in the picture
void AddPieces(const Looker& looker, const Figure& figure, const Placement& at,
               const FacePairs::Pair& pair, double sign, double step_px, bool inner,
               std::vector<SilhouettePoint>& found) {
  const Eigen::Vector3d a = figure.points.row(pair.a), b = figure.points.row(pair.b);
  if ((at.camera_from_mesh * a).z() <= 0 || (at.camera_from_mesh * b).z() <= 0) return;
  const Eigen::Vector2d along = at.Project(b) - at.Project(a);
  const double length = along.norm();
  if (length < 1e-9) return;
  const Eigen::Vector2d normal = Eigen::Vector2d(-along.y(), along.x()) * (sign / length);
  const int pieces = std::max(1, static_cast<int>(std::ceil(length / step_px)));
  for (int i = 0; i < pieces; ++i) {
    SilhouettePoint point;
    point.position = a + (i + 0.5) / pieces * (b - a);
    point.pixel = at.Project(point.position);
    point.normal = normal;
    point.length_px = length / pieces;
    const Beyond beyond = looker.Look(point.position, point.pixel + kBeyond * normal);
    if (beyond == Beyond::kHidden || (beyond == Beyond::kPartBehind && !inner)) continue;
    point.inner = beyond == Beyond::kPartBehind;
    found.push_back(point);
  }
}

}  // namespace

Figure::Figure(const PointsX3& at, const FacesX3& of)
    : points(at), faces(of), pairs(FindFacePairs(of)), scene(at, of) {
  const Eigen::VectorXd areas = FaceAreas(points, faces);
  const double area = std::max(areas.sum(), 1e-300);
  center.setZero();
  double squares = 0;
  const auto middle = [&](Eigen::Index f) -> Eigen::Vector3d {
    return (points.row(faces(f, 0)) + points.row(faces(f, 1)) + points.row(faces(f, 2))) / 3;
  };
  for (Eigen::Index f = 0; f < faces.rows(); ++f) center += areas[f] / area * middle(f);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    squares += areas[f] / area * (middle(f) - center).squaredNorm();
  radius = std::sqrt(squares);
}

Figure Simplified(const PointsX3& points, const FacesX3& faces, int vertices) {
  if (points.rows() <= vertices) return Figure(points, faces);
  DecimatedMesh mesh = ToDecimatedMesh(points, faces);
  std::vector<int> parent(points.rows());
  for (int i = 0; i < SizeOf(parent); ++i) parent[i] = i;
  DecimateInRounds(mesh, vertices, parent);
  FacesX3 fewer(SizeOf(mesh.faces), 3);
  for (int f = 0; f < SizeOf(mesh.faces); ++f)
    fewer.row(f) << mesh.faces[f][0], mesh.faces[f][1], mesh.faces[f][2];
  return Figure(mesh.points, fewer);
}

std::vector<SilhouettePoint> FindSilhouette(const Figure& figure, const Placement& at,
                                            double step_px, bool inner) {
  const Looker looker(figure, at);
  const std::vector<char> towards = FacesTowards(figure, looker.eye());
  std::vector<SilhouettePoint> found;
  for (const FacePairs::Pair& pair : figure.pairs.pairs) {
    if (towards[pair.left] == towards[pair.right]) continue;
    // A face towards the camera lies to the left of its edges as one looks at the picture; there y
    // points down, so the right of (x, y) is (-y, x).
    AddPieces(looker, figure, at, pair, towards[pair.left] ? 1 : -1, step_px, inner, found);
  }
  return found;
}

Image8 Covered(const Figure& figure, const Placement& at) {
  View view;
  view.camera = at.camera;
  view.camera_from_world = at.camera_from_mesh;
  Image8 covered(at.camera.width, at.camera.height, 1);
  const PixelBox box = ProjectedBounds(figure.points, view);
  const Eigen::Vector3d eye = view.Center();
  const Eigen::Matrix3d turn = at.camera_from_mesh.rotation.conjugate().toRotationMatrix();
  ParallelFor(
      std::max(0, box.y1 - box.y0),
      [&](std::int64_t row) {
        const int y = box.y0 + static_cast<int>(row);
        for (int x = box.x0; x < box.x1; ++x) {
          const Eigen::Vector3d ray = turn * at.camera.Unproject({x + 0.5, y + 0.5});
          if (figure.scene.Occluded(eye, ray, 0, std::numeric_limits<double>::infinity()))
            *covered.at(x, y) = 255;
        }
      },
      16);
  return covered;
}

}  // namespace keypose::composite
