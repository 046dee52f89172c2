#include "synth/worlds/clay_pair.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <utility>

#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "synth/worlds/noise.h"
#include "synth/worlds/surface_grid.h"

namespace keypose::synth {
namespace {

using Eigen::Vector3d;

// Separate streams of random numbers, so that more noise does not move the holes.
enum Stream : std::uint64_t {
  kSourceGrid = 101,
  kTargetGrid = 202,
  kTurn = 303,
  kVertexNoise = 404,
  kHoles = 505,
  kPicks = 606
};

std::uint64_t SeedOf(const ClayPairOptions& options, Stream stream) {
  return Hash(options.shape.seed * 1000 + stream);
}

// Rotation of the whole target about the middle of the posed solid, and its scale.
struct Placement {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  double scale = 1;
  Vector3d center = Vector3d::Zero();

  PointsX3 operator()(const PointsX3& points) const {
    return ((points.rowwise() - center.transpose()) * (scale * turn.transpose())).rowwise() +
           center.transpose();
  }
};

Placement PlacementOf(const ClayPairOptions& options, const PointsX3& posed) {
  Random random(SeedOf(options, kTurn));
  Vector3d axis;
  for (int k = 0; k < 3; ++k) axis[k] = random.Normal();
  Placement placement;
  placement.turn =
      Eigen::AngleAxisd(options.turn_deg * 3.141592653589793 / 180, axis.normalized()).matrix();
  placement.scale = options.scale;
  placement.center = posed.colwise().mean().transpose();
  return placement;
}

void AddNoise(double sigma, std::uint64_t seed, PointsX3* points) {
  Random random(seed);
  for (Eigen::Index i = 0; i < points->rows(); ++i)
    for (int k = 0; k < 3; ++k) (*points)(i, k) += sigma * random.Normal();
}

std::vector<std::vector<int>> FacesAround(const Mesh& mesh) {
  std::vector<std::vector<int>> around(mesh.points.rows());
  for (int f = 0; f < mesh.face_count(); ++f)
    for (int k = 0; k < 3; ++k) around[mesh.faces(f, k)].push_back(f);
  return around;
}

// Removes faces around `center`, nearest vertices first, until they have the wanted area. Only
// connected faces are removed: the other side of a thin limb stays.
void Punch(const Mesh& mesh, const Eigen::VectorXd& areas,
           const std::vector<std::vector<int>>& around, int center, double area,
           std::vector<char>* removed) {
  const auto distance = [&](int v) {
    return (mesh.points.row(v) - mesh.points.row(center)).squaredNorm();
  };
  std::set<std::pair<double, int>> front = {{0, center}};
  std::vector<char> seen(mesh.points.rows(), 0);
  seen[center] = 1;
  double gone = 0;
  while (!front.empty() && gone < area) {
    const int v = front.begin()->second;
    front.erase(front.begin());
    for (const int f : around[v]) {
      if ((*removed)[f]) continue;
      (*removed)[f] = 1;
      gone += areas[f];
      for (int k = 0; k < 3; ++k) {
        const int next = mesh.faces(f, k);
        if (!seen[next]) front.emplace(distance(next), next);
        seen[next] = 1;
      }
    }
  }
}

Mesh WithoutFaces(const Mesh& mesh, const std::vector<char>& removed) {
  std::vector<int> place(mesh.points.rows(), -1), kept, corners;
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
    for (int k = 0; k < 3 && !removed[f]; ++k) {
      const int v = mesh.faces(f, k);
      if (place[v] < 0) {
        place[v] = SizeOf(kept);
        kept.push_back(v);
      }
      corners.push_back(place[v]);
    }
  Mesh rest;
  rest.points = mesh.points(kept, Eigen::all);
  rest.faces =
      Eigen::Map<const FacesX3>(corners.data(), static_cast<Eigen::Index>(corners.size() / 3), 3);
  return rest;
}

bool IsFar(const PointsX3& points, const Eigen::RowVector3d& from, double distance) {
  return points.rows() == 0 ||
         (points.rowwise() - from).rowwise().squaredNorm().minCoeff() >= distance * distance;
}

// Holes are at least 1.5 of their radii away from `keep`, and do not touch each other, if there is
// space.
Mesh WithHoles(const Mesh& mesh, const ClayPairOptions& options, const PointsX3& keep) {
  if (options.holes == 0) return mesh;
  const Eigen::VectorXd areas = FaceAreas(mesh.points, mesh.faces);
  const double area = areas.sum() * options.hole_area / options.holes,
               radius = std::sqrt(area / 3.141592653589793);
  Random random(SeedOf(options, kHoles));
  const auto around = FacesAround(mesh);
  PointsX3 centers(0, 3);
  std::vector<char> removed(mesh.faces.rows(), 0);
  for (int attempt = 0; attempt < 1000 * options.holes && centers.rows() < options.holes;
       ++attempt) {
    const int vertex = random.Below(mesh.vertex_count());
    const double room = attempt < 500 * options.holes ? radius : 0;
    if (!IsFar(keep, mesh.points.row(vertex), 1.5 * room) ||
        !IsFar(centers, mesh.points.row(vertex), 3.5 * room))
      continue;
    centers.conservativeResize(centers.rows() + 1, Eigen::NoChange);
    centers.row(centers.rows() - 1) = mesh.points.row(vertex);
    Punch(mesh, areas, around, vertex, area, &removed);
  }
  return WithoutFaces(mesh, removed);
}

// For each place the nearest vertex that no earlier place has taken.
std::vector<int> VerticesOf(const std::vector<Place>& places, const PointsX3& points) {
  std::vector<int> vertices;
  for (const Place& place : places) {
    const Eigen::VectorXd distances =
        (points.rowwise() - place.position.transpose()).rowwise().squaredNorm();
    std::vector<int> order(points.rows());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
    const auto nearer = [&](int a, int b) {
      return std::pair(distances[a], a) < std::pair(distances[b], b);
    };
    const std::size_t enough = std::min(order.size(), vertices.size() + 1);
    std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(enough),
                      order.end(), nearer);
    for (std::size_t i = 0; i < enough; ++i)
      if (std::find(vertices.begin(), vertices.end(), order[i]) == vertices.end()) {
        vertices.push_back(order[i]);
        break;
      }
  }
  return vertices;
}

Landmark AtVertex(const Mesh& mesh, int vertex) {
  Landmark landmark;
  for (int f = 0; f < mesh.face_count(); ++f)
    for (int k = 0; k < 3; ++k)
      if (mesh.faces(f, k) == vertex) {
        landmark.face = f;
        landmark.barycentric[k] = 1;
        return landmark;
      }
  return landmark;
}

std::vector<LandmarkPair> PicksOf(const ClayPairOptions& options, const ClayPair& pair,
                                  const std::vector<int>& vertices) {
  const double share = options.landmark_noise < 0 ? 4 * options.noise : options.landmark_noise;
  const RayScene scene(pair.target.points, pair.target.faces);
  Random random(SeedOf(options, kPicks));
  std::vector<LandmarkPair> picks;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    Vector3d where = pair.truth.row(vertices[i]);
    for (int k = 0; k < 3; ++k) where[k] += share * pair.diagonal * random.Normal();
    const RayScene::Foot foot = scene.ClosestPoint(where);
    LandmarkPair pick{pair.places[i].name, AtVertex(pair.source, vertices[i]), {}};
    pick.source.name = pick.target.name = pick.name;
    pick.target.face = foot.face;
    pick.target.barycentric = foot.barycentric;
    picks.push_back(pick);
  }
  return picks;
}

