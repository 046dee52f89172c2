#include "interpolate/volume/volumetric.h"

#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "core/numbers/cholesky.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "core/values/tuned.h"
#include "interpolate/maps/face_maps.h"
#include "interpolate/maps/key_pair.h"
#include "interpolate/volume/body_volumes.h"
#include "interpolate/volume/graph_turns.h"
#include "interpolate/volume/key_choice.h"
#include "interpolate/volume/place_inside.h"
#include "interpolate/volume/tet_maps.h"
#include "interpolate/volume/tet_paths.h"
#include "interpolate/volume/tetrahedralize.h"

namespace keypose::interpolation {

namespace {

// Chosen on the twisted bars (docs/results/interpolation.md); sensitivity:
// docs/results/sensitivity.md.
struct VolumetricTuning {
  // largest weight of the second key's energy over the first's, for flattened tetrahedra
  KEYPOSE_TUNED(double, kStiffest, 1e4);
  // of a tetrahedron's volume in the smoothed shape: with less it counts as inverted
  KEYPOSE_TUNED(double, kCrossed, 0.02);
  // of the volume: the least share of the body to which other turns are relative
  KEYPOSE_TUNED(double, kRigidShare, 0.25);
  // of volume over area, half a limb's radius: how far regions and the volume correction spread
  KEYPOSE_TUNED(double, kReach, 4);
};

/// Makes rotations relative to the mean rotation around one of them.
/// @return that mean
Eigen::Matrix3d TurnAgainst(int body, const std::vector<double>& weights,
                            std::vector<Eigen::Matrix3d>& rotations) {
  const Eigen::Matrix3d mean = MeanAround(body, rotations, weights);
  for (Eigen::Matrix3d& rotation : rotations) rotation = mean.transpose() * rotation;
  return mean;
}

/// Everything between the filled key and the other one.
class FilledKey {
 public:
  FilledKey(const PointsX3& from, const PointsX3& to, const FacesX3& faces,
            const std::string& from_name, const std::string& to_name,
            const VolumetricOptions& options, bool part_crossings)
      : from_(from),
        to_(to),
        faces_(faces),
        options_(options),
        solid_(Tetrahedralize(from, faces, from_name,
                              {options.element_size, options.max_tetrahedra, part_crossings})),
        shapes_(TetShapesOf(solid_.points, solid_.tets)) {
    start_volumes_ = BodyVolumes(from_, faces_, solid_);
    end_volumes_ = BodyVolumes(to_, faces_, solid_);
    for (int b = 0; b < solid_.bodies; ++b)
      if (!(end_volumes_[b] > 0))
        throw InputError(to_name + ": body " + std::to_string(b) +
                         " is inside out or has no volume there, though it has in the other key; "
                         "register it again");
    const PointsX3 end = PlaceInside(solid_, shapes_, faces_, to_);
    if (solid_.parted > 0) ReturnParted();
    maps_ = TetMapsOf(shapes_, end, solid_.tets);
    for (std::size_t t = 0; t < crossed_.size(); ++t)
      if (crossed_[t]) maps_[t].inverted = true;
    inverted_ = static_cast<int>(
        std::count_if(maps_.begin(), maps_.end(), [](const TetMap& m) { return m.inverted; }));
  }

  int inverted() const { return inverted_; }

  /// Computes what only the chosen key needs.
  void Prepare() {
    Lift();
    Factor();
    MakePaths();
    sums_.emplace(solid_.points.rows(), solid_.tets);
    paths_.emplace(from_, to_, solid_, body_turn_);
  }

  std::vector<PointsX3> At(const std::vector<double>& times) const;
  VolumetricReport Report() const;

 private:
  void ReturnParted();
  void Lift();
  void ChooseBodyTurn(const std::vector<Eigen::Vector3d>& turns);
  Eigen::Matrix3d WeightOf(std::int64_t t) const;
  void Factor();
  void MakePaths();
  void KeepVolumes(const std::vector<double>& times, std::vector<PointsX3>& frames) const;
  PointsX3 VolumeGradient(const PointsX3& points) const;

