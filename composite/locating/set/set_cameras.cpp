#include "composite/locating/set/set_cameras.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/numbers/rotations.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::composite {
namespace {

// Chosen on the clay creature's film of seed 1 (synth) with a camera that swings and draws nearer.
struct SetCamerasTuning {
  KEYPOSE_TUNED(int, kLeastPlaces, 40);
  KEYPOSE_TUNED(int, kLeastOnTable, 15);
  KEYPOSE_TUNED(int, kLeastSightings, 3);
  KEYPOSE_TUNED(int, kRounds, 12);         // over all pictures, at the end
  KEYPOSE_TUNED(int, kRoundsAPicture, 2);  // over all so far
  KEYPOSE_TUNED(int, kStepsAPicture, 12);  // of a new picture alone
  KEYPOSE_TUNED(double, kGrowth, 1.25);    // of the pictures, until all are solved together again
  // Sightings farther off than this hardly count [px of a picture of 960].
  KEYPOSE_TUNED(double, kNewReach, 24);
  KEYPOSE_TUNED(double, kFirstReach, 6);
  KEYPOSE_TUNED(double, kLastReach, 1.5);
  // How even the table is, how far beside it a place hardly counts as lying on it, and how far from
  // the character that is asked at all [the camera's distance to the character].
  KEYPOSE_TUNED(double, kTableDeviation, 0.006);
  KEYPOSE_TUNED(double, kTableReach, 0.02);
  KEYPOSE_TUNED(double, kTableNear, 0.5);
  // Errors of neighbouring places are alike, and so are those of one place in consecutive pictures:
  // this share of the sightings counts.
  KEYPOSE_TUNED(double, kIndependent, 1 / 25.0);
  KEYPOSE_TUNED(double, kDamping, 1e-4);
};

constexpr double kUsualSide = 960;  // px
constexpr double kCameraDamping = 1e-8;
constexpr double kLongestTurn = 0.1, kLongestFocalStep = 0.05;
constexpr double kFarthest = 30, kUsual = 2;  // a place's depth [the same distance]
constexpr int kPlace = 6;

using StepVector = keypose::composite::Step;
using PlaceJacobian = Eigen::Matrix<double, 2, kPlace>;
using Matrix23 = Eigen::Matrix<double, 2, 3>;
using Vector6 = Eigen::Matrix<double, kPlace, 1>;
using Matrix63 = Eigen::Matrix<double, kPlace, 3>;

/// A place of the set. It moves along the ray of one picture by one over its depth, so that a place
/// that is far away, or whose depth no picture shows yet, stays well behaved.
struct SetPlace {
  const SetTrack* track = nullptr;
  Eigen::Vector3d position;  // in world
};

/// The derivatives of one sighting's pixel, in the direction in which it is known best; the other
/// direction is shortened as it is known worse.
struct SightingTerms {
  PlaceJacobian by_camera;
  Eigen::Vector2d by_focal;  // its logarithm
  Matrix23 by_place;         // in world
  Eigen::Vector2d off;
  double information = 0;  // of the better direction [1/px^2]
  bool in_front = false;
};

/// Of the cameras and the focal length: six rows for each picture, then one.
struct CameraEquations {
  Eigen::MatrixXd h;
  Eigen::VectorXd g;
};

/// One place's part in the cameras' equations, with which its own step is found afterwards.
struct Eliminated {
  Eigen::Matrix3d inverse;
  Eigen::Vector3d g = Eigen::Vector3d::Zero();
  std::vector<std::pair<int, Matrix63>> cameras;  // first row, product with the place
  Eigen::RowVector3d focal = Eigen::RowVector3d::Zero();
};

/// Geman and McClure's weight: falls with the fourth power of the distance.
double Robust(double squared, double reach) {
  const double s2 = reach * reach, robust = s2 / (s2 + squared);
  return robust * robust;
}

Eigen::Matrix3d Damped(Eigen::Matrix3d h) {
  h.diagonal() *= 1 + SetCamerasTuning::kDamping;
  h.diagonal().array() += 1e-12;
  return h;
}

class SetSolver {
 public:
  explicit SetSolver(const SetCameraInput& input)
      : input_(input),
        distance_((input.first.camera_from_mesh * input.center).norm()),
        size_(std::max(input.first.camera.width, input.first.camera.height) / kUsualSide),
        cameras_{input.first} {}

