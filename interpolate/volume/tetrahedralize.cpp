#include "interpolate/volume/tetrahedralize.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>
#include <optional>
#include <sstream>
#include <string>

#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "core/values/union_find.h"
#include "interpolate/maps/face_crossings.h"
#include "interpolate/volume/run_tetgen.h"

namespace keypose::interpolation {

namespace {

using Triple = std::array<int, 3>;

std::string Remedy() {
  return "; repair it first (keypose-cleanup makes a closed surface that does not touch itself), "
         "or interpolate the surface alone";
}

/// Connected part of each vertex, numbered by lowest vertex; -1 for vertices without a face.
std::vector<int> PartsOf(Eigen::Index vertex_count, const FacesX3& faces, int& part_count) {
  UnionFind joined(vertex_count);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 1; k < 3; ++k) joined.Join(faces(f, 0), faces(f, k));
  part_count = 0;
  std::vector<int> part(vertex_count, -1);
  std::vector<int> number(vertex_count, -1);
  for (Eigen::Index f = 0; f < faces.rows(); ++f) number[joined.Find(faces(f, 0))] = 0;
  for (Eigen::Index i = 0; i < vertex_count; ++i)
    if (number[i] == 0) number[i] = part_count++;
  for (Eigen::Index i = 0; i < vertex_count; ++i)
    part[i] = number[joined.Find(static_cast<int>(i))];
  return part;
}

/// Faces of one part, or of one body.
FacesX3 FacesOf(const FacesX3& faces, const std::vector<int>& group, int wanted) {
  FacesX3 some(std::count(group.begin(), group.end(), wanted), 3);
  Eigen::Index at = 0;
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    if (group[f] == wanted) some.row(at++) = faces.row(f);
  return some;
}

/// Winding number of the surface around a point: 1 inside, 0 outside.
/// Source: van Oosterom and Strackee 1983.
double WindingNumber(const Eigen::RowVector3d& x, const PointsX3& points, const FacesX3& faces) {
  double sum = 0;
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    const Eigen::Vector3d a = points.row(faces(f, 0)) - x, b = points.row(faces(f, 1)) - x,
                          c = points.row(faces(f, 2)) - x;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    sum +=
        std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return sum / (2 * std::numbers::pi);
}

void RequireClosed(const PointsX3& points, const FacesX3& faces, const std::string& what) {
  std::map<std::pair<int, int>, int> sides;
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) ++sides[{faces(f, k), faces(f, (k + 1) % 3)}];
  int bad = 0;
  std::pair<int, int> first{-1, -1};
  for (const auto& [side, count] : sides) {
    const auto back = sides.find({side.second, side.first});
    if (count == 1 && back != sides.end() && back->second == 1) continue;
    if (bad++ == 0) first = side;
  }
  if (bad > 0)
    throw InputError(
        what + ": the surface is not closed: " + std::to_string(bad) +
        " edges do not have exactly two faces that agree, the first between vertices " +
        std::to_string(first.first) + " and " + std::to_string(first.second) +
        ", so that it holds no solid" + Remedy());
  const double diagonal = BoundingDiagonal(points);
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    const Eigen::Vector3d a = points.row(faces(f, 1)) - points.row(faces(f, 0)),
                          b = points.row(faces(f, 2)) - points.row(faces(f, 0));
    if (!(a.cross(b).norm() > 1e-14 * diagonal * diagonal))
      throw InputError(what + ": face " + std::to_string(f) +
                       " has no area, so that the solid has a gap there" + Remedy());
  }
}