  PointsX3 from_, to_;
  FacesX3 faces_;
  VolumetricOptions options_;
  Solid solid_;
  std::vector<TetShape> shapes_;
  Eigen::VectorXd start_volumes_, end_volumes_;
  std::vector<TetMap> maps_;
  int inverted_ = 0;
  std::vector<char> crossed_;  // tetrahedra that are inverted in the filled key itself; empty when
                               // no crossing was removed
  std::vector<Eigen::Matrix3d> starts_;  // their maps from the smoothed shape to that key
  Eigen::Vector3d body_turn_ = Eigen::Vector3d::Zero();
  double largest_turn_ = 0, largest_tear_ = 0;
  std::vector<Eigen::Matrix3d> rotations_;  // relative to the body's
  std::vector<Eigen::Vector3d> turns_;      // of rotations_, made consistent
  std::vector<TetPath> paths_of_tets_;
  std::vector<Eigen::Matrix<double, 3, 4>> corners_;  // weighted gradients
  std::optional<CornerSums> sums_;
  std::optional<BodyPaths> paths_;
  SparseCholesky fit_, spread_;
};

// The solid was made from a surface with its crossings smoothed away. Its points move back to the
// key. Tetrahedra that are inverted there keep the smoothed shape as their reference and are
// interpolated linearly.
void FilledKey::ReturnParted() {
  const PointsX3 start = PlaceInside(solid_, shapes_, faces_, from_);
  const std::vector<TetShape> shapes = TetShapesOf(start, solid_.tets);
  crossed_.assign(shapes.size(), 0);
  starts_.resize(shapes.size());
  for (std::size_t t = 0; t < shapes.size(); ++t) {
    starts_[t] = MapOf(shapes_[t], start, solid_.tets, static_cast<Eigen::Index>(t));
    crossed_[t] = !(shapes[t].volume > VolumetricTuning::kCrossed * shapes_[t].volume);
    if (!crossed_[t]) shapes_[t] = shapes[t];
  }
}

void FilledKey::Lift() {
  const std::size_t count = maps_.size();
  std::vector<Eigen::Matrix3d>& rotations = rotations_;
  rotations.resize(count);
  std::vector<char> doubtful(count);
  std::vector<double> weights(count);
  for (std::size_t t = 0; t < count; ++t) {
    rotations[t] = maps_[t].rotation;
    doubtful[t] = maps_[t].inverted;
    weights[t] = doubtful[t] ? 0 : shapes_[t].volume;
  }
  const Body body = BodyOf(rotations, weights);
  body_turn_ = LogOf(TurnAgainst(body.node, weights, rotations));
  if (!options_.follow_turns) {
    for (const Eigen::Matrix3d& rotation : rotations) turns_.push_back(LogOf(rotation));
  } else {
    LiftedTurns lifted = LiftTurns(rotations, body.node, solid_.opposite, doubtful);
    // Without a large rigid body, turns are shortest relative to the middle.
    if (body.share < VolumetricTuning::kRigidShare) {
      const int middle = MiddleOf(lifted.turns, weights);
      body_turn_ = LogOf(ExpOf(body_turn_) * TurnAgainst(middle, weights, rotations));
      lifted = LiftTurns(rotations, middle, solid_.opposite, doubtful);
    }
    turns_ = lifted.turns;
    largest_tear_ = lifted.largest_tear;
    ChooseBodyTurn(turns_);
  }
  for (std::size_t t = 0; t < count; ++t)
    if (!doubtful[t]) largest_turn_ = std::max(largest_turn_, turns_[t].norm());
}

// The keys do not show whole turns of the entire figure. The smallest total turn is the most
// likely.
void FilledKey::ChooseBodyTurn(const std::vector<Eigen::Vector3d>& turns) {
  const double angle = body_turn_.norm();
  if (angle < 1e-6) return;
  const Eigen::Vector3d principal = body_turn_, whole = 2 * std::numbers::pi / angle * principal;
  double least = std::numeric_limits<double>::infinity();
  for (int k : {0, -1, 1}) {
    double sum = 0;
    for (std::size_t t = 0; t < turns.size(); ++t)
      sum += shapes_[t].volume * (principal + k * whole + turns[t]).squaredNorm();
    if (sum < 0.999 * least) {
      least = sum;
      body_turn_ = principal + k * whole;
    }
  }
}

// Both keys' Dirichlet energies have the same wanted map A(t), the second's relative to A(1)^-1.
// Together they give the weight v0 I + v1 S^-2 in the first key's frame. Any such weight reproduces
// the keys at the ends; this one is symmetric under swapping the keys.
Eigen::Matrix3d FilledKey::WeightOf(std::int64_t t) const {
  Eigen::Vector3d weight = Eigen::Vector3d::Constant(shapes_[t].volume);
  const Eigen::Vector3d& s = maps_[t].stretch;
  if (!maps_[t].inverted)
    weight += shapes_[t].volume *
              (s.prod() * s.array().square().inverse()).min(VolumetricTuning::kStiffest).matrix();
  return maps_[t].axes * weight.asDiagonal() * maps_[t].axes.transpose();
}

// A region's growth and turn: means, by the screened solve, of the volumes in both keys and of the
// turns.
void FilledKey::MakePaths() {
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(solid_.points.rows(), 5);
  for (Eigen::Index t = 0; t < solid_.tets.rows(); ++t) {
    if (!crossed_.empty() && crossed_[t]) continue;
    Eigen::RowVectorXd row(5);
    row << shapes_[t].volume, shapes_[t].volume * maps_[t].stretch.prod(),
        shapes_[t].volume * turns_[t].transpose();
    for (int k = 0; k < 4; ++k) sums.row(solid_.tets(t, k)) += row;
  }
  const Eigen::MatrixXd spread = spread_.Solve(sums);
  paths_of_tets_.reserve(maps_.size());
  for (std::size_t t = 0; t < maps_.size(); ++t) {
    Eigen::RowVectorXd region = Eigen::RowVectorXd::Zero(5);
    for (int k = 0; k < 4; ++k) region += spread.row(solid_.tets(t, k));
    const double own =
        std::log(std::max(maps_[t].stretch.prod(), std::numeric_limits<double>::min()));
    // Next to inverted tetrahedra the mean can be invalid; then the tetrahedron itself is the
    // region.
    const bool known = region[0] > 0 && region[1] > 0;
    const double growth = (known ? std::log(region[1] / region[0]) : own) / 3;
    const Eigen::Vector3d turn = known && options_.follow_turns
                                     ? (region.tail<3>() / region[0]).transpose().eval()
                                     : turns_[t];
    const Eigen::Matrix3d stretch =
        maps_[t].axes * maps_[t].stretch.asDiagonal() * maps_[t].axes.transpose();
    if (!crossed_.empty() && crossed_[t])
      paths_of_tets_.push_back(
          TetPath::Straight(starts_[t], maps_[t].rotation * stretch, body_turn_));
    else
      paths_of_tets_.emplace_back(rotations_[t] * stretch, turn, growth);
    corners_.push_back(WeightOf(t) * shapes_[t].gradients);
  }
}

void FilledKey::Factor() {
  const Eigen::Index n = solid_.points.rows();
  Eigen::SparseMatrix<double> h =
      LaplacianOf(n, solid_.tets, shapes_, [&](std::int64_t t) { return WeightOf(t); });
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(n);
  for (Eigen::Index t = 0; t < solid_.tets.rows(); ++t)
    for (int k = 0; k < 4; ++k)
      mass[solid_.tets(t, k)] += 0.25 * shapes_[t].volume * (1 + std::abs(maps_[t].stretch.prod()));
  const double reach = VolumetricTuning::kReach * start_volumes_.sum() / SurfaceArea(from_, faces_);
  double trace = 0;
  for (Eigen::Index i = 0; i < n; ++i) trace += h.coeff(i, i);
  const double ground = trace / static_cast<double>(n);
  std::vector<char> grounded(solid_.bodies, 0);
  Eigen::SparseMatrix<double> screened = h;
  for (Eigen::Index i = 0; i < n; ++i) {
    const int body = solid_.body_of_point[i];
    if (body < 0 || !grounded[body]) h.coeffRef(i, i) += ground;
    screened.coeffRef(i, i) += body < 0 ? ground : mass[i] / (reach * reach);
    if (body >= 0) grounded[body] = 1;
  }
  h.makeCompressed();  // vertices without faces had no entry
  screened.makeCompressed();
  fit_.Analyze(h);
  fit_.Factor(h);
  spread_.Analyze(screened);
  spread_.Factor(screened);
}

PointsX3 FilledKey::VolumeGradient(const PointsX3& p) const {
  PointsX3 gradient = PointsX3::Zero(solid_.points.rows(), 3);
  for (Eigen::Index f = 0; f < faces_.rows(); ++f) {
    const Eigen::RowVector3d a = p.row(faces_(f, 0)), ab = p.row(faces_(f, 1)) - a,
                             ac = p.row(faces_(f, 2)) - a;
    const Eigen::RowVector3d share = ab.cross(ac) / 6;
    for (int k = 0; k < 3; ++k) gradient.row(faces_(f, k)) += share;
  }
  return gradient;
}

// One step per body: it grows by the screened response to uniform pressure, so points far from the
// surface hardly move. The volume is a cubic polynomial of the step, whose root needs no further
// solve.
void FilledKey::KeepVolumes(const std::vector<double>& times, std::vector<PointsX3>& frames) const {
  Eigen::MatrixXd pressure(solid_.points.rows(), 3 * frames.size());
  for (std::size_t c = 0; c < frames.size(); ++c)
    pressure.middleCols<3>(3 * c) = VolumeGradient(frames[c]);
  const Eigen::MatrixXd growth = spread_.Solve(pressure);
  for (std::size_t c = 0; c < frames.size(); ++c) {
    const PointsX3 z = growth.middleCols<3>(3 * c);
    const std::vector<Cubic> volumes = VolumesAlong(frames[c], z, faces_, solid_);
    std::vector<double> step(solid_.bodies);
    for (int b = 0; b < solid_.bodies; ++b)
      step[b] = volumes[b].Reach(std::exp((1 - times[c]) * std::log(start_volumes_[b]) +
                                          times[c] * std::log(end_volumes_[b])));
    for (Eigen::Index i = 0; i < solid_.points.rows(); ++i)
      if (const int body = solid_.body_of_point[i]; body >= 0)
        frames[c].row(i) += step[body] * z.row(i);
  }
}

std::vector<PointsX3> FilledKey::At(const std::vector<double>& times) const {
  const Eigen::Index n = solid_.points.rows(), v = from_.rows(), count = std::ssize(times);
  Eigen::MatrixXd rhs(n, 3 * count);
  for (Eigen::Index c = 0; c < count; ++c)
    rhs.middleCols<3>(3 *
                      c) = sums_->Sum([&](std::int64_t t, Eigen::Matrix<double, 3, 4>& corners) {
      corners.noalias() = paths_of_tets_[t].At(times[c]) * corners_[t];
    }) * ExpOf(times[c] * body_turn_).transpose();
  const Eigen::MatrixXd x = fit_.Solve(rhs);
  std::vector<PointsX3> frames(count);
  for (Eigen::Index c = 0; c < count; ++c) frames[c] = x.middleCols<3>(3 * c);
  if (options_.keep_volume) KeepVolumes(times, frames);
  for (Eigen::Index c = 0; c < count; ++c) {
    paths_->Apply(times[c], frames[c]);
    frames[c].conservativeResize(v, 3);
    for (Eigen::Index i = 0; i < v; ++i)
      if (solid_.body_of_point[i] < 0)
        frames[c].row(i) = (1 - times[c]) * from_.row(i) + times[c] * to_.row(i);
    if (times[c] == 0) frames[c] = from_;
    if (times[c] == 1) frames[c] = to_;
  }
  return frames;
}

VolumetricReport FilledKey::Report() const {
  VolumetricReport report;
  report.tetrahedra = static_cast<int>(solid_.tets.rows());
  report.nodes = static_cast<int>(solid_.points.rows());
  report.bodies = solid_.bodies;
  report.inverted = inverted_;
  report.parted = solid_.parted;
  report.largest_turn = largest_turn_;
  report.largest_tear = largest_tear_;
  return report;
}

}  // namespace

struct VolumetricInterpolator::Impl {
  Impl(const PointsX3& v_, const PointsX3& u_, const FacesX3& faces_, const VolumetricOptions& o)
      : v(v_), u(u_), faces(faces_), options(o) {
    swapped = SecondIsSmoother(v, u, faces);
    std::string fault;
    if (TryKeys(false, fault)) return;
    std::string parted_fault;
    if (!TryKeys(true, parted_fault))
      throw InputError(fault + " (nor can the " + Name(!swapped) + " be filled)");
    report.note = "crossings were parted to fill it: " + fault;
  }

