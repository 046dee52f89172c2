#include "register/auto/rigid_parts.h"

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <optional>

#include "core/numbers/kd_tree.h"
#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"
#include "register/nricp/correspondence.h"

namespace keypose::registration {

namespace {

constexpr int kMostParts = 4;
constexpr int kFewestVertices = 12;  // that a further part is looked for in
constexpr int kPins = 60;            // of a part
constexpr double kHeldStiffness = 99;
constexpr double kLandmarkOff = 0.01;  // over the diagonal
constexpr int kSearchSamples = 120, kSettleSamples = 250, kPolishSamples = 2000;
constexpr int kSearchRounds = 24, kSettleRounds = 24, kPolishRounds = 8;
// Distances over the target's diagonal: at which a pull has a quarter of its weight in the first
// and in the last round, and within which a point lies on the target.
constexpr double kWidest = 0.02, kNarrowest = 0.0015, kOnTarget = 0.001;
constexpr double kInPlace = 0.005;
constexpr double kSameWay = 0.5;  // cosine between the normals of a point and its foot
// Shares of the area that is left.
constexpr double kWorthSettling = 0.35, kFirstShare = 0.5, kFurtherShare = 0.33;
constexpr double kSmallest = 0.03;  // of the whole area
constexpr double kClearer = 0.1;    // share by which the best place must lead another one
constexpr double kApart = 0.02;     // places are different from here on, over the diagonal
// Mean square of the normals' share of a unit motion, with turns in units of the part's radius.
// Below it a turn of 4 degrees moves points off the target by less than kOnTarget.
constexpr double kLeastGrip = 3e-3;
constexpr double kTurn = M_PI / 6;   // of the other starts, about each axis
constexpr double kCompact = 0.65;    // of a part's area: lies on the target with all its neighbours
constexpr double kTakenShare = 0.1;  // of a part's feet that may lie on another part
constexpr double kTakenNearer = 0.7;  // feet of two parts nearer than this share of an edge

using Matrix7 = Eigen::Matrix<double, 7, 7>;
using Vector7 = Eigen::Matrix<double, 7, 1>;

/// Points with unit normals and areas.
struct PartSamples {
  PointsX3 points, normals;
  Eigen::VectorXd areas;
};

/// A place of the samples, the share of their area on the target, and how firmly that holds them.
struct Fit {
  Similarity3 place;
  double share = 0, grip = 0;
};

/// The source's vertices that no part has yet.
struct Rest {
  std::vector<int> vertices;
  double area = 0;
};

Eigen::Matrix3d TurnBy(const Eigen::Vector3d& turn) {
  const double angle = turn.norm();
  if (angle == 0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
}

class PartFinder {
 public:
  PartFinder(const Mesh& source, const Mesh& target)
      : source_(source),
        normals_(VertexNormals(source.points, source.faces)),
        areas_(VertexAreas(source.points, source.faces)),
        surface_(target.points, target.faces),
        diagonal_(BoundingDiagonal(target.points)) {}

  const Eigen::VectorXd& areas() const { return areas_; }
  std::optional<Fit> BestPlace(const Rest& rest, const std::vector<Similarity3>& starts,
                               bool scales) const;
  RigidPart PartAt(const Fit& fit, const Rest& rest) const;
  Fit Polished(const Fit& fit, const Rest& rest, bool scales) const {
    return Run(fit.place, Take(rest, kPolishSamples), kPolishRounds, kNarrowest, scales);
  }

 private:
  PartSamples Take(const Rest& rest, int count) const;
  Feet FeetOf(const Similarity3& place, const PartSamples& samples, PointsX3& moved,
              PointsX3& last) const;
  bool OnTarget(const Feet& feet, const PointsX3& moved, Eigen::Index i) const {
    return feet.allowed[i] && (feet.points.row(i) - moved.row(i)).norm() < kOnTarget * diagonal_;
  }
  bool Different(const Similarity3& a, const Similarity3& b, const PartSamples& samples) const {
    const PointsX3 apart = Transformed(a, samples.points) - Transformed(b, samples.points);
    return apart.rowwise().norm().mean() > kApart * diagonal_;
  }
  Fit Run(Similarity3 place, const PartSamples& samples, int rounds, double from,
          bool scales) const;
  double Step(const PartSamples& samples, const Feet& feet, const PointsX3& moved, double robust,
              bool scales, Similarity3& place) const;

  const Mesh& source_;
  PointsX3 normals_;
  Eigen::VectorXd areas_;
  TargetSurface surface_;
  double diagonal_;
};

PartSamples PartFinder::Take(const Rest& rest, int count) const {
  const Eigen::Index step = std::max<Eigen::Index>(1, std::ssize(rest.vertices) / count);
  std::vector<int> chosen;
  for (Eigen::Index k = 0; k < std::ssize(rest.vertices); k += step)
    chosen.push_back(rest.vertices[k]);
  return {source_.points(chosen, Eigen::all), normals_(chosen, Eigen::all), areas_(chosen)};
}

Feet PartFinder::FeetOf(const Similarity3& place, const PartSamples& samples, PointsX3& moved,
                        PointsX3& last) const {
  moved = Transformed(place, samples.points);
  const PointsX3 normals = samples.normals * place.rotation.transpose();
  Feet feet =
      surface_.FindFeet(moved, normals, kSameWay, last.rows() == moved.rows() ? &last : nullptr);
  last = feet.points;
  return feet;
}

/// One linear step of robust point-to-plane ICP.
/// @return the smallest eigenvalue of the normal equations without scale
double PartFinder::Step(const PartSamples& samples, const Feet& feet, const PointsX3& moved,
                        double robust, bool scales, Similarity3& place) const {
  const Eigen::Vector3d centre = moved.colwise().mean().transpose();
  const double radius =
      std::sqrt((moved.rowwise() - centre.transpose()).rowwise().squaredNorm().mean());
  Matrix7 matrix = Matrix7::Zero();
  Vector7 right = Vector7::Zero();
  double total = 0;
  for (Eigen::Index i = 0; i < moved.rows(); ++i) {
    if (!feet.allowed[i]) continue;
    const Eigen::Vector3d off = (feet.points.row(i) - moved.row(i)).transpose();
    const Eigen::Vector3d n = feet.normals.row(i).normalized().transpose();
    const Eigen::Vector3d x = (moved.row(i).transpose() - centre) / radius;
    const double r2 = robust * robust, belief = r2 / (r2 + off.squaredNorm());
    const double weight = samples.areas[i] * belief * belief;
    Vector7 row;
    row << x.cross(n), n, scales ? x.dot(n) : 0;
    matrix += weight * row * row.transpose();
    right += weight * off.dot(n) / radius * row;
    total += weight;
  }
  if (!(total > 0)) return 0;
  matrix /= total;
  const double grip = Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>>(
                          matrix.topLeftCorner<6, 6>(), Eigen::EigenvaluesOnly)
                          .eigenvalues()[0];
  matrix.diagonal().array() += 1e-6;
  const Vector7 move = matrix.ldlt().solve(right / total);
  const Eigen::Matrix3d turn = TurnBy(move.head<3>());
  const double growth = 1 + std::clamp(move[6], -0.1, 0.1);
  place.translation =
      growth * (turn * (place.translation - centre)) + centre + move.segment<3>(3) * radius;
  place.rotation = turn * place.rotation;
  place.scale *= growth;
  return grip;
}

/// @param from  robust distance of the first round, over the diagonal
Fit PartFinder::Run(Similarity3 place, const PartSamples& samples, int rounds, double from,
                    bool scales) const {
  Fit fit;
  PointsX3 moved, last;
  for (int k = 0; k < rounds; ++k) {
    const Feet feet = FeetOf(place, samples, moved, last);
    const double robust = from * std::pow(kNarrowest / from, std::min(1.0, 1.4 * k / rounds));
    fit.grip = Step(samples, feet, moved, robust * diagonal_, scales, place);
  }
  const Feet feet = FeetOf(place, samples, moved, last);
  fit.place = place;
  for (Eigen::Index i = 0; i < moved.rows(); ++i)
    if (OnTarget(feet, moved, i)) fit.share += samples.areas[i] / samples.areas.sum();
  return fit;
}

/// The best place, if it leads all others clearly.
std::optional<Fit> PartFinder::BestPlace(const Rest& rest, const std::vector<Similarity3>& starts,
                                         bool scales) const {
  const PartSamples few = Take(rest, kSearchSamples), more = Take(rest, kSettleSamples);
  std::vector<Fit> fits;
  for (const Similarity3& start : starts) {
    const Fit fit = Run(start, few, kSearchRounds, kWidest, scales);
    const auto same = std::find_if(fits.begin(), fits.end(), [&](const Fit& other) {
      return !Different(fit.place, other.place, few);
    });
    if (same == fits.end())
      fits.push_back(fit);
    else if (fit.share > same->share)
      *same = fit;
  }
  const auto better = [](const Fit& a, const Fit& b) { return a.share > b.share; };
  std::stable_sort(fits.begin(), fits.end(), better);
  if (fits[0].share < kWorthSettling) return std::nullopt;
  fits.resize(std::min<std::size_t>(fits.size(), 2));
  for (Fit& fit : fits) fit = Run(fit.place, more, kSettleRounds, 2 * kNarrowest, scales);
  std::stable_sort(fits.begin(), fits.end(), better);
  if (fits.size() > 1 && Different(fits[0].place, fits[1].place, more) &&
      fits[1].share > fits[0].share - kClearer)
    return std::nullopt;
  return fits[0];
}

RigidPart PartFinder::PartAt(const Fit& fit, const Rest& rest) const {
  PointsX3 moved, last;
  const Feet feet = FeetOf(fit.place, Take(rest, SizeOf(rest.vertices)), moved, last);
  std::vector<char> held(source_.vertex_count(), 0);
  RigidPart part{fit.place, {}, {}, 0};
  for (int k = 0; k < SizeOf(rest.vertices); ++k) {
    const int v = rest.vertices[k];
    held[v] = OnTarget(feet, moved, k);
    if (held[v]) part.share += areas_[v] / areas_.sum();
  }
  const std::vector<char> on = held;
  for (Eigen::Index f = 0; f < source_.faces.rows(); ++f) {
    const Eigen::RowVector3i face = source_.faces.row(f);
    if (!on[face[0]] || !on[face[1]] || !on[face[2]])
      for (int v : face) held[v] = 0;
  }
  std::vector<int> rows;
  for (int k = 0; k < SizeOf(rest.vertices); ++k)
    if (held[rest.vertices[k]]) {
      rows.push_back(k);
      part.held.push_back(rest.vertices[k]);
    }
  part.feet = feet.points(rows, Eigen::all);
  return part;
}

std::vector<Similarity3> StartsAbout(const Similarity3& first, const Eigen::Vector3d& pivot) {
  std::vector<Similarity3> starts{first};
  for (int axis = 0; axis < 3; ++axis)
    for (const double turn : {-kTurn, kTurn}) {
      Similarity3 turned = first;
      turned.rotation = first.rotation * Eigen::AngleAxisd(turn, Eigen::Vector3d::Unit(axis));
      turned.translation += first * pivot - turned * pivot;
      starts.push_back(turned);
    }
  return starts;
}

/// The vertices that no part holds.
Rest RestOf(const Eigen::VectorXd& areas, const std::vector<RigidPart>& parts) {
  std::vector<char> held(areas.size(), 0);
  for (const RigidPart& part : parts)
    for (int v : part.held) held[v] = 1;
  Rest rest;
  for (int v = 0; v < areas.size(); ++v)
    if (!held[v]) {
      rest.vertices.push_back(v);
      rest.area += areas[v];
    }
  return rest;
}

double MeanEdge(const PointsX3& points, const FacesX3& faces) {
  double sum = 0;
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    sum += (points.row(faces(f, 0)) - points.row(faces(f, 1))).norm();
  return faces.rows() > 0 ? sum / static_cast<double>(faces.rows()) : 0;
}

/// Whether a part lies where others already do.
bool IsTaken(const RigidPart& part, const std::vector<RigidPart>& others, double edge) {
  int taken = 0;
  for (const RigidPart& other : others) {
    if (other.feet.rows() == 0) continue;
    const KdTree tree(other.feet);
    for (Eigen::Index k = 0; k < part.feet.rows(); ++k)
      taken += std::sqrt(tree.Nearest(part.feet.row(k)).squared_distance) < kTakenNearer * edge;
  }
  return taken > kTakenShare * static_cast<double>(part.feet.rows());
}

/// Starts of a further part: as the first part lies, as the bent result lies, and turned.
std::vector<Similarity3> FurtherStarts(const Mesh& source, const PointsX3& bent, const Rest& rest,
                                       const Similarity3& first) {
  const PointsX3 before = source.points(rest.vertices, Eigen::all),
                 after = bent(rest.vertices, Eigen::all);
  std::vector<Similarity3> starts = StartsAbout(first, before.colwise().mean().transpose());
  Similarity3 own = FitSimilarity(before, after);
  const Eigen::Vector3d pivot = before.colwise().mean().transpose(), kept = own * pivot;
  own.scale = first.scale;
  own.translation += kept - own * pivot;
  starts.push_back(own);
  return starts;
}

}  // namespace

std::vector<RigidPart> FindRigidParts(const Mesh& source, const Mesh& target,
                                      const PointsX3& bent) {
  const PartFinder finder(source, target);
  const double whole = finder.areas().sum();
  std::vector<RigidPart> parts;
  for (int k = 0; k < kMostParts; ++k) {
    const Rest rest = RestOf(finder.areas(), parts);
    if (rest.area < kSmallest * whole || SizeOf(rest.vertices) < kFewestVertices) break;
    const bool scales = parts.empty();
    const std::vector<Similarity3> starts =
        scales ? StartsAbout(FitSimilarity(source.points, bent, finder.areas()),
                             source.points.colwise().mean().transpose())
               : FurtherStarts(source, bent, rest, parts[0].target_from_source);
    const std::optional<Fit> found = finder.BestPlace(rest, starts, scales);
    if (!found) break;
    const Fit fit = finder.Polished(*found, rest, scales);
    RigidPart part = finder.PartAt(fit, rest);
    const double least = parts.empty() ? kFirstShare * whole
                                       : std::max(kFurtherShare * rest.area, kSmallest * whole);
    const double edge = part.target_from_source.scale * MeanEdge(source.points, source.faces);
    double held = 0;
    for (int v : part.held) held += finder.areas()[v];
    if (part.share * whole < least || held < kCompact * part.share * whole ||
        fit.grip < kLeastGrip || IsTaken(part, parts, edge))
      break;
    parts.push_back(std::move(part));
  }
  return parts;
}

double ShareInPlace(const RigidPart& part, const Mesh& source, const PointsX3& bent,
                    double target_diagonal) {
  int in_place = 0;
  for (int v : part.held) {
    const Eigen::Vector3d put = part.target_from_source * source.points.row(v).transpose();
    in_place += (put - bent.row(v).transpose()).norm() < kInPlace * target_diagonal;
  }
  return part.held.empty() ? 1 : static_cast<double>(in_place) / SizeOf(part.held);
}

bool Contradict(const std::vector<LandmarkGoal>& landmarks, const std::vector<RigidPart>& parts,
                const PointsX3& points, double target_diagonal) {
  const auto off = [&](const RigidPart& part, const LandmarkGoal& goal) {
    for (const int v : goal.source.vertices)
      if (!std::binary_search(part.held.begin(), part.held.end(), v)) return false;
    const Eigen::Vector3d put = part.target_from_source * PositionOf(goal.source, points);
    return (put - goal.target).norm() > kLandmarkOff * target_diagonal;
  };
  for (const RigidPart& part : parts)
    for (const LandmarkGoal& goal : landmarks)
      if (off(part, goal)) return true;
  return false;
}

void AddPins(const std::vector<RigidPart>& parts, std::vector<LandmarkGoal>& goals) {
  for (const RigidPart& part : parts) {
    const int pins = std::min(kPins, SizeOf(part.held));
    for (int k = 0; k < pins; ++k) {
      const int at = k * SizeOf(part.held) / pins;
      LandmarkGoal pin;
      pin.source.vertices.setConstant(part.held[at]);
      pin.target = part.feet.row(at);
      goals.push_back(pin);
    }
  }
}

Eigen::VectorXd Stiffened(const Eigen::VectorXd& stiffness, Eigen::Index vertices,
                          const std::vector<RigidPart>& parts) {
  Eigen::VectorXd stiff = stiffness.size() > 0 ? stiffness : Eigen::VectorXd::Ones(vertices);
  for (const RigidPart& part : parts)
    for (int v : part.held) stiff[v] = std::max(stiff[v], kHeldStiffness);
  return stiff;
}

}  // namespace keypose::registration