PointsX3 PositionsOf(const std::vector<Place>& places) {
  PointsX3 positions(std::ssize(places), 3);
  for (std::size_t i = 0; i < places.size(); ++i) positions.row(i) = places[i].position.transpose();
  return positions;
}

// The dense mesh under a tessellation. Its spacing is half the wanted edge length, so that its
// chords have no visible effect.
PosedSurface SurfaceFor(const LimbedShape& shape, const Pose& pose, int vertices) {
  constexpr double kTypicalArea = 0.03;  // [m^2] of the shapes
  return PosedSurface(shape.clay, pose,
                      std::max(0.0008, 0.5 * std::sqrt(5 * kTypicalArea / vertices)));
}

}  // namespace

std::vector<std::string> ClayPairOptions::Problems() const {
  std::vector<std::string> problems = shape.Problems();
  if (vertices < 200 || vertices > 200000) problems.push_back("vertices must be 200 to 200000");
  if (!(ratio >= 0.1 && ratio <= 40)) problems.push_back("ratio must be 0.1 to 40");
  if (!(noise >= 0 && noise <= 0.05)) problems.push_back("noise must be 0 to 0.05 of the diagonal");
  if (!(landmark_noise <= 0.2))
    problems.push_back("landmark noise must be at most 0.2 of the diagonal");
  if (holes < 0 || holes > 100) problems.push_back("there are 0 to 100 holes");
  if (!(hole_area >= 0 && hole_area <= 0.5))
    problems.push_back("the holes' area must be 0 to 0.5 of the whole");
  if (!(std::abs(turn_deg) <= 360)) problems.push_back("turn must be -360 to 360 degrees");
  if (!(scale >= 1e-3 && scale <= 1e3)) problems.push_back("scale must be 0.001 to 1000");
  return problems;
}

ClayPair MakeClayPair(const ClayPairOptions& options) {
  if (const auto problems = options.Problems(); !problems.empty())
    throw UsageError("synth: " + problems.front());
  const LimbedShape shape = MakeLimbedShape(options.shape);
  const int target_vertices =
      std::max(200, static_cast<int>(std::lround(options.vertices * options.ratio)));
  const Tessellation source = Tessellate(SurfaceFor(shape, {}, options.vertices), options.vertices,
                                         SeedOf(options, kSourceGrid));
  Tessellation target = Tessellate(SurfaceFor(shape, shape.pose, target_vertices), target_vertices,
                                   SeedOf(options, kTargetGrid));
  ClayPair pair;
  pair.source = source.mesh;
  pair.places = shape.places;
  const PointsX3 posed = shape.pose(source.material);
  const Placement placement = PlacementOf(options, posed);
  pair.truth = placement(posed);
  target.mesh.points = placement(target.mesh.points);
  pair.diagonal = BoundingDiagonal(target.mesh.points);
  AddNoise(options.noise * pair.diagonal, SeedOf(options, kVertexNoise), &target.mesh.points);
  // The holes are the same for few or many of the usual landmarks.
  LimbedShapeOptions usual = options.shape;
  usual.places = std::max(13, usual.places);
  pair.target = WithHoles(target.mesh, options,
                          placement(shape.pose(PositionsOf(MakeLimbedShape(usual).places))));
  pair.picks = PicksOf(options, pair, VerticesOf(shape.places, pair.source.points));
  return pair;
}

}  // namespace keypose::synth