  /// Fills the preferred key, or the other if fewer tetrahedra are then inverted.
  /// @return false and the preferred key's fault if neither can be filled
  bool TryKeys(bool part_crossings, std::string& fault) {
    std::unique_ptr<FilledKey> preferred = Filled(swapped, part_crossings, fault), other;
    std::string other_fault;
    if (!preferred || preferred->inverted() > 0)
      other = Filled(!swapped, part_crossings, other_fault);
    if (!preferred && !other) return false;
    if (other && (!preferred || other->inverted() < preferred->inverted())) {
      const std::string why = preferred ? "it turns fewer tetrahedra inside out" : fault;
      Use(std::move(other), !swapped, "the " + Name(!swapped) + " was filled instead: " + why);
    } else {
      Use(std::move(preferred), swapped, "");
    }
    return true;
  }

  static std::string Name(bool second) { return second ? "second key" : "first key"; }

  /// @return null and the reason if this key cannot be filled
  std::unique_ptr<FilledKey> Filled(bool second, bool part_crossings, std::string& fault) const {
    const std::string from = "interpolate: " + Name(second), to = "interpolate: " + Name(!second);
    try {
      return std::make_unique<FilledKey>(second ? u : v, second ? v : u, faces, from, to, options,
                                         part_crossings);
    } catch (const InputError& e) {
      fault = e.what();
      return nullptr;
    }
  }

