#include "synth/worlds/polygonize.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <unordered_map>
#include <vector>

#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::synth {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

// Body-centred lattice in integer coordinates: all even at cube corners, all odd at cube centres.
struct Lattice {
  Vector3d low;
  double half;     // half of a cube's edge
  Vector3i cubes;  // cubes along each axis
  std::int64_t Key(const Vector3i& p) const {
    const std::int64_t nx = 2 * cubes[0] + 3, ny = 2 * cubes[1] + 3;
    return (static_cast<std::int64_t>(p[2] + 1) * ny + (p[1] + 1)) * nx + (p[0] + 1);
  }
  Vector3d At(const Vector3i& p) const { return low + half * p.cast<double>(); }
};

constexpr int kBlock = 4;  // cubes along a block's edge

// Blocks of cubes that the surface may cross, judged by the field's value at their centre.
std::vector<Vector3i> NearBlocks(const std::function<double(const Vector3d&)>& f,
                                 const Lattice& lattice, double lipschitz) {
  const Vector3i count = (lattice.cubes.array() + kBlock - 1) / kBlock;
  const std::int64_t total = static_cast<std::int64_t>(count[0]) * count[1] * count[2];
  std::vector<char> near(total, 0);
  // Tetrahedra extend half a cube beyond the block's sides.
  const double reach = lipschitz * std::sqrt(3.0) * lattice.half * (kBlock + 1);
  const auto block_at = [&](std::int64_t i) {
    return Vector3i(static_cast<int>(i % count[0]), static_cast<int>(i / count[0] % count[1]),
                    static_cast<int>(i / count[0] / count[1]));
  };
  ParallelFor(
      total,
      [&](std::int64_t i) {
        const Vector3i corner = 2 * kBlock * block_at(i);
        near[i] = std::abs(f(lattice.At(corner + Vector3i::Constant(kBlock)))) < reach;
      },
      64);
  std::vector<Vector3i> blocks;
  for (std::int64_t i = 0; i < total; ++i)
    if (near[i]) blocks.push_back(block_at(i));
  return blocks;
}

// A cut of a lattice edge by the surface: the edge's end points, the inner first, and the cut's
// position.
struct Cut {
  Vector3i inside, outside;
  double f_inside, f_outside;
};

// The faces of a block; their corners are cuts.
struct Piece {
  std::vector<Cut> cuts;  // three consecutive cuts form a face
};

class BlockMarcher {
 public:
  BlockMarcher(const std::function<double(const Vector3d&)>& f, const Lattice& lattice,
               const Vector3i& block)
      : f_(f),
        lattice_(lattice),
        first_(2 * kBlock * block - Vector3i::Ones()),
        values_(kSide * kSide * kSide, std::numeric_limits<double>::quiet_NaN()) {}

  // Four tetrahedra around every edge between neighbouring centres. A block owns the edges from its
  // own centres in positive directions.
  Piece March(const Vector3i& block) {
    for (int z = 0; z < kBlock; ++z)
      for (int y = 0; y < kBlock; ++y)
        for (int x = 0; x < kBlock; ++x) {
          const Vector3i cube = kBlock * block + Vector3i(x, y, z);
          if ((cube.array() >= lattice_.cubes.array()).any()) continue;
          for (int axis = 0; axis < 3; ++axis) AroundEdge(2 * cube + Vector3i::Ones(), axis);
        }
    return std::move(piece_);
  }

 private:
  static constexpr int kSide = 2 * kBlock + 4;

  double Value(const Vector3i& p) {
    const Vector3i q = p - first_;
    double& value = values_[(static_cast<std::size_t>(q[2]) * kSide + q[1]) * kSide + q[0]];
    if (std::isnan(value)) value = f_(lattice_.At(p));
    return value;
  }

  void AroundEdge(const Vector3i& center, int axis) {
    const Vector3i up = Vector3i::Unit(axis), u = Vector3i::Unit((axis + 1) % 3),
                   v = Vector3i::Unit((axis + 2) % 3);
    const Vector3i next = center + 2 * up, middle = center + up;
    const Vector3i ring[4] = {middle + u + v, middle - u + v, middle - u - v,
                              middle + u - v};  // counter-clockwise seen from next
    for (int k = 0; k < 4; ++k) Tetrahedron({center, next, ring[k], ring[(k + 1) % 4]});
  }

  // p must be positively oriented: (p1-p0) x (p2-p0) . (p3-p0) > 0.
  void Tetrahedron(const std::array<Vector3i, 4>& p) {
    double value[4];
    int in[4], out[4], in_count = 0, out_count = 0;
    for (int i = 0; i < 4; ++i) {
      value[i] = Value(p[i]);
      if (value[i] < 0)
        in[in_count++] = i;
      else
        out[out_count++] = i;
    }
    if (in_count == 0 || out_count == 0) return;
    const auto cut = [&](int a, int b) { return Cut{p[a], p[b], value[a], value[b]}; };
    const auto odd = [](int a, int b, int c, int d) {  // parity of the permutation (a b c d)
      const int order[4] = {a, b, c, d};
      int inversions = 0;
      for (int i = 0; i < 4; ++i)
        for (int j = i + 1; j < 4; ++j) inversions += order[i] > order[j];
      return inversions % 2 == 1;
    };
    if (in_count == 1) {
      // Seen from outside, the cuts around a single inner vertex have the orientation of the
      // opposite face.
      Face(cut(in[0], out[0]), cut(in[0], out[1]), cut(in[0], out[2]),
           odd(in[0], out[0], out[1], out[2]));
    } else if (out_count == 1) {
      Face(cut(in[0], out[0]), cut(in[1], out[0]), cut(in[2], out[0]),
           !odd(out[0], in[0], in[1], in[2]));
    } else {
      const bool flip = odd(in[0], in[1], out[0], out[1]);
      const Cut a = cut(in[0], out[0]), b = cut(in[0], out[1]), c = cut(in[1], out[1]),
                d = cut(in[1], out[0]);
      Face(a, b, c, flip);
      Face(a, c, d, flip);
    }
  }