/// Body of each face: the parts that face outwards, each with the hollows for which it is the
/// smallest enclosing part.
std::vector<int> BodiesOf(const PointsX3& points, const FacesX3& faces, const std::string& what,
                          int& body_count) {
  int part_count = 0;
  const std::vector<int> part_of_vertex = PartsOf(points.rows(), faces, part_count);
  std::vector<int> part_of_face(faces.rows());
  for (Eigen::Index f = 0; f < faces.rows(); ++f) part_of_face[f] = part_of_vertex[faces(f, 0)];
  std::vector<FacesX3> part_faces(part_count);
  std::vector<double> volume(part_count);
  std::vector<int> body(part_count, -1);
  body_count = 0;
  for (int p = 0; p < part_count; ++p) {
    part_faces[p] = FacesOf(faces, part_of_face, p);
    volume[p] = SignedVolume(points, part_faces[p]);
    if (volume[p] > 0) body[p] = body_count++;
  }
  for (int p = 0; p < part_count; ++p) {
    if (volume[p] > 0) continue;
    int around = -1;
    for (int q = 0; q < part_count; ++q)
      if (volume[q] > -volume[p] && (around < 0 || volume[q] < volume[around]) &&
          WindingNumber(points.row(part_faces[p](0, 0)), points, part_faces[q]) > 0.5)
        around = q;
    if (around < 0)
      throw InputError(
          what + ": the part that holds vertex " + std::to_string(part_faces[p](0, 0)) +
          " is inside out and no other part lies around it; turn its faces round" + Remedy());
    body[p] = body[around];
  }
  std::vector<int> of_face(faces.rows());
  for (Eigen::Index f = 0; f < faces.rows(); ++f) of_face[f] = body[part_of_face[f]];
  return of_face;
}

/// One body in TetGen's input and output format.
class Filler {
 public:
  Filler(const PointsX3& points, const FacesX3& faces) : local_(points.rows(), -1), faces_(faces) {
    for (Eigen::Index f = 0; f < faces.rows(); ++f)
      for (int k = 0; k < 3; ++k)
        if (local_[faces(f, k)] < 0) local_[faces(f, k)] = 0;
    for (Eigen::Index i = 0; i < points.rows(); ++i)
      if (local_[i] == 0) {
        local_[i] = SizeOf(global_);
        global_.push_back(static_cast<int>(i));
      }
    for (Eigen::Index f = 0; f < faces_.rows(); ++f)
      for (int k = 0; k < 3; ++k) faces_(f, k) = local_[faces(f, k)];
    points_.resize(std::ssize(global_), 3);
    for (std::size_t i = 0; i < global_.size(); ++i) points_.row(i) = points.row(global_[i]);
  }

  std::string Switches(const TetrahedralizeOptions& options) const {
    const double edge = options.element_size * MeanEdge();
    // A regular tetrahedron has the volume 0.118 edge^3; TetGen's have about half of the allowed
    // volume.
    const double largest =
        std::max(0.12 * edge * edge * edge,
                 2 * SignedVolume(points_, faces_) / std::max(1, options.max_tetrahedra));
    std::ostringstream text;
    text.precision(17);
    text << "pYMq1.4/0nzQa" << std::fixed << largest;
    return text.str();
  }

  const PointsX3& points() const { return points_; }
  const FacesX3& faces() const { return faces_; }
  const std::vector<int>& global() const { return global_; }

 private:
  double MeanEdge() const {
    double sum = 0;
    for (Eigen::Index f = 0; f < faces_.rows(); ++f)
      for (int k = 0; k < 3; ++k)
        sum += (points_.row(faces_(f, k)) - points_.row(faces_(f, (k + 1) % 3))).norm();
    return sum / static_cast<double>(3 * faces_.rows());
  }

  std::vector<int> local_, global_;
  PointsX3 points_;
  FacesX3 faces_;
};

