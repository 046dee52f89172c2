#include "texture/unwrap.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/errors.h"
#include "core/geometry.h"
#include "core/parallel.h"
#include "texture/charts.h"
#include "texture/packing.h"
#include "texture/packing_press.h"
#include "texture/parametrise.h"

namespace keypose::texture {
namespace {

constexpr int kFacesPerChart = 300;  // at the start, before charts are merged
constexpr int kLloydRounds = 6;
constexpr int kRounds = 25;  // of flattening while charts are cut and merged
constexpr int kFinalRounds = 200;
constexpr int kSmoothPasses = 4;
constexpr double kLargestShare = 0.12;  // of the whole area in one chart: larger ones pack badly
constexpr double kP99Distortion = 2;    // within a chart
constexpr double kWorstDistortion = 8;
constexpr double kLeastFlatness = 0.35;  // |sum of normals| / area below which a merge is not even tried

struct FlatChart {
  Chart chart;
  UvsX2 uvs;
};

/// Charts that are cut until each lies flat, then joined while they still do.
class Atlas {
 public:
  Atlas(const Surface& surface, double max_distortion, Progress* progress)
      : surface_(surface), max_distortion_(max_distortion), progress_(progress) {}

  void Cut();
  void Join();
  void Smooth();
  void Refine();
  std::vector<FlatChart>& charts() { return charts_; }

 private:
  std::optional<FlatChart> TryFlat(std::vector<int> faces, int rounds) const;
  void Settle(std::vector<std::vector<int>> work);
  std::map<std::pair<int, int>, double> SharedLengths() const;
  double Perimeter(const FlatChart& chart) const;
  bool WorthJoining(const FlatChart& a, const FlatChart& b) const;
  bool JoinRound(std::set<std::pair<int, int>>& failed);