  void Use(std::unique_ptr<FilledKey> key, bool second, const std::string& note) {
    filled = std::move(key);
    swapped = second;
    filled->Prepare();
    report = filled->Report();
    report.meshed_key = second ? 1 : 0;
    report.note = note;
  }

  PointsX3 v, u;
  FacesX3 faces;
  VolumetricOptions options;
  bool swapped = false;
  std::unique_ptr<FilledKey> filled;
  VolumetricReport report;
};

VolumetricInterpolator::VolumetricInterpolator(const PointsX3& v, const PointsX3& u,
                                               const FacesX3& faces,
                                               const VolumetricOptions& options) {
  RequireKeys(v, u, faces);
  impl_ = std::make_unique<Impl>(v, u, faces, options);
}

VolumetricInterpolator::~VolumetricInterpolator() = default;
VolumetricInterpolator::VolumetricInterpolator(VolumetricInterpolator&&) noexcept = default;

PointsX3 VolumetricInterpolator::At(double t) const { return At(std::vector<double>{t}).front(); }

std::vector<PointsX3> VolumetricInterpolator::At(const std::vector<double>& times) const {
  if (!impl_->swapped) return impl_->filled->At(times);
  std::vector<double> back(times.size());
  std::transform(times.begin(), times.end(), back.begin(), [](double t) { return 1 - t; });
  return impl_->filled->At(back);
}

const VolumetricReport& VolumetricInterpolator::report() const { return impl_->report; }

}  // namespace keypose::interpolation