  std::optional<SetCameras> Solve() {
    AddPlaces();
    while (SizeOf(cameras_) < input_.pictures) {
      reach_ = SetCamerasTuning::kFirstReach * size_;
      AddPicture();
      AddPlaces();
      RefineSeen();
      if (count() < next_joint_) continue;
      next_joint_ = std::max(count() + 1, static_cast<int>(SetCamerasTuning::kGrowth * count()));
      for (int round = 0; round < SetCamerasTuning::kRoundsAPicture; ++round)
        if (!Step()) return {};
    }
    for (int round = 0; round < SetCamerasTuning::kRounds; ++round) {
      const double t = std::min(1.0, 1.5 * round / (SetCamerasTuning::kRounds - 1));
      reach_ = size_ * SetCamerasTuning::kFirstReach *
               std::pow(SetCamerasTuning::kLastReach / SetCamerasTuning::kFirstReach, t);
      if (!Step()) return {};
    }
    return Result();
  }

 private:
  int count() const { return SizeOf(cameras_); }
  int focal_row() const { return kPlace * count(); }
  bool IsHere(const SetSighting& sighting) const { return sighting.picture < count(); }

  SightingTerms TermsOf(const SetSighting& sighting, const Eigen::Vector3d& position) const {
    const Placement& at = cameras_[sighting.picture];
    const Eigen::Matrix3d turn = at.camera_from_mesh.rotation.toRotationMatrix();
    const Eigen::Vector3d x = turn * position + at.camera_from_mesh.translation;
    SightingTerms terms;
    terms.in_front = x.z() > 1e-3 * distance_;
    if (!terms.in_front) return terms;
    const PixelDerivatives d = DerivativesAt(at.camera, x);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> known(sighting.information);
    terms.information = known.eigenvalues()[1];
    const Eigen::Matrix2d by_pixel =
        (known.eigenvalues() / terms.information).cwiseMax(0).cwiseSqrt().asDiagonal() *
        known.eigenvectors().transpose();
    const Matrix23 by_point = by_pixel * d.by_point;
    terms.by_camera.leftCols<3>() = -by_point * CrossOf(x - at.camera_from_mesh * input_.center);
    terms.by_camera.rightCols<3>() = input_.radius * by_point;
    terms.by_focal = by_pixel * d.by_log_focal;
    terms.by_place = by_point * turn;
    terms.off = by_pixel * (sighting.pixel - at.camera.Project(x));
    return terms;
  }
  double WeightOf(const SightingTerms& terms) const {
    return SetCamerasTuning::kIndependent * Robust(terms.off.squaredNorm(), reach_) *
           terms.information;
  }

  const Rigid3& AnchorOf(const SetPlace& place) const {
    return cameras_[place.track->front().picture].camera_from_mesh;
  }
  /// The place's derivatives by its ray's two coordinates at depth 1, and by one over the depth.
  Eigen::Matrix3d RayFrame(const SetPlace& place) const {
    const Rigid3& pose = AnchorOf(place);
    const Eigen::Vector3d x = pose * place.position;
    Eigen::Matrix3d frame = Eigen::Matrix3d::Identity() * x.z();
    frame.col(2) = -x * x.z();
    return pose.rotation.toRotationMatrix().transpose() * frame;
  }
  void MovePlace(SetPlace& place, const Eigen::Vector3d& step, const Rigid3& anchor) const {
    const Eigen::Vector3d x = anchor * place.position;
    const double near = 1 / x.z();
    const double rho =
        std::max(std::clamp(near + step.z(), 0.3 * near, 3 * near), 1 / (kFarthest * distance_));
    const Eigen::Vector3d ray(x.x() / x.z() + step.x(), x.y() / x.z() + step.y(), 1);
    if (ray.allFinite() && std::isfinite(rho)) place.position = anchor.Inverse() * (ray / rho);
  }

  /// A first guess: on the table, where the ray meets it near enough.
  Eigen::Vector3d GuessOf(const SetSighting& sighting) const {
    const Placement& at = cameras_[sighting.picture];
    const Rigid3 back = at.camera_from_mesh.Inverse();
    const Eigen::Vector3d ray = back.rotation * at.camera.Unproject(sighting.pixel);
    const double down = (input_.table_height - back.translation.z()) / ray.z();
    const bool met = down > 0 && down < 2 * kUsual * distance_;
    return back.translation + (met ? down : kUsual * distance_) * ray;
  }
  /// Those that the newest picture shows first.
  void AddPlaces() {
    for (const SetTrack& track : input_.tracks)
      if (track.front().picture == count() - 1 &&
          SizeOf(track) >= SetCamerasTuning::kLeastSightings)
        places_.push_back({&track, GuessOf(track.front())});
  }

