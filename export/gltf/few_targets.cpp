#include "export/gltf/few_targets.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/angles.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "export/gltf/glb_builder.h"
#include "export/gltf/morph_basis.h"
#include "export/gltf/unit_weights.h"

namespace keypose::exporting {
namespace {

/// Of a target, over the diagonal: larger ones would cost digits in single precision.
constexpr double kLargestTarget = 4;
/// What single precision adds to the error, over the diagonal.
constexpr double kRounding = 3e-7;

/// What is written.
struct FewShapes {
  GlbShape base;
  std::vector<GlbShape> differences;
  FloatRows weights;  ///< pictures x targets
};

/// The frames that are distinct pictures, ascending.
std::vector<int> PictureFrames(const Clip& clip) {
  std::vector<int> frames;
  for (int i = 0; i < clip.frame_count(); ++i)
    if (clip.picture[i] == i) frames.push_back(i);
  return frames;
}

/// Directions of the first frame and what each target adds to them, V x 3. Viewers normalise the
/// sum, so only directions count, and a vertex's base can be made a unit vector as glTF demands.
struct NormalBasis {
  PointsX3 base;
  std::vector<PointsX3> targets;
};

/// Normals of the blended pictures, fitted with the pictures' weights.
NormalBasis FitNormals(const MorphBasis& shapes, const FacesX3& faces) {
  constexpr double kShortest = 0.05;
  std::vector<PointsX3> normals(shapes.weights.rows());
  ParallelFor(std::ssize(normals), [&](std::int64_t p) {
    normals[p] = VertexNormals(Blended(shapes, p), faces);
    for (Eigen::Index v = 0; v < normals[p].rows(); ++v)
      if (normals[p].row(v).squaredNorm() < 0.5) normals[p].row(v) = Eigen::RowVector3d::UnitZ();
  });
  Pictures pictures;
  for (const PointsX3& one : normals) pictures.push_back(&one);
  MorphBasis fitted = LeastSquaresBasis(pictures, shapes.weights);
  for (Eigen::Index v = 0; v < fitted.base.rows(); ++v) {
    const double length = fitted.base.row(v).norm();
    const double scale = length > kShortest ? 1 / length : 0;
    fitted.base.row(v) *= scale;
    if (scale == 0) fitted.base.row(v) = normals[0].row(v);
    for (PointsX3& target : fitted.targets) target.row(v) *= scale;
  }
  return {std::move(fitted.base), std::move(fitted.targets)};
}

FewShapes InSinglePrecision(const MorphBasis& shapes, const Scene& scene) {
  const NormalBasis normals = FitNormals(shapes, scene.frames[0].faces);
  const auto rows = [&](const PointsX3& unsplit) {
    return GltfRows(unsplit(scene.split.source_vertex, Eigen::all), scene.z_up);
  };
  FewShapes out{{rows(shapes.base), rows(normals.base)}, {}, shapes.weights.cast<float>()};
  for (int k = 0; k < SizeOf(shapes.targets); ++k)
    out.differences.push_back({rows(shapes.targets[k]), rows(normals.targets[k])});
  return out;
}

/// How far the numbers as written are from a picture.
struct PictureError {
  double largest = 0, square_sum = 0, volume = 0, normal_square_sum_rad = 0;
};

PictureError MeasurePicture(const FewShapes& shapes, const Scene& scene, Eigen::Index picture,
                            int frame) {
  PointsX3 points = shapes.base.positions.cast<double>();
  PointsX3 normals = shapes.base.normals.cast<double>();
  for (int k = 0; k < SizeOf(shapes.differences); ++k) {
    const double weight = shapes.weights(picture, k);
    points += weight * shapes.differences[k].positions.cast<double>();
    normals += weight * shapes.differences[k].normals.cast<double>();
  }
  const AnimatedMesh& split = scene.split;
  const PointsX3 wanted = WithYUp(split.points[frame], scene.z_up);
  const PointsX3 wanted_normals = WithYUp(split.normals[frame], scene.z_up);
  const Eigen::VectorXd squares = (points - wanted).rowwise().squaredNorm();
  PictureError error;
  error.largest = std::sqrt(squares.maxCoeff());
  error.square_sum = squares.sum();
  error.volume = std::abs(SignedVolume(points, split.faces) - SignedVolume(wanted, split.faces));
  for (Eigen::Index v = 0; v < normals.rows(); ++v) {
    const Eigen::Vector3d is = normals.row(v), should_be = wanted_normals.row(v);
    const double angle = std::atan2(is.cross(should_be).norm(), is.dot(should_be));
    error.normal_square_sum_rad += angle * angle;
  }
  return error;
}

void Measure(const FewShapes& shapes, const Scene& scene, const std::vector<int>& frames,
             FormatFiles& out) {
  std::vector<PictureError> errors(frames.size());
  ParallelFor(std::ssize(frames),
              [&](std::int64_t p) { errors[p] = MeasurePicture(shapes, scene, p, frames[p]); });
  PictureError all;
  int worst = 0;
  for (int p = 0; p < SizeOf(errors); ++p) {
    if (errors[p].largest > errors[worst].largest) worst = p;
    all.square_sum += errors[p].square_sum;
    all.volume = std::max(all.volume, errors[p].volume);
    all.normal_square_sum_rad += errors[p].normal_square_sum_rad;
  }
  const double diagonal = SceneDiagonal(scene);
  const double volume = std::abs(SignedVolume(scene.frames[0].points, scene.frames[0].faces));
  const auto count = static_cast<double>(std::ssize(frames) * shapes.base.positions.rows());
  const auto share = [](double part, double whole) { return whole > 0 ? part / whole : 0; };
  out.error_over_diagonal = share(errors[worst].largest, diagonal);
  out.measured["worst_frame"] = frames[worst];
  out.measured["rms_over_diagonal"] = share(std::sqrt(all.square_sum / count), diagonal);
  out.measured["volume_error"] = share(all.volume, volume);
  out.measured["normal_rms_deg"] = std::sqrt(all.normal_square_sum_rad / count) / kDegree;
}

GlbWeights WeightsOverTime(const Scene& scene, const std::vector<int>& frames,
                           const FloatRows& weights) {
  GlbWeights track;
  if (weights.cols() == 0) return track;
  const auto keyframes = SceneKeyframes(scene);
  track.weights.resize(std::ssize(keyframes), weights.cols());
  for (int i = 0; i < SizeOf(keyframes); ++i) {
    track.seconds.push_back(keyframes[i].seconds);
    const int picture = scene.clip.picture[keyframes[i].frame];
    const auto row = std::lower_bound(frames.begin(), frames.end(), picture) - frames.begin();
    track.weights.row(i) = weights.row(row);
  }
  return track;
}

std::string Bytes(const Scene& scene, const GlbTextures& textures, const FewShapes& shapes,
                  const GlbWeights& track) {
  GlbBuilder builder(scene.split, scene.name);
  builder.Base(shapes.base);
  std::vector<double> first_weights;
  for (int k = 0; k < SizeOf(shapes.differences); ++k) {
    builder.Target("shape_" + std::to_string(k + 1), shapes.differences[k]);
    first_weights.push_back(shapes.weights(0, k));
  }
  return builder.Finish(first_weights, textures, track);
}

}  // namespace

std::vector<std::string> FewTargetsOptions::Problems() const {
  std::vector<std::string> problems;
  if (max_targets < 1 || max_targets > 255)
    problems.push_back("max_targets is " + std::to_string(max_targets) +
                       ", but must be from 1 to 255");
  if (!(error_bound > 0))
    problems.push_back("error_bound is " + std::to_string(error_bound) + ", but must be above 0");
  return problems;
}

FormatFiles MakeFewTargetsGlb(const Scene& scene, const GlbTextures& textures,
                              const FewTargetsOptions& options, Progress* progress) {
  for (const std::string& problem : options.Problems()) throw UsageError("export: " + problem);
  const std::vector<int> frames = PictureFrames(scene.clip);
  MorphFit fit{{scene.frames[0].points, {}, Eigen::MatrixXd::Zero(std::ssize(frames), 0)}};
  const double diagonal = SceneDiagonal(scene);
  if (frames.size() > 1) {
    Pictures pictures;
    for (const int frame : frames) pictures.push_back(&scene.frames[frame].points);
    const double bound = std::max(options.error_bound - kRounding, kRounding) * diagonal;
    SubProgress part(progress, 0, 0.9);
    fit = FitMorphBasis(pictures, options.max_targets, bound, &part);
  }
  const bool from_first = MakeUnitWeights(fit.basis, kLargestTarget * diagonal);
  ReportProgress(progress, 0.9, "writing the GLB with few targets");
  const FewShapes shapes = InSinglePrecision(fit.basis, scene);
  FormatFiles out;
  out.files.push_back({options.file, Bytes(scene, textures, shapes,
                                           WeightsOverTime(scene, frames, shapes.weights))});
  Measure(shapes, scene, frames, out);
  out.measured["morph_targets"] = SizeOf(shapes.differences);
  out.measured["error_bound"] = options.error_bound;
  out.measured["picture_targets_error_over_diagonal"] =
      diagonal > 0 ? fit.error_of_pictures / diagonal : 0;
  out.measured["base_is_first_frame"] = from_first ? 1 : 0;
  return out;
}

}  // namespace keypose::exporting
