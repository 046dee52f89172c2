#include "texture/unwrap/layout_check.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"
#include "core/values/union_find.h"
#include "texture/charts/parametrise.h"

namespace keypose::texture {
namespace {

const double kGrid = std::ldexp(1.0, 40);

struct Int2 {
  std::int64_t x, y;
  bool operator==(const Int2&) const = default;
};
using Edge = std::pair<int, int>;  // directed, surface to the left

// Sign of twice the area; coordinates are below 2^41, so 128 bits are sufficient.
int Turn(const Int2& a, const Int2& b, const Int2& c) {
  const __int128 det = static_cast<__int128>(b.x - a.x) * (c.y - a.y) -
                       static_cast<__int128>(b.y - a.y) * (c.x - a.x);
  return (det > 0) - (det < 0);
}

bool Between(const Int2& a, const Int2& b, const Int2& p) {
  return std::min(a.x, b.x) <= p.x && p.x <= std::max(a.x, b.x) && std::min(a.y, b.y) <= p.y &&
         p.y <= std::max(a.y, b.y);
}

bool Meet(const Int2& a, const Int2& b, const Int2& c, const Int2& d) {
  const int abc = Turn(a, b, c), abd = Turn(a, b, d), cda = Turn(c, d, a), cdb = Turn(c, d, b);
  if (abc * abd < 0 && cda * cdb < 0) return true;
  return (abc == 0 && Between(a, b, c)) || (abd == 0 && Between(a, b, d)) ||
         (cda == 0 && Between(c, d, a)) || (cdb == 0 && Between(c, d, b));
}

struct Atlas {
  std::vector<Int2> points;
  std::vector<int> chart;  // per UV vertex, -1: unused
  int charts = 0;
  std::vector<std::vector<int>> rims;  // per chart: UV vertices along the boundary
};

void NumberCharts(const Mesh& mesh, Atlas& atlas) {
  UnionFind joined(mesh.uvs.rows());
  for (int f = 0; f < mesh.face_count(); ++f) {
    joined.Join(mesh.uv_faces(f, 0), mesh.uv_faces(f, 1));
    joined.Join(mesh.uv_faces(f, 1), mesh.uv_faces(f, 2));
  }
  std::map<int, int> id;
  atlas.chart.assign(mesh.uvs.rows(), -1);
  for (int f = 0; f < mesh.face_count(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int v = mesh.uv_faces(f, k);
      atlas.chart[v] = id.emplace(joined.Find(v), SizeOf(id)).first->second;
    }
  atlas.charts = SizeOf(id);
}

// Follows each chart's boundary. A chart is a disk when it is a manifold with one loop and V - E +
// F = 1.
int NonDisks(const Mesh& mesh, Atlas& atlas) {
  std::set<Edge> edges;
  std::vector<int> euler(atlas.charts, 0), boundary(atlas.charts, 0);
  std::vector<char> bad(atlas.charts, 0);
  for (int f = 0; f < mesh.face_count(); ++f) {
    const int chart = atlas.chart[mesh.uv_faces(f, 0)];
    ++euler[chart];
    for (int k = 0; k < 3; ++k)
      if (!edges.emplace(mesh.uv_faces(f, k), mesh.uv_faces(f, (k + 1) % 3)).second) bad[chart] = 1;
  }
  std::vector<int> next(mesh.uvs.rows(), -1);
  for (const auto& [a, b] : edges) {
    const int chart = atlas.chart[a];
    const bool rim = !edges.contains({b, a});
    if (rim || a < b) --euler[chart];
    if (!rim) continue;
    ++boundary[chart];
    if (next[a] >= 0) bad[chart] = 1;
    next[a] = b;
  }
  atlas.rims.resize(atlas.charts);
  for (int v = 0; v < static_cast<int>(mesh.uvs.rows()); ++v) {
    const int chart = atlas.chart[v];
    if (chart < 0) continue;
    ++euler[chart];
    if (next[v] < 0 || !atlas.rims[chart].empty()) continue;
    for (int w = v; w >= 0 && (w != v || atlas.rims[chart].empty()) &&
                    SizeOf(atlas.rims[chart]) <= boundary[chart];
         w = next[w])
      atlas.rims[chart].push_back(w);
  }
  int count = 0;
  for (int c = 0; c < atlas.charts; ++c)
    count += bad[c] || euler[c] != 1 || boundary[c] < 3 || SizeOf(atlas.rims[c]) != boundary[c];
  return count;
}

// A sweep over all boundary edges of all charts.
int Crossings(const Atlas& atlas) {
  std::vector<Edge> edges;
  for (const std::vector<int>& rim : atlas.rims)
    for (std::size_t i = 0; i < rim.size(); ++i)
      edges.emplace_back(rim[i], rim[(i + 1) % rim.size()]);
  const auto left = [&](const Edge& e) {
    return std::min(atlas.points[e.first].x, atlas.points[e.second].x);
  };
  const auto right = [&](const Edge& e) {
    return std::max(atlas.points[e.first].x, atlas.points[e.second].x);
  };
  std::sort(edges.begin(), edges.end(), [&](const Edge& a, const Edge& b) {
    return left(a) != left(b) ? left(a) < left(b) : a < b;
  });
  int count = 0;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const auto& [a, b] = edges[i];
    for (std::size_t j = i + 1; j < edges.size() && left(edges[j]) <= right(edges[i]); ++j) {
      const auto& [c, d] = edges[j];
      const Int2 &pa = atlas.points[a], &pb = atlas.points[b], &pc = atlas.points[c],
                 &pd = atlas.points[d];
      if (a == d || b == c) {
        // Adjacent edges share a corner. They intersect only if one folds back onto the other,
        // which one of the other two ends shows.
        const Int2 &shared = a == d ? pa : pb, &p = a == d ? pb : pa, &q = a == d ? pc : pd;
        const bool folded =
            Turn(shared, p, q) == 0 && (Between(shared, p, q) || Between(shared, q, p));
        count += folded;
      } else {
        count += Meet(pa, pb, pc, pd);
      }
    }
  }
  return count;
}

bool Inside(const Int2& p, const std::vector<int>& rim, const std::vector<Int2>& points) {
  bool inside = false;
  for (std::size_t i = 0; i < rim.size(); ++i) {
    const Int2 &a = points[rim[i]], &b = points[rim[(i + 1) % rim.size()]];
    if ((a.y > p.y) == (b.y > p.y)) continue;
    if ((Turn(a, b, p) > 0) == (b.y > a.y)) inside = !inside;
  }
  return inside;
}

int Nested(const Atlas& atlas) {
  int count = 0;
  for (int c = 0; c < atlas.charts; ++c) {
    if (atlas.rims[c].empty()) continue;
    for (int other = 0; other < atlas.charts; ++other) {
      if (other == c || !Inside(atlas.points[atlas.rims[c][0]], atlas.rims[other], atlas.points))
        continue;
      ++count;
      break;
    }
  }
  return count;
}

}  // namespace

UvsX2 OnGrid(const UvsX2& uvs) { return (uvs.array() * kGrid).round() / kGrid; }

AtlasFaults FindAtlasFaults(const Mesh& mesh) {
  AtlasFaults faults;
  Atlas atlas;
  for (int v = 0; v < static_cast<int>(mesh.uvs.rows()); ++v) {
    const Eigen::RowVector2d uv = mesh.uvs.row(v), scaled = uv * kGrid;
    const bool good = (uv.array() >= 0).all() && (uv.array() <= 1).all() &&
                      (scaled.array() == scaled.array().round()).all();
    faults.outside += !good;
    atlas.points.push_back(
        good ? Int2{static_cast<std::int64_t>(scaled.x()), static_cast<std::int64_t>(scaled.y())}
             : Int2{0, 0});
  }
  for (int f = 0; f < mesh.face_count(); ++f)
    faults.flipped += Turn(atlas.points[mesh.uv_faces(f, 0)], atlas.points[mesh.uv_faces(f, 1)],
                           atlas.points[mesh.uv_faces(f, 2)]) <= 0;
  NumberCharts(mesh, atlas);
  faults.not_disks = NonDisks(mesh, atlas);
  faults.crossings = Crossings(atlas);
  faults.nested = Nested(atlas);
  return faults;
}

AtlasStretch MeasureAtlasStretch(const Mesh& mesh) {
  AtlasStretch out;
  double flat = 0, area = 0, square = 0;
  std::vector<std::pair<double, double>> ratios;  // ratio, area
  const Eigen::VectorXd areas = FaceAreas(mesh.points, mesh.faces);
  std::vector<double> flats(mesh.face_count());
  for (int f = 0; f < mesh.face_count(); ++f) {
    Eigen::Vector3d p[3];
    Eigen::Vector2d q[3];
    for (int k = 0; k < 3; ++k) {
      p[k] = mesh.points.row(mesh.faces(f, k));
      q[k] = mesh.uvs.row(mesh.uv_faces(f, k));
    }
    const Eigen::Vector2d s = Stretches(p[0], p[1], p[2], q[0], q[1], q[2]);
    flats[f] = s[0] * s[1] * areas[f];
    flat += flats[f];
    area += areas[f];
    square += areas[f] * (1 / (s[0] * s[0]) + 1 / (s[1] * s[1])) / 2;
    out.linf = std::max(out.linf, 1 / s[1]);
    ratios.emplace_back(s[0] / s[1], areas[f]);
    out.conformal_mean += areas[f] * s[0] / s[1];
  }
  const double density = std::sqrt(flat / area);
  out.l2 = std::sqrt(square / area) * density;
  out.linf *= density;
  out.conformal_mean /= area;
  out.utilisation = flat;
  for (int f = 0; f < mesh.face_count(); ++f)
    out.area_deviation += std::abs(flats[f] * area / flat - areas[f]) / area;
  std::sort(ratios.begin(), ratios.end());
  double below = 0;
  for (const auto& [ratio, weight] : ratios) {
    below += weight;
    out.conformal_p99 = ratio;
    if (below >= 0.99 * area) break;
  }
  return out;
}

}  // namespace keypose::texture
