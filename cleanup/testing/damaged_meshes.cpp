#include "cleanup/testing/damaged_meshes.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <vector>

#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/size_of.h"

namespace keypose::cleanup {
namespace {

using Cell = std::array<int, 3>;

// std::uniform_* distributions differ between standard libraries; these do not.
struct FixedRandom {
  std::mt19937_64 engine;
  explicit FixedRandom(std::uint64_t seed) : engine(seed * 0x9E3779B97F4A7C15ull + 17) {}
  double Unit() { return static_cast<double>(engine() >> 11) * 0x1.0p-53; }
  int Below(int count) { return static_cast<int>(Unit() * count); }
};

void AddBox(std::set<Cell>& cells, Cell low, Cell high) {
  for (int x = low[0]; x < high[0]; ++x)
    for (int y = low[1]; y < high[1]; ++y)
      for (int z = low[2]; z < high[2]; ++z) cells.insert({x, y, z});
}

// The outer surface of the cells, each square split in two triangles.
Mesh Skin(const std::set<Cell>& cells) {
  std::map<Cell, int> ids;
  std::vector<Cell> corners;
  std::vector<std::array<int, 3>> faces;
  const auto id = [&](const Cell& c) {
    const auto [it, is_new] = ids.emplace(c, SizeOf(corners));
    if (is_new) corners.push_back(c);
    return it->second;
  };
  for (const Cell& cell : cells)
    for (int axis = 0; axis < 3; ++axis)
      for (int side = 0; side < 2; ++side) {
        Cell next = cell;
        next[axis] += side ? 1 : -1;
        if (cells.count(next)) continue;
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        Cell c[4] = {cell, cell, cell, cell};
        for (Cell& corner : c) corner[axis] += side;
        ++c[1][u], ++c[2][u], ++c[2][v], ++c[3][v];
        int q[4];
        for (int k = 0; k < 4; ++k) q[k] = id(c[k]);
        if (!side) std::swap(q[1], q[3]);
        faces.push_back({q[0], q[1], q[2]});
        faces.push_back({q[0], q[2], q[3]});
      }
  Mesh mesh;
  mesh.points.resize(SizeOf(corners), 3);
  for (int v = 0; v < mesh.vertex_count(); ++v)
    mesh.points.row(v) << corners[v][0], corners[v][1], corners[v][2];
  mesh.faces.resize(SizeOf(faces), 3);
  for (int f = 0; f < mesh.face_count(); ++f)
    mesh.faces.row(f) << faces[f][0], faces[f][1], faces[f][2];
  return mesh;
}

void Smooth(Mesh& mesh, int rounds) {
  for (int round = 0; round < rounds; ++round) {
    PointsX3 sum = PointsX3::Zero(mesh.vertex_count(), 3);
    Eigen::VectorXd count = Eigen::VectorXd::Zero(mesh.vertex_count());
    for (const auto& [a, b] : UndirectedEdges(mesh.faces)) {
      sum.row(a) += mesh.points.row(b);
      sum.row(b) += mesh.points.row(a);
      ++count[a], ++count[b];
    }
    mesh.points = 0.5 * mesh.points + 0.5 * sum.cwiseQuotient(count.replicate(1, 3));
  }
}

using Damage = std::function<void(Mesh&, FixedRandom&)>;

void DeleteFaces(Mesh& mesh, FixedRandom& random) {
  int count = 0;
  for (int f = 0; f < mesh.face_count(); ++f)
    if (random.Unit() >= 0.05) mesh.faces.row(count++) = mesh.faces.row(f).eval();
  mesh.faces.conservativeResize(count, 3);
}

void FlipFaces(Mesh& mesh, FixedRandom& random) {
  for (int f = 0; f < mesh.face_count(); ++f)
    if (random.Unit() < 0.1) std::swap(mesh.faces(f, 1), mesh.faces(f, 2));
}

// Some pairs are neighbours, some lie on opposite sides of the shape.
void WeldVertices(Mesh& mesh, FixedRandom& random) {
  const int pairs = 1 + random.Below(6);
  for (int i = 0; i < pairs; ++i) {
    const int a = random.Below(mesh.vertex_count());
    const int b =
        i % 2 ? random.Below(mesh.vertex_count()) : mesh.faces(random.Below(mesh.face_count()), 0);
    for (int f = 0; f < mesh.face_count(); ++f)
      for (int k = 0; k < 3; ++k)
        if (mesh.faces(f, k) == a) mesh.faces(f, k) = b;
  }
}

void AddFins(Mesh& mesh, FixedRandom& random) {
  const int fins = 1 + random.Below(20), vertices = mesh.vertex_count(), faces = mesh.face_count();
  const double length = 0.2 * BoundingDiagonal(mesh.points);
  mesh.points.conservativeResize(vertices + fins, 3);
  mesh.faces.conservativeResize(faces + fins, 3);
  for (int i = 0; i < fins; ++i) {
    const int f = random.Below(faces), a = mesh.faces(f, 0), b = mesh.faces(f, 1);
    const Eigen::RowVector3d away(random.Unit() - 0.5, random.Unit() - 0.5, random.Unit() - 0.5);
    mesh.points.row(vertices + i) = mesh.points.row(a) + length * away;
    mesh.faces.row(faces + i) << a, b, vertices + i;
  }
}

// An exact copy, one slightly moved (so that it intersects everywhere), or one smaller and inside
// out.
void DuplicateShell(Mesh& mesh, FixedRandom& random) {
  Mesh twin = mesh;
  const int kind = random.Below(3);
  if (kind == 1)
    twin.points.rowwise() +=
        Eigen::RowVector3d(0.3, 0.7, 0.2) * (0.01 * BoundingDiagonal(mesh.points));
  if (kind == 2) {
    const Eigen::RowVector3d center = mesh.points.colwise().mean();
    twin.points = ((mesh.points.rowwise() - center) * 0.97).rowwise() + center;
    twin.faces.col(1).swap(twin.faces.col(2));
  }
  mesh = Together(mesh, twin);
}

void Shake(Mesh& mesh, FixedRandom& random) {
  const double reach = 0.01 * BoundingDiagonal(mesh.points);
  for (int v = 0; v < mesh.vertex_count(); ++v)
    for (int k = 0; k < 3; ++k) mesh.points(v, k) += reach * (random.Unit() - 0.5);
}

void Unweld(Mesh& mesh, FixedRandom&) {
  PointsX3 points(3 * mesh.face_count(), 3);
  for (int f = 0; f < mesh.face_count(); ++f)
    for (int k = 0; k < 3; ++k) points.row(3 * f + k) = mesh.points.row(mesh.faces(f, k));
  for (int f = 0; f < mesh.face_count(); ++f) mesh.faces.row(f) << 3 * f, 3 * f + 1, 3 * f + 2;
  mesh.points = points;
}

void PlantNan(Mesh& mesh, FixedRandom& random) {
  for (int i = 0; i < 3; ++i)
    mesh.points(random.Below(mesh.vertex_count()), random.Below(3)) =
        std::numeric_limits<double>::quiet_NaN();
}

struct NamedDamage {
  const char* name;
  Damage apply;
};

const std::vector<NamedDamage>& Kinds() {
  static const std::vector<NamedDamage> kinds = {{"5 % of the faces deleted", DeleteFaces},
                                                 {"10 % of the faces flipped", FlipFaces},
                                                 {"random vertices welded", WeldVertices},
                                                 {"fins", AddFins},
                                                 {"a second shell", DuplicateShell},
                                                 {"vertices shaken", Shake},
                                                 {"unwelded", Unweld}};
  return kinds;
}

struct Shape {
  std::string name;
  Mesh mesh;
};

Shape BaseShape(int index) {
  switch (index % 5) {
    case 0:
      return {"sphere", MakeIcosphere(3)};
    case 1:
      return {"torus", MakeTorus(1, 0.35, 36, 16)};
    case 2:
      return {"figure", MakeFigure(static_cast<std::uint64_t>(index), 3)};
    case 3:
      return {"figure with thin limbs", MakeFigure(static_cast<std::uint64_t>(index), 1)};
    default:
      return {"rod", MakeCylinder(0.02, 1, 10, 60)};
  }
}

}  // namespace

Mesh MakeTorus(double radius, double tube, int n, int m) {
  Mesh torus;
  torus.points.resize(n * m, 3);
  torus.faces.resize(2 * n * m, 3);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < m; ++j) {
      const double a = 2 * EIGEN_PI * i / n, b = 2 * EIGEN_PI * j / m,
                   r = radius + tube * std::cos(b);
      torus.points.row(i * m + j) << r * std::cos(a), r * std::sin(a), tube * std::sin(b);
      const int p = i * m + j, q = (i + 1) % n * m + j, s = (i + 1) % n * m + (j + 1) % m,
                t = i * m + (j + 1) % m;
      torus.faces.row(2 * p) << p, q, s;
      torus.faces.row(2 * p + 1) << p, s, t;
    }
  return torus;
}