  const Surface& surface_;
  double max_distortion_;
  Progress* progress_;
  std::vector<FlatChart> charts_;
};

std::optional<FlatChart> Atlas::TryFlat(std::vector<int> faces, int rounds) const {
  FlatChart flat;
  flat.chart = MakeChart(surface_, std::move(faces));
  if (!flat.chart.disk) return std::nullopt;
  std::optional<UvsX2> uvs = Flattened(surface_, flat.chart, rounds);
  if (!uvs) return std::nullopt;
  if (flat.chart.faces.size() > 1) {
    const Distortion distortion = MeasureDistortion(surface_, flat.chart, *uvs);
    if (!(distortion.mean <= max_distortion_) || !(distortion.p99 <= kP99Distortion) || !(distortion.max <= kWorstDistortion))
      return std::nullopt;
  }
  flat.uvs = std::move(*uvs);
  return flat;
}

// Each round tries all open pieces side by side, and halves those that failed; a single triangle always lies flat.
void Atlas::Settle(std::vector<std::vector<int>> work) {
  while (!work.empty()) {
    Step(progress_, 0.2, "flattening " + std::to_string(work.size()) + " charts");
    std::vector<std::optional<FlatChart>> flats(work.size());
    ParallelFor(static_cast<std::int64_t>(work.size()), [&](std::int64_t i) { flats[i] = TryFlat(work[i], kRounds); });
    std::vector<std::vector<int>> next;
    for (std::size_t i = 0; i < work.size(); ++i) {
      if (flats[i]) {
        charts_.push_back(std::move(*flats[i]));
        continue;
      }
      if (work[i].size() == 1)
        throw InputError("unwrap: face " + std::to_string(work[i][0]) + " has practically no area; run cleanup on the mesh first");
      for (std::vector<int>& half : Halved(surface_, work[i])) next.push_back(std::move(half));
    }
    work = std::move(next);
  }
}

void Atlas::Cut() {
  const int faces = static_cast<int>(surface_.faces.rows());
  const std::vector<int> label = CutIntoCharts(surface_, std::clamp(faces / kFacesPerChart, 1, 120), kLloydRounds);
  std::vector<std::vector<int>> work(*std::max_element(label.begin(), label.end()) + 1);
  for (int f = 0; f < faces; ++f) work[label[f]].push_back(f);
  std::erase_if(work, [](const std::vector<int>& faces_of) { return faces_of.empty(); });
  Settle(std::move(work));
}

std::map<std::pair<int, int>, double> Atlas::SharedLengths() const {
  std::vector<int> owner(surface_.faces.rows());
  for (int c = 0; c < static_cast<int>(charts_.size()); ++c)
    for (const int f : charts_[c].chart.faces) owner[f] = c;
  std::map<std::pair<int, int>, double> shared;
  for (int f = 0; f < static_cast<int>(owner.size()); ++f) {
    for (int k = 0; k < 3; ++k) {
      const int other = owner[surface_.neighbors(f, k)];
      if (other <= owner[f]) continue;
      shared[{owner[f], other}] += (surface_.points.row(surface_.faces(f, k)) - surface_.points.row(surface_.faces(f, (k + 1) % 3))).norm();
    }
  }
  return shared;
}

double Atlas::Perimeter(const FlatChart& flat) const {
  const std::vector<int>& rim = flat.chart.rim;
  double length = 0;
  for (std::size_t i = 0; i < rim.size(); ++i)
    length +=
        (surface_.points.row(flat.chart.vertices[rim[i]]) - surface_.points.row(flat.chart.vertices[rim[(i + 1) % rim.size()]])).norm();
  return length;
}

// Charts that would bend around too far cannot lie flat; asking that first saves most attempts.
bool Atlas::WorthJoining(const FlatChart& a, const FlatChart& b) const {
  Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
  double area = 0;
  for (const FlatChart* flat : {&a, &b}) {
    for (const int f : flat->chart.faces) {
      sum += surface_.areas[f] * surface_.normals.row(f);
      area += surface_.areas[f];
    }
  }
  return area <= kLargestShare * surface_.areas.sum() && sum.norm() >= kLeastFlatness * area;
}

// Goes once over the pairs, those that share most of their rims first; each chart takes part in one merge a round.
bool Atlas::JoinRound(std::set<std::pair<int, int>>& failed) {
  std::vector<double> perimeter;
  for (const FlatChart& flat : charts_) perimeter.push_back(Perimeter(flat));
  std::vector<std::tuple<double, int, int>> pairs;
  for (const auto& [pair, length] : SharedLengths()) {
    const auto [a, b] = pair;
    const std::pair<int, int> name = std::minmax(charts_[a].chart.faces.front(), charts_[b].chart.faces.front());
    if (failed.contains(name)) continue;
    pairs.emplace_back(-length / std::min(perimeter[a], perimeter[b]), a, b);
  }
  std::sort(pairs.begin(), pairs.end());
  std::vector<char> used(charts_.size(), 0);
  bool joined = false;
  for (const auto& [score, a, b] : pairs) {
    if (used[a] || used[b]) continue;
    const std::pair<int, int> name = std::minmax(charts_[a].chart.faces.front(), charts_[b].chart.faces.front());
    std::optional<FlatChart> both;
    if (-score > 0.1 && WorthJoining(charts_[a], charts_[b])) {
      std::vector<int> faces = charts_[a].chart.faces;
      faces.insert(faces.end(), charts_[b].chart.faces.begin(), charts_[b].chart.faces.end());
      both = TryFlat(std::move(faces), kRounds);
    }
    if (!both) {
      failed.insert(name);
      continue;
    }
    // The merged chart keeps the lower name; what failed with either part may work with both, so it is asked again.
    std::erase_if(failed, [&](const std::pair<int, int>& p) { return p.first == name.first || p.second == name.first; });
    charts_[a] = std::move(*both);
    charts_[b].chart.faces.clear();
    used[a] = used[b] = 1;
    joined = true;
  }
  std::erase_if(charts_, [](const FlatChart& flat) { return flat.chart.faces.empty(); });
  return joined;
}

void Atlas::Join() {
  std::set<std::pair<int, int>> failed;
  for (int round = 0; round < 12; ++round) {
    Step(progress_, 0.3 + 0.03 * round, "merging " + std::to_string(charts_.size()) + " charts");
    if (!JoinRound(failed)) break;
  }
}

// Teeth along the seams waste texture and show as ragged seams: a face with two neighbours in another chart goes over to it.
void Atlas::Smooth() {
  const int face_count = static_cast<int>(surface_.faces.rows());
  std::vector<int> label(face_count);
  for (int c = 0; c < static_cast<int>(charts_.size()); ++c)
    for (const int f : charts_[c].chart.faces) label[f] = c;
  std::vector<int> size(charts_.size(), 0);
  for (const int c : label) ++size[c];
  for (int pass = 0; pass < kSmoothPasses; ++pass) {
    for (int f = 0; f < face_count; ++f) {
      for (int k = 0; k < 3; ++k) {
        const int other = label[surface_.neighbors(f, k)];
        if (other == label[f] || other != label[surface_.neighbors(f, (k + 1) % 3)] || size[label[f]] == 1) continue;
        --size[label[f]];
        ++size[other];
        label[f] = other;
      }
    }
  }
  std::vector<std::vector<int>> work(charts_.size());
  for (int f = 0; f < face_count; ++f) work[label[f]].push_back(f);
  charts_.clear();
  Settle(std::move(work));
}

// More rounds for the charts that stay; where they lead into a fold, the earlier result is kept.
void Atlas::Refine() {
  ParallelFor(static_cast<std::int64_t>(charts_.size()), [&](std::int64_t i) {
    const Chart& chart = charts_[i].chart;
    std::optional<UvsX2> uvs = Flattened(surface_, chart, kFinalRounds);
    if (uvs && MeasureDistortion(surface_, chart, *uvs).max <= kWorstDistortion) charts_[i].uvs = std::move(*uvs);
  });
}

Mesh Assembled(const Mesh& clean, const std::vector<FlatChart>& charts, const std::vector<UvsX2>& uvs) {
  Mesh mesh = clean;
  int count = 0;
  for (const FlatChart& flat : charts) count += static_cast<int>(flat.uvs.rows());
  mesh.uvs.resize(count, 2);
  mesh.uv_faces.resize(clean.faces.rows(), 3);
  int at = 0;
  for (std::size_t c = 0; c < charts.size(); ++c) {
    mesh.uvs.middleRows(at, uvs[c].rows()) = uvs[c];
    for (int i = 0; i < static_cast<int>(charts[c].chart.faces.size()); ++i)
      mesh.uv_faces.row(charts[c].chart.faces[i]) = charts[c].chart.corners.row(i).array() + at;
    at += static_cast<int>(uvs[c].rows());
  }
  mesh.uvs = OnGrid(mesh.uvs);
  return mesh;
}

// Edges whose two faces use different UV vertices at the corner where the edge begins.
double SeamLength(const Surface& surface, const Mesh& mesh) {
  double length = 0;
  for (int f = 0; f < mesh.face_count(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const int a = mesh.faces(f, k), b = mesh.faces(f, (k + 1) % 3), g = surface.neighbors(f, k);
      if (g < f) continue;
      int at = 0;
      while (mesh.faces(g, at) != a || mesh.faces(g, (at + 2) % 3) != b) ++at;
      if (mesh.uv_faces(g, at) != mesh.uv_faces(f, k)) length += (mesh.points.row(a) - mesh.points.row(b)).norm();
    }
  }
  return length;
}

void RequireClosed(const Mesh& clean) {
  RequireUsable(clean, "clean");
  const ClosedReport report = CheckClosed(clean);
  if (report.closed()) return;
  throw InputError("unwrap: the mesh is not closed (" + std::to_string(report.bad_edges) + " bad edges, " +
                   std::to_string(report.bad_fans) + " vertices without one fan, " + std::to_string(report.unused_vertices) +
                   " unused vertices, " + std::to_string(report.zero_area_faces) + " faces without area, volume " +
                   std::to_string(report.volume) + "); run cleanup on it first");
}

}  // namespace

void UnwrapOptions::Describe(OptionVisitor& visit) {
  visit("texture_size", texture_size, {"edge of the square texture that the gutter is meant for", "px", 64, 16384, {}});
  visit("gutter", gutter, {"least distance between two charts", "px", 1, 64, {}});
  visit("effort", effort, {"rounds of the search for places; cost grows with it", "", 0, 100000, {}});
  visit("press", press, {"deform charts a little where that fills gaps between them"});
  visit("max_distortion", max_distortion, {"mean stretch of a chart, 1 is none, above which it is cut", "", 1.01, 3, {}});
}

UnwrapResult Unwrapped(const Mesh& clean, const UnwrapOptions& options, Progress* progress) {
  RequireClosed(clean);
  const Surface surface = MakeSurface(clean);
  Step(progress, 0.05, "cutting charts");
  Atlas atlas(surface, options.max_distortion, progress);
  atlas.Cut();
  atlas.Join();
  atlas.Smooth();
  atlas.Join();
  Step(progress, 0.65, "flattening");
  atlas.Refine();
  std::vector<Shape> shapes;
  for (const FlatChart& flat : atlas.charts()) shapes.push_back({flat.uvs, flat.chart.corners});
  Step(progress, 0.7, "packing " + std::to_string(shapes.size()) + " charts");
  const Packing packing = Pack(shapes, {options.texture_size, options.gutter, options.effort});
  std::vector<const Chart*> charts;
  for (const FlatChart& flat : atlas.charts()) charts.push_back(&flat.chart);
  Layout layout{packing.uvs, packing.scale};
  Step(progress, 0.85, "pressing");
  if (options.press) {
    PressOptions press;
    press.gap = static_cast<double>(options.gutter) / options.texture_size;
    layout = Pressed(surface, charts, layout, press);
  }

  UnwrapResult result;
  result.mesh = Assembled(clean, atlas.charts(), layout.uvs);
  const AtlasFaults faults = FindAtlasFaults(result.mesh);
  if (!faults.none()) {
    throw QualityError("unwrap: the layout has " + std::to_string(faults.flipped) + " flipped triangles, " +
                       std::to_string(faults.crossings) + " crossing seams, " + std::to_string(faults.nested) + " nested and " +
                       std::to_string(faults.not_disks) + " broken charts; try another --max_distortion");
  }
  result.charts = static_cast<int>(shapes.size());
  result.stretch = MeasureAtlasStretch(result.mesh);
  const double area = SurfaceArea(clean.points, clean.faces);
  result.texels_per_unit = std::sqrt(result.stretch.utilisation / area) * options.texture_size;
  result.seam_over_diag = SeamLength(surface, result.mesh) / BoundingDiagonal(clean.points);
  return result;
}

}  // namespace keypose::texture