  /// The next picture's camera by the places that are known, from the camera before.
  void AddPicture() {
    cameras_.push_back(cameras_.back());
    for (int i = 0; i < SetCamerasTuning::kStepsAPicture; ++i) {
      const double reach = size_ * std::max(SetCamerasTuning::kNewReach * std::pow(0.8, i),
                                            SetCamerasTuning::kFirstReach);
      Eigen::Matrix<double, kPlace, kPlace> h = Eigen::Matrix<double, kPlace, kPlace>::Zero();
      Eigen::Matrix<double, kPlace, 1> g = Eigen::Matrix<double, kPlace, 1>::Zero();
      for (const SetPlace& place : places_)
        for (const SetSighting& sighting : *place.track) {
          if (sighting.picture != count() - 1) continue;
          const SightingTerms terms = TermsOf(sighting, place.position);
          if (!terms.in_front) continue;
          const double weight = Robust(terms.off.squaredNorm(), reach) * terms.information;
          h += weight * terms.by_camera.transpose() * terms.by_camera;
          g += weight * terms.by_camera.transpose() * terms.off;
        }
      h.diagonal() *= 1 + SetCamerasTuning::kDamping;
      h.diagonal().array() += 1e-9 * (1 + h.trace());
      StepVector step = StepVector::Zero();
      step.head<kPlace>() = h.ldlt().solve(g);
      if (!step.allFinite()) return;
      step *= std::min(1.0, kLongestTurn / std::max(step.norm(), 1e-300));
      cameras_.back() = NormalEquations(cameras_.back(), input_.center, input_.radius).Moved(step);
    }
  }

  bool IsNear(const SetPlace& place) const {
    return (place.position - input_.center).head<2>().norm() <
           SetCamerasTuning::kTableNear * distance_;
  }
  /// The table's own equation for a place: how high it lies above it.
  template <class Add>
  void WithTable(const SetPlace& place, const Eigen::Matrix3d& frame, const Add& add) const {
    if (!IsNear(place)) return;
    const double deviation = SetCamerasTuning::kTableDeviation * distance_,
                 reach = SetCamerasTuning::kTableReach * distance_;
    const double off = input_.table_height - place.position.z();
    const double weight =
        SetCamerasTuning::kIndependent * Robust(off * off, reach) / (deviation * deviation);
    const Eigen::RowVector3d j = frame.row(2);
    add(Eigen::Matrix3d(weight * j.transpose() * j), Eigen::Vector3d(weight * off * j.transpose()));
  }

  /// Those that the newest picture shows.
  void RefineSeen() {
    for (SetPlace& place : places_)
      if (place.track->back().picture >= count() - 1) RefinePlace(place);
  }

  void RefinePlace(SetPlace& place) const {
    const Eigen::Matrix3d frame = RayFrame(place);
    Eigen::Matrix3d h = Eigen::Matrix3d::Zero();
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    for (const SetSighting& sighting : *place.track) {
      if (!IsHere(sighting)) break;
      const SightingTerms terms = TermsOf(sighting, place.position);
      if (!terms.in_front) continue;
      const double weight = WeightOf(terms);
      const Matrix23 j = terms.by_place * frame;
      h += weight * j.transpose() * j;
      g += weight * j.transpose() * terms.off;
    }
    WithTable(place, frame, [&](const auto& of_h, const auto& of_g) {
      h += of_h;
      g += of_g;
    });
    MovePlace(place, Damped(h).ldlt().solve(g), AnchorOf(place));
  }

  /// From `first` to where that camera is now.
  StepVector WayOfFirst() const {
    const Placement &from = input_.first, &to = cameras_[0];
    StepVector way = StepVector::Zero();
    way.head<3>() =
        LogOf(to.camera_from_mesh.rotation * from.camera_from_mesh.rotation.conjugate());
    way.segment<3>(3) =
        (to.camera_from_mesh * input_.center - from.camera_from_mesh * input_.center) /
        input_.radius;
    way[kLogFocal] = std::log(to.camera.fx / from.camera.fx);
    return way;
  }