Mesh MakeRevolved(const std::vector<Eigen::Vector2d>& profile, int n) {
  const int rings = SizeOf(profile);
  Mesh mesh;
  mesh.points.resize(rings * n + 2, 3);
  for (int r = 0; r < rings; ++r)
    for (int i = 0; i < n; ++i) {
      const double a = 2 * EIGEN_PI * i / n;
      mesh.points.row(r * n + i) << profile[r].x() * std::cos(a), profile[r].x() * std::sin(a),
          profile[r].y();
    }
  mesh.points.row(rings * n) << 0, 0, profile.front().y();
  mesh.points.row(rings * n + 1) << 0, 0, profile.back().y();
  mesh.faces.resize(2 * n * rings, 3);
  int f = 0;
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n, last = (rings - 1) * n;
    for (int r = 0; r + 1 < rings; ++r) {
      mesh.faces.row(f++) << r * n + i, (r + 1) * n + i, (r + 1) * n + j;
      mesh.faces.row(f++) << r * n + i, (r + 1) * n + j, r * n + j;
    }
    mesh.faces.row(f++) << rings * n, i, j;
    mesh.faces.row(f++) << rings * n + 1, last + j, last + i;
  }
  return mesh;
}

Mesh MakeFigure(std::uint64_t seed, int limb) {
  FixedRandom random(seed);
  std::set<Cell> cells;
  const int arm = 6 + random.Below(5), leg = 5 + random.Below(5), head = 3 + random.Below(3);
  AddBox(cells, {0, 0, 0}, {8, 5, 10});
  AddBox(cells, {4 - head / 2, 0, 10}, {4 - head / 2 + head, 4, 10 + head});
  AddBox(cells, {-arm, 1, 9 - limb}, {0, 1 + limb, 9});
  AddBox(cells, {8, 1, 9 - limb}, {8 + arm, 1 + limb, 9});
  AddBox(cells, {0, 1, -leg}, {limb, 1 + limb, 0});
  AddBox(cells, {8 - limb, 1, -leg}, {8, 1 + limb, 0});
  Mesh mesh = Skin(cells);
  Smooth(mesh, limb == 1 ? 1 : 3);
  mesh.points *= 0.01;
  return mesh;
}

