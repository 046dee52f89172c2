#include "register/intrinsic/intrinsic_shape.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "core/values/union_find.h"
#include "deform/levels/hierarchy.h"

namespace keypose::registration {

namespace {

// Chosen on the seven registration pairs (docs/results/landmarks.md), which have no colours: no
// record of the data for kColorWeight. Sensitivity: docs/results/sensitivity.md.
struct IntrinsicShapeTuning {
  // Over the square root of the area. Smaller bumps depend on the pose. Tips closer together, such
  // as the fingers of a hand, would only increase the number of assignments.
  KEYPOSE_TUNED(double, kLeastPersistence, 0.03);
  KEYPOSE_TUNED(double, kLeastSeparation, 0.2);
  KEYPOSE_TUNED(double, kNormalTime, 0.001);  // area: smoothing before normals are taken
  // The descriptor for nearness to a landmark: its weight, and its range over the square root of
  // the area. At larger distances it would change too much with the pose.
  KEYPOSE_TUNED(double, kKnownWeight, 2);
  KEYPOSE_TUNED(double, kKnownReach, 0.2);
  KEYPOSE_TUNED(double, kColorWeight, 2);    // weight of colours from 0 to 1
  KEYPOSE_TUNED(double, kBulgeSpread, 0.3);  // about the spread of the other descriptors
};

constexpr std::size_t kLeastTips = 5;

/// Marks the faces of the piece with the largest area. Faces belong to one piece when they share an
/// edge. A shared vertex is not enough: pieces that touch in one vertex, as at ragged holes, would
/// each add an eigenfunction of their own.
std::vector<char> InLargestPiece(const Mesh& mesh) {
  UnionFind pieces(mesh.face_count());
  std::vector<std::array<int, 3>> sides;
  sides.reserve(3 * static_cast<std::size_t>(mesh.face_count()));
  for (int f = 0; f < mesh.face_count(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int a = mesh.faces(f, k), b = mesh.faces(f, (k + 1) % 3);
      sides.push_back({std::min(a, b), std::max(a, b), f});
    }
  std::sort(sides.begin(), sides.end());
  for (std::size_t i = 1; i < sides.size(); ++i)
    if (sides[i][0] == sides[i - 1][0] && sides[i][1] == sides[i - 1][1])
      pieces.Join(sides[i][2], sides[i - 1][2]);
  const Eigen::VectorXd face_areas = FaceAreas(mesh.points, mesh.faces);
  Eigen::VectorXd area = Eigen::VectorXd::Zero(mesh.face_count());
  for (int f = 0; f < mesh.face_count(); ++f) area[pieces.Find(f)] += face_areas[f];
  Eigen::Index largest = 0;
  if (!(area.maxCoeff(&largest) > 0)) throw InputError("register: the surface has no area");
  std::vector<char> in(static_cast<std::size_t>(mesh.face_count()));
  for (int f = 0; f < mesh.face_count(); ++f) in[f] = pieces.Find(f) == largest;
  return in;
}

/// @param to_piece  the vertices' numbers there
FacesX3 FacesIn(const Mesh& mesh, const std::vector<char>& face_in,
                const std::vector<int>& to_piece) {
  FacesX3 faces(mesh.face_count(), 3);
  Eigen::Index kept = 0;
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
    if (face_in[f]) {
      for (int k = 0; k < 3; ++k) faces(kept, k) = to_piece[mesh.faces(f, k)];
      ++kept;
    }
  faces.conservativeResize(kept, 3);
  return faces;
}

void BuildProxy(const Mesh& mesh, int vertices, IntrinsicShape& shape) {
  const std::vector<char> face_in = InLargestPiece(mesh);
  std::vector<char> in(static_cast<std::size_t>(mesh.vertex_count()), 0);
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
    if (face_in[f])
      for (int k = 0; k < 3; ++k) in[mesh.faces(f, k)] = 1;
  Mesh piece;
  std::vector<int> to_piece(in.size(), -1), from_piece;
  for (std::size_t v = 0; v < in.size(); ++v)
    if (in[v]) {
      to_piece[v] = SizeOf(from_piece);
      from_piece.push_back(static_cast<int>(v));
    }
  piece.points.resize(std::ssize(from_piece), 3);
  for (std::size_t i = 0; i < from_piece.size(); ++i)
    piece.points.row(i) = mesh.points.row(from_piece[i]);
  piece.faces = FacesIn(mesh, face_in, to_piece);
  std::vector<CoarseLevel> levels;
  if (piece.vertex_count() > vertices)
    levels = MakeHierarchy(piece.points, piece.faces, {vertices});
  if (levels.empty()) {
    shape.proxy = piece;
    shape.fine = from_piece;
    shape.proxy_of = to_piece;
  } else {
    shape.proxy.points = levels[0].points;
    shape.proxy.faces = levels[0].faces;
    for (const int v : levels[0].fine) shape.fine.push_back(from_piece[v]);
    shape.proxy_of.assign(in.size(), -1);
    for (std::size_t v = 0; v < in.size(); ++v)
      if (in[v]) shape.proxy_of[v] = levels[0].up[to_piece[v]];
  }
  shape.scale = std::sqrt(SurfaceArea(shape.proxy.points, shape.proxy.faces));
  shape.proxy.points /= shape.scale;
  shape.proxy.normals = VertexNormals(shape.proxy.points, shape.proxy.faces);
}

void BuildSamples(int count, IntrinsicShape& shape) {
  shape.samples = shape.graph->FarthestPoints(count);
  shape.graph->From(shape.samples, &shape.sample_of);
  shape.sample_distances = shape.graph->Rows(shape.samples);
  shape.all.functions = shape.spectrum.functions.cast<float>();
  shape.all.weights = shape.spectrum.areas.cast<float>();
  const auto count_made = std::ssize(shape.samples);
  shape.sampled.functions.resize(count_made, shape.all.functions.cols());
  for (Eigen::Index s = 0; s < count_made; ++s)
    shape.sampled.functions.row(s) = shape.all.functions.row(shape.samples[s]);
  Eigen::VectorXd areas = Eigen::VectorXd::Constant(count_made, 1e-9);
  for (std::size_t v = 0; v < shape.sample_of.size(); ++v)
    areas[shape.sample_of[v]] += shape.spectrum.areas[static_cast<Eigen::Index>(v)];
  shape.sampled.weights = areas.cast<float>();
  shape.mean_distance = shape.sample_distances.transpose() * (areas / areas.sum());
}

/// Positions without details finer than the square root of `time`.
PointsX3 Smoothed(const IntrinsicShape& shape, double time) {
  const Spectrum& s = shape.spectrum;
  const Eigen::MatrixXd parts = s.functions.transpose() * s.areas.asDiagonal() * shape.proxy.points;
  return s.functions * ((-time * s.values.array()).exp().matrix().asDiagonal() * parts);
}

/// How far the surface bulges out at a scale: the change along the normal between two degrees of
/// smoothing, scaled to a spread of `kBulgeSpread`.
Eigen::VectorXd Bulge(const IntrinsicShape& shape, double finer, double coarser) {
  const Eigen::VectorXd out = (Smoothed(shape, finer) - Smoothed(shape, coarser))
                                  .cwiseProduct(shape.proxy.normals)
                                  .rowwise()
                                  .sum();
  const double spread = std::sqrt(shape.spectrum.areas.dot(out.cwiseAbs2()));
  return out * (IntrinsicShapeTuning::kBulgeSpread / std::max(spread, 1e-12));
}

/// Fills the descriptors: mean distance, and heat kernel signature and bulge at three scales.
void BuildDescriptors(IntrinsicShape& shape) {
  const std::vector<double> times = {0.003, 0.01,
                                     0.03};  // at unit area: from a limb's girth to half the body
  const Spectrum& s = shape.spectrum;
  shape.descriptors.resize(shape.proxy.vertex_count(), 1 + 2 * std::ssize(times));
  shape.descriptors.col(0) = shape.mean_distance / s.areas.dot(shape.mean_distance);
  const Eigen::MatrixXd squared = s.functions.cwiseAbs2();
  for (std::size_t t = 0; t < times.size(); ++t) {
    const Eigen::VectorXd heat = squared * (-times[t] * s.values.array()).exp().matrix();
    const auto column = 1 + 2 * static_cast<Eigen::Index>(t);
    shape.descriptors.col(column) = (heat / s.areas.dot(heat)).array().max(1e-6).log();
    shape.descriptors.col(column + 1) = Bulge(shape, times[t] / 3, times[t]);
  }
}

/// The direction of steepest rise of the field at the given vertices, as unit tangents; zero where
/// the field is constant.
PointsX3 RiseAt(const Mesh& mesh, const Eigen::VectorXd& field, const std::vector<int>& at) {
  PointsX3 rise = PointsX3::Zero(mesh.vertex_count(), 3);
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f) {
    const Eigen::Vector3d p0 = mesh.points.row(mesh.faces(f, 0)),
                          p1 = mesh.points.row(mesh.faces(f, 1)),
                          p2 = mesh.points.row(mesh.faces(f, 2));
    const Eigen::Vector3d normal = (p1 - p0).cross(p2 - p0);
    const double doubled = normal.norm();
    if (!(doubled > 0)) continue;
    // The gradient times twice the area, so that larger faces have more weight at their corners.
    const Eigen::Vector3d gradient =
        normal.cross((p2 - p1) * field[mesh.faces(f, 0)] + (p0 - p2) * field[mesh.faces(f, 1)] +
                     (p1 - p0) * field[mesh.faces(f, 2)]) /
        doubled;
    for (int k = 0; k < 3; ++k) rise.row(mesh.faces(f, k)) += gradient.transpose();
  }
  PointsX3 picked(std::ssize(at), 3);
  for (std::size_t i = 0; i < at.size(); ++i) {
    const Eigen::RowVector3d n = mesh.normals.row(at[i]), g = rise.row(at[i]);
    const Eigen::RowVector3d tangent = g - g.dot(n) * n;
    picked.row(i) = tangent.norm() > 1e-12 ? Eigen::RowVector3d(tangent.normalized())
                                           : Eigen::RowVector3d::Zero();
  }
  return picked;
}

}  // namespace

IntrinsicShape MakeIntrinsicShape(const Mesh& mesh, const IntrinsicOptions& options) {
  IntrinsicShape shape;
  BuildProxy(mesh, options.vertices, shape);
  if (shape.proxy.vertex_count() < 4)
    throw InputError("register: the surface has fewer than 4 vertices, too few to compare");
  shape.graph = std::make_unique<GeodesicGraph>(shape.proxy.points, shape.proxy.faces);
  shape.spectrum = LaplaceSpectrum(shape.proxy.points, shape.proxy.faces,
                                   std::min(options.functions, shape.proxy.vertex_count() / 3 + 1));
  BuildSamples(options.samples, shape);
  BuildDescriptors(shape);
  // Normals of a smoothed surface. Noisy normals would spoil the measures that compare directions
  // about the normal.
  shape.proxy.normals =
      VertexNormals(Smoothed(shape, IntrinsicShapeTuning::kNormalTime), shape.proxy.faces);
  return shape;
}

void FindTips(const std::vector<int>& known, int most, IntrinsicShape& shape) {
  shape.tips = known;
  const std::size_t limit = known.size() + static_cast<std::size_t>(most);
  Eigen::VectorXd nearest = Eigen::VectorXd::Constant(shape.proxy.vertex_count(), 1e9);
  if (!known.empty()) nearest = shape.graph->From(known);
  for (const Peak& peak : FindPeaks(shape.graph->neighbors(), shape.mean_distance)) {
    if (peak.persistence < IntrinsicShapeTuning::kLeastPersistence || shape.tips.size() >= limit)
      break;
    if (nearest[peak.vertex] < IntrinsicShapeTuning::kLeastSeparation) continue;
    shape.tips.push_back(peak.vertex);
    nearest = nearest.cwiseMin(shape.graph->From({peak.vertex}));
  }
  // A shape without limbs has too few peaks. Then farthest points serve as tips.
  for (const int sample : shape.samples) {
    if (shape.tips.size() >= std::min(limit, known.size() + kLeastTips)) break;
    if (nearest[sample] < IntrinsicShapeTuning::kLeastSeparation) continue;
    shape.tips.push_back(sample);
    nearest = nearest.cwiseMin(shape.graph->From({sample}));
  }
  shape.tip_distances = shape.graph->Rows(shape.tips);
  shape.known = SizeOf(known);
  const Eigen::Index plain = shape.descriptors.cols();
  shape.descriptors.conservativeResize(Eigen::NoChange, plain + shape.known);
  shape.descriptors.rightCols(shape.known) =
      IntrinsicShapeTuning::kKnownWeight *
      (-shape.tip_distances.topRows(shape.known).transpose().array() /
       IntrinsicShapeTuning::kKnownReach)
          .exp()
          .matrix();
}

void AddColors(const ColorsX3& colors, IntrinsicShape& shape) {
  const Eigen::Index plain = shape.descriptors.cols(), vertices = shape.descriptors.rows();
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(vertices, 3);
  Eigen::VectorXd count = Eigen::VectorXd::Zero(vertices);
  for (std::size_t v = 0; v < shape.proxy_of.size(); ++v) {
    if (shape.proxy_of[v] < 0) continue;
    sum.row(shape.proxy_of[v]) += colors.row(v).cast<double>();
    count[shape.proxy_of[v]] += 1;
  }
  sum = count.cwiseMax(1).cwiseInverse().asDiagonal() * sum / 255;
  // Lighting differs between photographs, so only the difference from the mean colour counts.
  const Eigen::RowVector3d mean = shape.spectrum.areas.transpose() * sum;
  sum.rowwise() -= mean;
  shape.descriptors.conservativeResize(Eigen::NoChange, plain + 3);
  shape.descriptors.rightCols(3) = IntrinsicShapeTuning::kColorWeight * sum;
}

std::vector<PointsX3> RisesAtSamples(const IntrinsicShape& shape,
                                     const Eigen::MatrixXd& distances) {
  std::vector<PointsX3> rises(static_cast<std::size_t>(distances.rows()));
  ParallelFor(distances.rows(), [&](std::int64_t r) {
    rises[r] = RiseAt(shape.proxy, distances.row(r).transpose(), shape.samples);
  });
  return rises;
}

}  // namespace keypose::registration
