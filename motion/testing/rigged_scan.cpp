#include "motion/testing/rigged_scan.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <numeric>
#include <string>

#include "core/io/meshes/mesh_io.h"
#include "core/numbers/rotations.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/testing/paths.h"
#include "core/values/angles.h"
#include "core/values/size_of.h"
#include "deform/levels/edge_collapse.h"
#include "deform/levels/geodesics.h"

namespace keypose::motion {

namespace {

namespace fs = std::filesystem;

PointsX3 Upright(const PointsX3& points) {
  PointsX3 upright(points.rows(), 3);
  upright << points.col(0), -points.col(2), points.col(1);
  return upright;
}

PointsX3 Selected(const PointsX3& points, const std::vector<int>& rows) {
  PointsX3 selected(std::ssize(rows), 3);
  for (int k = 0; k < SizeOf(rows); ++k) selected.row(k) = points.row(rows[k]);
  return selected;
}

/// The largest face of each vertex.
std::vector<int> LargestFaces(const PointsX3& points, const FacesX3& faces) {
  const Eigen::VectorXd areas = FaceAreas(points, faces);
  std::vector<int> largest(points.rows(), -1);
  for (int f = 0; f < static_cast<int>(faces.rows()); ++f)
    for (int k = 0; k < 3; ++k) {
      int& best = largest[faces(f, k)];
      if (best < 0 || areas[f] > areas[best]) best = f;
    }
  return largest;
}

Eigen::Vector3d CornerOf(const FacesX3& faces, int face, int vertex) {
  Eigen::Vector3d corner = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k) corner[k] = faces(face, k) == vertex;
  return corner;
}

}  // namespace

std::optional<RiggedScan> LoadRiggedScan(int marks) {
  const fs::path folder = DataFolder() / "motion/rigs/cheburashka";
  if (!fs::exists(folder)) return std::nullopt;
  RiggedScan scan;
  scan.target = ReadMesh(folder / "cheburashka.obj");
  scan.target.points = Upright(scan.target.points);
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.path().extension() == ".obj" && entry.path().parent_path() != folder)
      files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) scan.poses.push_back(Upright(ReadMesh(file).points));

  DecimatedMesh small = ToDecimatedMesh(scan.target.points, scan.target.faces);
  std::vector<int> parent(scan.target.points.rows());
  std::iota(parent.begin(), parent.end(), 0);
  HalfEdgeDecimator decimator(std::move(small), parent);
  decimator.DecimateTo(scan.target.vertex_count() / 10);
  small = decimator.Rest();
  scan.reference = small.points;
  scan.faces.resize(std::ssize(small.faces), 3);
  for (int f = 0; f < SizeOf(small.faces); ++f)
    scan.faces.row(f) << small.faces[f][0], small.faces[f][1], small.faces[f][2];
  for (const PointsX3& pose : scan.poses) scan.frames.push_back(Selected(pose, small.vertex));

  const GeodesicGraph graph(scan.reference, scan.faces);
  const std::vector<int> on_template = LargestFaces(scan.reference, scan.faces),
                         on_target = LargestFaces(scan.target.points, scan.target.faces);
  for (int v : graph.FarthestPoints(marks)) {
    const int w = small.vertex[v];
    scan.marks.push_back({"mark-" + std::to_string(v),
                          {on_template[v], CornerOf(scan.faces, on_template[v], v)},
                          {on_target[w], CornerOf(scan.target.faces, on_target[w], w)}});
  }
  return scan;
}

std::vector<PointsX3> NearestMarkSkinning(const RiggedScan& scan) {
  const GeodesicGraph graph(scan.target.points, scan.target.faces);
  std::vector<int> sources, nearest;
  PointsX3 rest(std::ssize(scan.marks), 3);
  for (int k = 0; k < SizeOf(scan.marks); ++k) {
    const MarkPlace& place = scan.marks[k].on_target;
    Eigen::Index corner = 0;
    place.barycentric.maxCoeff(&corner);
    sources.push_back(scan.target.faces(place.face, corner));
    rest.row(k) = PositionOf(place, scan.target.points, scan.target.faces);
  }
  graph.From(sources, &nearest);
  const MarkMeter meter(scan.marks, scan.reference, scan.faces);
  std::vector<PointsX3> poses;
  for (const PointsX3& frame : scan.frames) {
    const MarkPose marks = meter.Measure(frame, "a frame");
    PointsX3 pose = scan.target.points;
    for (Eigen::Index i = 0; i < pose.rows(); ++i) {
      const int k = nearest[i];
      pose.row(i) = marks.positions.row(k) +
                    (marks.maps[k].rotation * (pose.row(i) - rest.row(k)).transpose()).transpose();
    }
    poses.push_back(std::move(pose));
  }
  return poses;
}

PoseError ErrorOf(const RiggedScan& scan, const std::vector<PointsX3>& poses) {
  PoseError error;
  const double diagonal = BoundingDiagonal(scan.target.points);
  for (int t = 0; t < SizeOf(poses); ++t) {
    const Eigen::VectorXd off = (poses[t] - scan.poses[t]).rowwise().norm() / diagonal;
    error.mean += off.mean() / static_cast<double>(poses.size());
    error.worst = std::max(error.worst, off.mean());
    error.furthest = std::max(error.furthest, off.maxCoeff());
  }
  return error;
}

int FaceNear(const Mesh& mesh, const Eigen::RowVector3d& point) {
  int best = 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (int f = 0; f < mesh.face_count(); ++f) {
    Eigen::RowVector3d centre = Eigen::RowVector3d::Zero();
    for (int k = 0; k < 3; ++k) centre += mesh.points.row(mesh.faces(f, k)) / 3;
    if ((centre - point).norm() < nearest) nearest = (centre - point).norm(), best = f;
  }
  return best;
}

BentArm MakeBentArm(double angle) {
  BentArm result{MakeCylinder(0.2, 2, 24, 60), {}, {}};
  result.bent = result.arm.points;
  const Eigen::RowVector3d joint(0, 0, 1);
  for (Eigen::Index i = 0; i < result.bent.rows(); ++i)
    if (result.bent(i, 2) > 1)
      result.bent.row(i) = joint + (result.bent.row(i) - joint) * ExpOf({0, angle, 0}).transpose();
  for (double z : {0.3, 0.7, 1.3, 1.7})
    for (double x : {-0.2, 0.2}) {
      Mark mark;
      mark.name = "mark-" + std::to_string(result.marks.size());
      mark.on_template.face = mark.on_target.face = FaceNear(result.arm, {x, 0, z});
      result.marks.push_back(mark);
    }
  return result;
}

}  // namespace keypose::motion
