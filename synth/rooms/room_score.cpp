#include "synth/rooms/room_score.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/pictures/image_turns.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/angles.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "synth/scores/score.h"

namespace keypose::synth {
namespace {

using Eigen::Vector3d;

constexpr double kWrongTurn = 2 * kDegree, kWrongPlace = 0.05;  // of the distance
constexpr double kFoot = 0.125;                                 // share of the height
constexpr int kSamples = 40000;

/// A camera that truth and model both have. The true one is turned as the model's picture is:
/// `capture` turns portraits by a quarter where most photographs lie.
struct Pair {
  View truth;
  const View* model;
};

bool LiesAcross(int width, int height, int other_width, int other_height) {
  return (width > height) != (other_width > other_height);
}

/// The camera whose picture is rotated by 90 degrees, clockwise, if that has the model's shape.
View TurnedAs(const View& model, View truth) {
  const Camera &from = truth.camera, &to = model.camera;
  if (!LiesAcross(from.width, from.height, to.width, to.height)) return truth;
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(kPi / 2, Vector3d::UnitZ()));
  Rigid3& pose = truth.camera_from_world;
  pose = {turn * pose.rotation, turn * pose.translation};
  return truth;
}

std::vector<Pair> PairsOf(const Scene& truth, const Scene& model,
                          std::vector<std::string>* missing) {
  std::map<std::string, const View*> by_name;
  for (const View& view : model.views) by_name[view.name] = &view;
  std::vector<Pair> pairs;
  for (const View& view : truth.views) {
    const auto found = by_name.find(view.name);
    if (found != by_name.end())
      pairs.push_back({TurnedAs(*found->second, view), found->second});
    else if (missing)
      missing->push_back(view.name);
  }
  return pairs;
}

Eigen::Matrix3d TurnOf(const Pair& pair) {
  return (pair.truth.camera_from_world.rotation.conjugate() *
          pair.model->camera_from_world.rotation)
      .toRotationMatrix();
}

double AngleBetween(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return Eigen::AngleAxisd(a.transpose() * b).angle();
}

/// Errors of one camera under an alignment: turn [rad], place as a share of the distance.
std::pair<double, double> ErrorsOf(const Pair& pair, const Similarity3& truth_from_model,
                                   const Vector3d& center) {
  const Vector3d place = truth_from_model * pair.model->Center(), truth = pair.truth.Center();
  return {AngleBetween(truth_from_model.rotation, TurnOf(pair)),
          (place - truth).norm() / (truth - center).norm()};
}

bool IsRight(const std::pair<double, double>& errors) {
  return errors.first <= kWrongTurn && errors.second <= kWrongPlace;
}

int CountRight(const std::vector<Pair>& pairs, const Similarity3& alignment,
               const Vector3d& center) {
  return static_cast<int>(std::count_if(pairs.begin(), pairs.end(), [&](const Pair& pair) {
    return IsRight(ErrorsOf(pair, alignment, center));
  }));
}

/// The similarity that maps one camera's turn and place, and the distance to another one.
bool FromTwo(const Pair& a, const Pair& b, Similarity3* alignment) {
  const double in_truth = (b.truth.Center() - a.truth.Center()).norm(),
               in_model = (b.model->Center() - a.model->Center()).norm();
  if (!(in_model > 1e-9) || !(in_truth > 1e-6)) return false;
  alignment->scale = in_truth / in_model;
  alignment->rotation = TurnOf(a);
  alignment->translation =
      a.truth.Center() - alignment->scale * (alignment->rotation * a.model->Center());
  return true;
}

/// Fits to all cameras that are right so far; keeps the fit where as many are right then.
void Refine(const std::vector<Pair>& pairs, const Vector3d& center, Similarity3* alignment) {
  for (int round = 0; round < 5; ++round) {
    std::vector<const Pair*> right;
    for (const Pair& pair : pairs)
      if (IsRight(ErrorsOf(pair, *alignment, center))) right.push_back(&pair);
    if (right.size() < 4) return;
    PointsX3 a(std::ssize(right), 3), b(std::ssize(right), 3);
    for (Eigen::Index i = 0; i < a.rows(); ++i) {
      a.row(i) = right[i]->model->Center();
      b.row(i) = right[i]->truth.Center();
    }
    const Similarity3 fitted = FitSimilarity(a, b);
    if (CountRight(pairs, fitted, center) < SizeOf(right)) return;
    *alignment = fitted;
  }
}

/// Faces above the foot and near the truth.
Mesh WithoutFoot(const Mesh& mesh, const Mesh& truth, const Similarity3& truth_from_mesh) {
  const RayScene scene(truth.points, truth.faces);
  const double foot = 2 * kFoot * truth.points.col(2).maxCoeff(),
               near = 0.05 * BoundingDiagonal(truth.points);
  const PointsX3 placed = Transformed(truth_from_mesh, mesh.points);
  std::vector<char> keep(static_cast<std::size_t>(placed.rows()), 0);
  ParallelFor(
      placed.rows(),
      [&](std::int64_t i) {
        keep[i] = placed(i, 2) > foot && scene.ClosestPoint(placed.row(i), near).face >= 0;
      },
      256);
  Mesh part = mesh;
  Eigen::Index kept = 0;
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
    if (keep[mesh.faces(f, 0)] && keep[mesh.faces(f, 1)] && keep[mesh.faces(f, 2)])
      part.faces.row(kept++) = mesh.faces.row(f);
  part.faces.conservativeResize(kept, 3);
  return part;
}

/// Distance of each point outside the truth; 0 inside. Outside is where the closest face looks at
/// the point.
std::vector<double> Outside(const PointsX3& points, const RayScene& scene,
                            const PointsX3& face_normals) {
  std::vector<double> outside(static_cast<std::size_t>(points.rows()), 0);
  ParallelFor(
      points.rows(),
      [&](std::int64_t i) {
        const Vector3d p = points.row(i);
        const RayScene::Foot foot = scene.ClosestPoint(p);
        if (Vector3d(face_normals.row(foot.face)).dot(p - foot.point) > 0)
          outside[i] = std::sqrt(foot.squared_distance);
      },
      256);
  return outside;
}

}  // namespace