  void Face(const Cut& a, const Cut& b, const Cut& c, bool flip) {
    piece_.cuts.push_back(a);
    piece_.cuts.push_back(flip ? c : b);
    piece_.cuts.push_back(flip ? b : c);
  }

  const std::function<double(const Vector3d&)>& f_;
  const Lattice& lattice_;
  Vector3i first_;
  std::vector<double> values_;
  Piece piece_;
};

struct PairHash {
  std::size_t operator()(const std::pair<std::int64_t, std::int64_t>& p) const {
    std::uint64_t h = static_cast<std::uint64_t>(p.first) * 0x9e3779b97f4a7c15ULL ^
                      static_cast<std::uint64_t>(p.second) * 0xc2b2ae3d27d4eb4fULL;
    return static_cast<std::size_t>(h ^ h >> 29);
  }
};

Vector3d PointOfCut(const std::function<double(const Vector3d&)>& f, const Lattice& lattice,
                    const Cut& cut) {
  const Vector3d a = lattice.At(cut.inside), b = lattice.At(cut.outside);
  // Regula falsi with the Illinois rule (halves the value of a stuck end), since the field is
  // curved where lumps meet.
  double low = 0, high = 1, f_low = cut.f_inside, f_high = cut.f_outside, t = 0.5;
  int stuck = 0;
  for (int i = 0; i < 20; ++i) {
    t = low + (high - low) * f_low / (f_low - f_high);
    const double value = f(a + t * (b - a));
    if (std::abs(value) < 1e-7 * lattice.half) break;
    if (value < 0) {
      low = t;
      f_low = value;
      if (stuck < 0) f_high /= 2;
      stuck = -1;
    } else {
      high = t;
      f_high = value;
      if (stuck > 0) f_low /= 2;
      stuck = 1;
    }
  }
  t = std::clamp(t, 0.02,
                 0.98);  // keeps cuts away from lattice points, so that every face has an area
  return a + t * (b - a);
}

Mesh Join(const std::function<double(const Vector3d&)>& f, const Lattice& lattice,
          const std::vector<Piece>& pieces) {
  std::size_t corners = 0;
  for (const Piece& piece : pieces) corners += piece.cuts.size();
  std::unordered_map<std::pair<std::int64_t, std::int64_t>, int, PairHash> index;
  index.reserve(corners / 4);
  std::vector<const Cut*> cuts;
  Mesh mesh;
  mesh.faces.resize(static_cast<Eigen::Index>(corners / 3), 3);
  int* corner = mesh.faces.data();
  for (const Piece& piece : pieces)
    for (const Cut& cut : piece.cuts) {
      const auto [it, is_new] =
          index.try_emplace({lattice.Key(cut.inside), lattice.Key(cut.outside)}, SizeOf(cuts));
      if (is_new) cuts.push_back(&cut);
      *corner++ = it->second;
    }
  mesh.points.resize(std::ssize(cuts), 3);
  const auto place = [&](std::int64_t i) {
    mesh.points.row(i) = PointOfCut(f, lattice, *cuts[i]).transpose();
  };
  ParallelFor(std::ssize(cuts), place, 256);
  return mesh;
}

}  // namespace

Mesh Polygonize(const std::function<double(const Vector3d&)>& f, const Vector3d& low,
                const Vector3d& high, double spacing, double lipschitz) {
  Lattice lattice{low, spacing / 2, Vector3i::Zero()};
  for (int k = 0; k < 3; ++k) {
    const double cubes = std::ceil((high[k] - low[k]) / spacing);
    if (!(spacing > 0) || !(cubes >= 1 && cubes < 4000))
      throw InputError(
          "synth: the spacing does not suit the box; between 1 and 4000 cubes along each axis");
    lattice.cubes[k] = static_cast<int>(cubes);
  }
  const std::vector<Vector3i> blocks = NearBlocks(f, lattice, lipschitz);
  std::vector<Piece> pieces(blocks.size());
  ParallelFor(
      std::ssize(blocks),
      [&](std::int64_t i) { pieces[i] = BlockMarcher(f, lattice, blocks[i]).March(blocks[i]); }, 8);
  Mesh mesh = Join(f, lattice, pieces);
  if (mesh.faces.rows() == 0)
    throw InputError("synth: there is no solid inside the box, or it is smaller than the spacing");
  return mesh;
}

}  // namespace keypose::synth