constexpr std::array<Triple, 4> kFaceOpposite = {
    {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};  // seen from outside, for a positive tetrahedron

double SixVolumes(const std::vector<double>& p, const int* t) {
  const auto at = [&](int k) { return Eigen::Map<const Eigen::Vector3d>(p.data() + 3 * t[k]); };
  return (at(1) - at(0)).cross(at(2) - at(0)).dot(at(3) - at(0));
}

/// The same three corners in the same cyclic order, lowest first.
Triple Rotated(const Triple& t) {
  const int k = static_cast<int>(std::min_element(t.begin(), t.end()) - t.begin());
  return {t[k], t[(k + 1) % 3], t[(k + 2) % 3]};
}

/// Marks what is reached from `open` through no wall.
void Flood(const std::vector<int>& neighbours, const std::vector<std::array<char, 4>>& wall,
           std::vector<int> open, std::vector<char>* inner) {
  while (!open.empty()) {
    const int t = open.back();
    open.pop_back();
    for (int k = 0; k < 4; ++k) {
      const int next = neighbours[4 * t + k];
      if (wall[t][k] || next < 0 || (*inner)[next]) continue;
      (*inner)[next] = 1;
      open.push_back(next);
    }
  }
}

/// Tetrahedra on the inner side of the surface (TetGen fills hollows as well). Corners are in
/// positive order afterwards.
/// @return 1 for tetrahedra to keep; empty when a face of the surface is missing
std::vector<char> InnerTets(TetgenMesh& out, const FacesX3& faces) {
  std::map<Triple, int> surface;  // 1: found once from inside
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    surface[Rotated({faces(f, 0), faces(f, 1), faces(f, 2)})] = 0;
  const int count = SizeOf(out.tets) / 4;
  std::vector<std::array<char, 4>> wall(count);
  std::vector<char> inner(count, 0);
  std::vector<int> open;
  for (int t = 0; t < count; ++t) {
    int* corner = out.tets.data() + 4 * t;
    if (SixVolumes(out.points, corner) < 0) {
      std::swap(corner[2], corner[3]);
      std::swap(out.neighbours[4 * t + 2], out.neighbours[4 * t + 3]);
    }
    for (int k = 0; k < 4; ++k) {
      const Triple side = {corner[kFaceOpposite[k][0]], corner[kFaceOpposite[k][1]],
                           corner[kFaceOpposite[k][2]]};
      const auto out_side = surface.find(Rotated(side));
      wall[t][k] =
          out_side != surface.end() || surface.count(Rotated({side[0], side[2], side[1]})) > 0;
      if (out_side == surface.end()) continue;
      ++out_side->second;
      if (!inner[t]) {
        inner[t] = 1;
        open.push_back(t);
      }
    }
  }
  for (const auto& [side, seen] : surface)
    if (seen != 1) return {};
  Flood(out.neighbours, wall, std::move(open), &inner);
  return inner;
}

/// The result as it grows, joined at the end.
struct Parts {
  std::vector<std::array<double, 3>> inner_points;
  std::vector<int> inner_bodies;
  std::vector<std::array<int, 4>> tets, opposite;
};

void Append(const TetgenMesh& out, const std::vector<char>& inner, const Filler& filler, int body,
            int first_inner_point, Parts& parts) {
  const int surface_points = SizeOf(filler.global());
  const int tet_count = SizeOf(out.tets) / 4;
  std::vector<int> point(out.points.size() / 3, -1), tet(tet_count, -1);
  std::copy(filler.global().begin(), filler.global().end(), point.begin());
  int next_tet = SizeOf(parts.tets);
  for (int t = 0; t < tet_count; ++t)
    if (inner[t]) tet[t] = next_tet++;
  for (int t = 0; t < tet_count; ++t) {
    if (!inner[t]) continue;
    std::array<int, 4> corners, behind;
    for (int k = 0; k < 4; ++k) {
      const int p = out.tets[4 * t + k], n = out.neighbours[4 * t + k];
      if (p >= surface_points && point[p] < 0) {
        point[p] = first_inner_point + SizeOf(parts.inner_points);
        parts.inner_points.push_back(
            {out.points[3 * p], out.points[3 * p + 1], out.points[3 * p + 2]});
        parts.inner_bodies.push_back(body);
      }
      corners[k] = point[p];
      behind[k] = n < 0 ? -1 : tet[n];
    }
    parts.tets.push_back(corners);
    parts.opposite.push_back(behind);
  }
}

[[noreturn]] void ThrowUnfillable(const PointsX3& points, const FacesX3& faces,
                                  const std::string& what) {
  const std::vector<std::pair<int, int>> crossings = Crossings(points, faces);
  std::string why = "TetGen refused it; two places of its surface touch or nearly touch";
  if (!crossings.empty()) {
    const auto name = [&](int f) {
      return std::to_string(faces(f, 0)) + "," + std::to_string(faces(f, 1)) + "," +
             std::to_string(faces(f, 2));
    };
    why = "its surface passes through itself, where the face of vertices " +
          name(crossings.front().first) + " crosses that of " + name(crossings.front().second);
  }
  throw InputError(what + ": the body that holds vertex " + std::to_string(faces.minCoeff()) +
                   " cannot be filled with tetrahedra: " + why + Remedy());
}

Solid Joined(const PointsX3& points, const FacesX3& faces, Parts&& parts,
             std::vector<int>&& body_of_face, int bodies) {
  Solid solid;
  const Eigen::Index v = points.rows(), inner = std::ssize(parts.inner_points);
  solid.points.resize(v + inner, 3);
  solid.points.topRows(v) = points;
  for (Eigen::Index i = 0; i < inner; ++i)
    solid.points.row(v + i) << parts.inner_points[i][0], parts.inner_points[i][1],
        parts.inner_points[i][2];
  solid.tets.resize(std::ssize(parts.tets), 4);
  for (std::size_t t = 0; t < parts.tets.size(); ++t)
    for (int k = 0; k < 4; ++k) solid.tets(static_cast<Eigen::Index>(t), k) = parts.tets[t][k];
  solid.opposite = std::move(parts.opposite);
  solid.body_of_point.assign(v, -1);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) solid.body_of_point[faces(f, k)] = body_of_face[f];
  solid.body_of_point.insert(solid.body_of_point.end(), parts.inner_bodies.begin(),
                             parts.inner_bodies.end());
  solid.body_of_face = std::move(body_of_face);
  solid.bodies = bodies;
  return solid;
}