  void AddCharacter(CameraEquations& all) const {
    const StepVector way = WayOfFirst();
    const double weight = input_.character_weight;
    const StepMatrix m = weight * input_.character.matrix();
    const StepVector r = weight * input_.character.gradient() - m * way;
    const int focal = focal_row();
    all.h.topLeftCorner<kPlace, kPlace>() += m.topLeftCorner<kPlace, kPlace>();
    all.h.block<kPlace, 1>(0, focal) += m.block<kPlace, 1>(0, kLogFocal);
    all.h.block<1, kPlace>(focal, 0) += m.block<1, kPlace>(kLogFocal, 0);
    all.h(focal, focal) += m(kLogFocal, kLogFocal) + input_.focal_information;
    all.g.head<kPlace>() += r.head<kPlace>();
    all.g[focal] +=
        r[kLogFocal] + input_.focal_gradient - input_.focal_information * way[kLogFocal];
  }

  Eliminated AddPlace(const SetPlace& place, CameraEquations& all) const {
    const int focal = focal_row();
    const Eigen::Matrix3d frame = RayFrame(place);
    Eigen::Matrix3d own = Eigen::Matrix3d::Zero();
    Eliminated part;
    for (const SetSighting& sighting : *place.track) {
      if (!IsHere(sighting)) break;
      const SightingTerms terms = TermsOf(sighting, place.position);
      if (!terms.in_front) continue;
      const double weight = WeightOf(terms);
      const int at = kPlace * sighting.picture;
      const Matrix23 j = terms.by_place * frame;
      const PlaceJacobian& c = terms.by_camera;
      const Eigen::Vector2d& f = terms.by_focal;
      const Vector6 cross = weight * c.transpose() * f;
      all.h.block<kPlace, kPlace>(at, at) += weight * c.transpose() * c;
      all.h.block<kPlace, 1>(at, focal) += cross;
      all.h.block<1, kPlace>(focal, at) += cross.transpose();
      all.h(focal, focal) += weight * f.squaredNorm();
      all.g.segment<kPlace>(at) += weight * c.transpose() * terms.off;
      all.g[focal] += weight * f.dot(terms.off);
      own += weight * j.transpose() * j;
      part.g += weight * j.transpose() * terms.off;
      part.cameras.push_back({at, weight * c.transpose() * j});
      part.focal += weight * f.transpose() * j;
    }
    WithTable(place, frame, [&](const auto& h, const auto& g) {
      own += h;
      part.g += g;
    });
    part.inverse = Damped(own).inverse();
    Eliminate(part, all);
    return part;
  }

  void Eliminate(const Eliminated& part, CameraEquations& all) const {
    const int focal = focal_row();
    for (const auto& [a, of_a] : part.cameras) {
      const Matrix63 left = of_a * part.inverse;
      for (const auto& [b, of_b] : part.cameras)
        all.h.block<kPlace, kPlace>(a, b) -= left * of_b.transpose();
      const Vector6 cross = left * part.focal.transpose();
      all.h.block<kPlace, 1>(a, focal) -= cross;
      all.h.block<1, kPlace>(focal, a) -= cross.transpose();
      all.g.segment<kPlace>(a) -= left * part.g;
    }
    all.h(focal, focal) -= part.focal * part.inverse * part.focal.transpose();
    all.g[focal] -= part.focal * part.inverse * part.g;
  }

  void FixUnknowns(CameraEquations& all) const {
    if (const int row = focal_row(); !input_.focal_free) {
      all.h.row(row).setZero();
      all.h.col(row).setZero();
      all.h(row, row) = 1;
      all.g[row] = 0;
    }
    // A picture that says nothing stays where it is.
    for (Eigen::Index i = 0; i < all.h.rows(); ++i)
      if (all.h(i, i) <= 0) all.h(i, i) = 1;
  }