Mesh Together(const Mesh& a, const Mesh& b) {
  Mesh out;
  out.points.resize(a.points.rows() + b.points.rows(), 3);
  out.points << a.points, b.points;
  out.faces.resize(a.faces.rows() + b.faces.rows(), 3);
  out.faces << a.faces, b.faces.array() + a.vertex_count();
  return out;
}

DamagedMesh MakeDamagedMesh(int index) {
  FixedRandom random(1000003ull * static_cast<std::uint64_t>(index) + 1);
  const Shape shape = BaseShape(index);
  DamagedMesh out{shape.mesh, shape.name + ":"};
  // The first kind cycles, so that each kind is combined with each shape. Up to three more are
  // random.
  const int kinds = SizeOf(Kinds()), first = index / 5 % (kinds + 1), more = random.Below(4);
  if (first < kinds) {
    out.description += std::string(" ") + Kinds()[first].name;
    Kinds()[first].apply(out.mesh, random);
  }
  for (int i = 0; i < more; ++i) {
    const NamedDamage& kind = Kinds()[random.Below(kinds)];
    out.description += std::string(", ") + kind.name;
    kind.apply(out.mesh, random);
  }
  if (first == kinds) {
    out.description += " NaNs";
    PlantNan(out.mesh, random);
  }
  return out;
}

}  // namespace keypose::cleanup