RoomCameraScore ScoreRoomCameras(const Scene& truth, const Scene& model, const Vector3d& center) {
  RoomCameraScore score;
  const std::vector<Pair> pairs = PairsOf(truth, model, &score.missing);
  score.total = SizeOf(truth.views);
  score.placed = SizeOf(pairs);
  int most = 0;
  for (const Pair& a : pairs)
    for (const Pair& b : pairs) {
      Similarity3 alignment;
      if (&a == &b || !FromTwo(a, b, &alignment)) continue;
      const int right = CountRight(pairs, alignment, center);
      if (right > most) {
        most = right;
        score.truth_from_model = alignment;
      }
    }
  Refine(pairs, center, &score.truth_from_model);
  std::vector<double> turns, places;
  for (const Pair& pair : pairs) {
    const auto errors = ErrorsOf(pair, score.truth_from_model, center);
    if (!IsRight(errors)) {
      score.wrong.push_back(pair.truth.name);
      continue;
    }
    turns.push_back(errors.first / kDegree);
    places.push_back(errors.second);
  }
  score.median_deg = UpperMedian(turns);
  score.median_over_distance = UpperMedian(places);
  return score;
}

int AgreeingTurns(const Scene& truth, const Scene& model) {
  const std::vector<Pair> pairs = PairsOf(truth, model, nullptr);
  std::vector<Eigen::Matrix3d> turns;
  for (const Pair& pair : pairs) turns.push_back(TurnOf(pair));
  int most = 0;
  for (const Eigen::Matrix3d& common : turns)
    most = std::max(most, static_cast<int>(std::count_if(
                              turns.begin(), turns.end(), [&](const Eigen::Matrix3d& turn) {
                                return AngleBetween(common, turn) <= kWrongTurn;
                              })));
  return most;
}

double MaskOverlap(const Image8& truth, const Image8& mask) {
  if (LiesAcross(truth.width, truth.height, mask.width, mask.height))
    return MaskOverlap(QuarterTurned(truth), mask);
  const double shape = static_cast<double>(mask.width) * truth.height /
                       (static_cast<double>(mask.height) * truth.width);
  if (std::abs(shape - 1) > 0.02)
    throw InputError("synth: a mask of " + std::to_string(mask.width) + " x " +
                     std::to_string(mask.height) + " pixels has another shape than its photograph");
  std::int64_t both = 0, either = 0;
  for (int y = 0; y < truth.height; ++y)
    for (int x = 0; x < truth.width; ++x) {
      const bool is = *truth.at(x, y) > 127;
      const bool said = *mask.at((2 * x + 1) * mask.width / (2 * truth.width),
                                 (2 * y + 1) * mask.height / (2 * truth.height)) > 127;
      both += is && said;
      either += is || said;
    }
  return either == 0 ? 1 : static_cast<double>(both) / static_cast<double>(either);
}

BaseScore ScoreBase(const Mesh& truth, const Mesh& mesh, const Similarity3& truth_from_model) {
  const Mesh upper = WithoutFoot(mesh, truth, truth_from_model);
  const Similarity3 alignment =
      upper.faces.rows() > 100 ? RefineAlignment(truth, upper, truth_from_model) : truth_from_model;
  const double diagonal = BoundingDiagonal(truth.points);
  const PointsX3 placed = Transformed(alignment, mesh.points);
  const PointsX3 samples = SampleSurface(placed, mesh.faces, kSamples, 3).points;
  const RayScene scene(truth.points, truth.faces);
  const std::vector<double> outside =
      Outside(samples, scene, FaceNormals(truth.points, truth.faces));
  const double foot = kFoot * truth.points.col(2).maxCoeff();
  std::vector<double> beside;
  double sum = 0;
  for (Eigen::Index i = 0; i < samples.rows(); ++i) {
    sum += std::sqrt(scene.ClosestPoint(samples.row(i)).squared_distance);
    if (samples(i, 2) < foot) beside.push_back(outside[i] / diagonal);
  }
  BaseScore score;
  score.below = std::max(0.0, -placed.col(2).minCoeff()) / diagonal;
  score.beside = QuantileFloor(beside, 0.99);
  score.anywhere = QuantileFloor(outside, 0.99) / diagonal;
  score.mean_to_truth = sum / static_cast<double>(samples.rows()) / diagonal;
  const RayScene made(placed, mesh.faces);
  const PointsX3 of_truth = SampleSurface(truth.points, truth.faces, kSamples, 4).points;
  std::vector<double> gaps(static_cast<std::size_t>(of_truth.rows()));
  ParallelFor(
      of_truth.rows(),
      [&](std::int64_t i) {
        gaps[i] = std::sqrt(made.ClosestPoint(of_truth.row(i)).squared_distance) / diagonal;
      },
      256);
  score.missing = QuantileFloor(gaps, 0.99);
  return score;
}

}  // namespace keypose::synth