/// Adds one body to `parts`, as it is or with its crossings smoothed away.
/// @return false if it passes through itself, which TetGen is not asked, or TetGen failed
bool FillBody(const PointsX3& points, const FacesX3& faces, int body,
              const TetrahedralizeOptions& options, Parts& parts) {
  const Filler filler(points, faces);
  if (!Crossings(filler.points(), filler.faces()).empty()) return false;
  std::optional<TetgenMesh> mesh =
      RunTetgen(filler.points(), filler.faces(), filler.Switches(options));
  const std::vector<char> inner = mesh ? InnerTets(*mesh, filler.faces()) : std::vector<char>();
  if (inner.empty()) return false;
  Append(*mesh, inner, filler, body, static_cast<int>(points.rows()), parts);
  return true;
}

}  // namespace

Solid Tetrahedralize(const PointsX3& points, const FacesX3& faces, const std::string& what,
                     const TetrahedralizeOptions& options) {
  RequireClosed(points, faces, what);
  int bodies = 0;
  std::vector<int> body_of_face = BodiesOf(points, faces, what, bodies);
  PointsX3 filled = points;
  Parts parts;
  for (int b = 0; b < bodies; ++b) {
    const FacesX3 own = FacesOf(faces, body_of_face, b);
    if (FillBody(points, own, b, options, parts)) continue;
    const std::optional<PointsX3> apart =
        options.part_crossings ? WithoutCrossings(points, own) : std::nullopt;
    if (!apart || !FillBody(*apart, own, b, options, parts)) ThrowUnfillable(points, own, what);
    for (Eigen::Index f = 0; f < own.rows(); ++f)
      for (int k = 0; k < 3; ++k) filled.row(own(f, k)) = apart->row(own(f, k));
  }
  Solid solid = Joined(filled, faces, std::move(parts), std::move(body_of_face), bodies);
  solid.parted = static_cast<int>(((filled - points).rowwise().squaredNorm().array() > 0).count());
  return solid;
}

}  // namespace keypose::interpolation