  bool Step() {
    const int size = focal_row() + 1;
    CameraEquations all{Eigen::MatrixXd::Zero(size, size), Eigen::VectorXd::Zero(size)};
    AddCharacter(all);
    std::vector<Eliminated> parts;
    for (const SetPlace& place : places_) parts.push_back(AddPlace(place, all));
    FixUnknowns(all);
    // Columns are scaled to one: pixels are moved much by some unknowns and little by others.
    const Eigen::VectorXd scale = all.h.diagonal().cwiseSqrt().cwiseInverse();
    Eigen::MatrixXd scaled = scale.asDiagonal() * all.h * scale.asDiagonal();
    scaled.diagonal().array() += kCameraDamping;
    const Eigen::VectorXd right = scale.cwiseProduct(all.g);
    Eigen::VectorXd step = scale.cwiseProduct(Eigen::VectorXd(scaled.ldlt().solve(right)));
    if (!step.allFinite()) return false;
    const double factor = FactorOf(step);
    step *= factor;
    MovePlaces(parts, step, factor);
    for (int i = 0; i < count(); ++i) {
      StepVector own = StepVector::Zero();
      own.head<kPlace>() = step.segment<kPlace>(kPlace * i);
      own[kLogFocal] = step[focal_row()];
      cameras_[i] = NormalEquations(cameras_[i], input_.center, input_.radius).Moved(own);
    }
    for (SetPlace& place : places_) RefinePlace(place);
    equations_ = std::move(all);
    return true;
  }

  /// One for all, or the pictures would end with different lenses.
  double FactorOf(const Eigen::VectorXd& step) const {
    double factor =
        std::min(1.0, kLongestFocalStep / std::max(std::abs(step[focal_row()]), 1e-300));
    for (int i = 0; i < count(); ++i)
      factor = std::min(factor,
                        kLongestTurn / std::max(step.segment<kPlace>(kPlace * i).norm(), 1e-300));
    return factor;
  }

  void MovePlaces(const std::vector<Eliminated>& parts, const Eigen::VectorXd& step,
                  double factor) {
    for (int p = 0; p < SizeOf(places_); ++p) {
      const Eliminated& part = parts[p];
      Eigen::Vector3d right = factor * part.g - part.focal.transpose() * step[focal_row()];
      for (const auto& [at, of] : part.cameras) right -= of.transpose() * step.segment<kPlace>(at);
      MovePlace(places_[p], part.inverse * right, AnchorOf(places_[p]));
    }
  }

  bool Agrees(const SightingTerms& terms) const {
    return terms.in_front && terms.off.norm() <= 2 * SetCamerasTuning::kLastReach * size_;
  }

  std::optional<SetCameras> Result() const {
    SetCameras result;
    result.cameras = cameras_;
    result.seen.assign(cameras_.size(), 0);
    double sum = 0, weighted = 0;
    int sightings = 0;
    for (const SetPlace& place : places_) {
      const auto agrees = [&](const SetSighting& s) { return Agrees(TermsOf(s, place.position)); };
      if (std::count_if(place.track->begin(), place.track->end(), agrees) <
          SetCamerasTuning::kLeastSightings)
        continue;
      ++result.places;
      const double height = std::abs(place.position.z() - input_.table_height);
      result.on_table += IsNear(place) && height < SetCamerasTuning::kTableReach * distance_;
      for (const SetSighting& sighting : *place.track) {
        const SightingTerms terms = TermsOf(sighting, place.position);
        if (!Agrees(terms)) continue;
        sum += terms.off.squaredNorm();
        weighted += terms.information * terms.off.squaredNorm();
        ++sightings;
        ++result.seen[sighting.picture];
      }
    }
    if (result.places < SetCamerasTuning::kLeastPlaces ||
        result.on_table < SetCamerasTuning::kLeastOnTable)
      return {};
    result.rms_px = std::sqrt(sum / sightings);
    // Each sighting has two coordinates, of which each should have a square of 1 here.
    if (input_.focal_free)
      result.focal_deviation = FocalDeviation(std::sqrt(std::max(1.0, weighted / (2 * sightings))));
    return result;
  }

  double FocalDeviation(double noise) const {
    Eigen::VectorXd unit = Eigen::VectorXd::Zero(focal_row() + 1);
    unit[focal_row()] = 1;
    const double variance = equations_.h.ldlt().solve(unit)[focal_row()];
    return variance > 0 ? noise * std::sqrt(variance) : 1;
  }

  const SetCameraInput& input_;
  double distance_;  // of the first camera to the character
  double size_;      // of a picture, over kUsualSide
  std::vector<Placement> cameras_;
  std::vector<SetPlace> places_;
  double reach_ = SetCamerasTuning::kFirstReach;
  int next_joint_ = 2;  // so many pictures are solved together next
  CameraEquations equations_;
};

}  // namespace

std::optional<SetCameras> SolveSetCameras(const SetCameraInput& input) {
  if (input.pictures < 2) return {};
  return SetSolver(input).Solve();
}

}  // namespace keypose::composite
