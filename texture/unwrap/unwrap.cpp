#include "texture/unwrap/unwrap.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "texture/charts/hidden_seams.h"
#include "texture/packing/elastic_packing.h"
#include "texture/packing/packing.h"
#include "texture/unwrap/flat_charts.h"

namespace keypose::texture {
namespace {

// kLargestShare: tuned on the armadillo, the plush dog and the skull
// (docs/algorithms/unwrap.md). The others: no record of the data.
struct ChartSizeTuning {
  // Largest share of the surface in one chart. Large charts have few seams; if they pack badly,
  // smaller ones are tried.
  KEYPOSE_TUNED(double, kLargestShare, 0.25);
  KEYPOSE_TUNED(double, kSecondShare, 0.1);
  KEYPOSE_TUNED(double, kThirdShare, 0.05);
};

Mesh Assembled(const Mesh& clean, const std::vector<FlatChart>& charts,
               const std::vector<UvsX2>& uvs) {
  Mesh mesh = clean;
  int count = 0;
  for (const FlatChart& flat : charts) count += static_cast<int>(flat.uvs.rows());
  mesh.uvs.resize(count, 2);
  mesh.uv_faces.resize(clean.faces.rows(), 3);
  int at = 0;
  for (std::size_t c = 0; c < charts.size(); ++c) {
    mesh.uvs.middleRows(at, uvs[c].rows()) = uvs[c];
    for (int i = 0; i < std::ssize(charts[c].chart.faces); ++i)
      mesh.uv_faces.row(charts[c].chart.faces[i]) = charts[c].chart.corners.row(i).array() + at;
    at += static_cast<int>(uvs[c].rows());
  }
  mesh.uvs = OnGrid(mesh.uvs);
  return mesh;
}

// Edges whose two faces use different UV vertices at the edge's first corner.
void MeasureSeams(const Surface& surface, const Exposure& exposure, UnwrapResult& result) {
  const Mesh& mesh = result.mesh;
  double length = 0, seam = 0, seen = 0, seam_seen = 0, front = 0;
  for (int f = 0; f < mesh.face_count(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const int a = mesh.faces(f, k), b = mesh.faces(f, (k + 1) % 3), g = surface.neighbors(f, k);
      if (g < f) continue;
      const double edge = (mesh.points.row(a) - mesh.points.row(b)).norm(),
                   visible = edge * (exposure.seen[a] + exposure.seen[b]) / 2;
      length += edge;
      seen += visible;
      int at = 0;
      while (mesh.faces(g, at) != a || mesh.faces(g, (at + 2) % 3) != b) ++at;
      if (mesh.uv_faces(g, at) == mesh.uv_faces(f, k)) continue;
      seam += edge;
      seam_seen += visible;
      if (exposure.front[a] && exposure.front[b]) front += edge;
    }
  }
  const double diagonal = BoundingDiagonal(mesh.points);
  result.seam_over_diag = seam / diagonal;
  result.seam_front_over_diag = front / diagonal;
  result.seam_exposure = seam > 0 ? seam_seen / seam : 0;
  result.edge_exposure = seen / length;
}

void RequireClosed(const Mesh& clean) {
  RequireUsable(clean, "clean");
  const ClosedReport report = CheckClosed(clean);
  if (report.closed()) return;
  throw InputError("unwrap: the mesh is not closed (" + std::to_string(report.bad_edges) +
                   " bad edges, " + std::to_string(report.bad_fans) +
                   " vertices without one fan, " + std::to_string(report.unused_vertices) +
                   " unused vertices, " + std::to_string(report.zero_area_faces) +
                   " faces without area, volume " + std::to_string(report.volume) +
                   "); run cleanup on it first");
}

void RequireProven(const Mesh& mesh) {
  const AtlasFaults faults = FindAtlasFaults(mesh);
  if (faults.none()) return;
  throw QualityError("unwrap: the layout has " + std::to_string(faults.flipped) +
                     " flipped triangles, " + std::to_string(faults.crossings) +
                     " crossing seams, " + std::to_string(faults.nested) + " nested and " +
                     std::to_string(faults.not_disks) +
                     " broken charts; try another --max_distortion");
}

// From many small charts to a layout whose charts have at most `share` of the surface each.
UnwrapResult LaidOut(const Mesh& clean, const Surface& surface, const ChartAtlas& cut, double share,
                     const UnwrapOptions& options, Progress* progress) {
  ChartAtlas atlas = cut;
  atlas.Join(share);
  atlas.Hide();
  atlas.Join(share);
  ReportProgress(progress, 0.65, "flattening");
  atlas.Refine();
  std::vector<Shape> shapes;
  std::vector<const Chart*> charts;
  for (const FlatChart& flat : atlas.charts()) {
    shapes.push_back({flat.uvs, flat.chart.corners});
    charts.push_back(&flat.chart);
  }
  ReportProgress(progress, 0.7, "packing " + std::to_string(shapes.size()) + " charts");
  const Packing packing = Pack(shapes, {options.texture_size, options.gutter, options.effort});
  Layout layout{packing.uvs, packing.scale};
  ReportProgress(progress, 0.85, "pressing");
  if (options.elastic_packing) {
    ElasticPackingOptions elastic;
    elastic.gap = static_cast<double>(options.gutter) / options.texture_size;
    layout = PackElastically(surface, charts, layout, elastic);
  }
  UnwrapResult result;
  result.mesh = Assembled(clean, atlas.charts(), layout.uvs);
  RequireProven(result.mesh);
  result.charts = SizeOf(shapes);
  result.stretch = MeasureAtlasStretch(result.mesh);
  return result;
}

}  // namespace

void UnwrapOptions::Describe(OptionVisitor& visit) {
  visit("texture_size", texture_size,
        {"width and height of the texture for which the gutter is given", "px", 64, 16384, {}});
  visit("gutter", gutter,
        {"least distance between two charts, half of it to the border", "px", 1, 64, {}});
  visit("effort", effort,
        {"packing effort: number of moves in units of 16; more take longer and cover more",
         "",
         0,
         100000,
         {}});
  visit("elastic_packing", elastic_packing,
        {"deform charts a little where that fills gaps between them"});
  visit(
      "hide_seams", hide_seams,
      {"seams are placed where they are least visible: creases, below, behind (up is +z, the front "
       "-y)"});
  visit("enough_utilisation", enough_utilisation,
        {"smaller charts are tried while less than this share of the texture is covered",
         "",
         0,
         1,
         {}});
  visit("max_distortion", max_distortion,
        {"a chart with a larger mean stretch than this is cut; 1 is no stretch", "", 1.01, 3, {}});
}

UnwrapResult Unwrapped(const Mesh& clean, const UnwrapOptions& options, Progress* progress) {
  RequireClosed(clean);
  const Surface surface = MakeSurface(clean);
  ReportProgress(progress, 0.05, "cutting charts");
  const Exposure exposure = FindExposure(surface, {});
  const PointsX3 costs = SeamCosts(
      surface, options.hide_seams ? exposure.cost : Eigen::VectorXd::Ones(clean.vertex_count()));
  ChartAtlas cut(surface, costs, options.max_distortion, progress);
  cut.Cut();
  UnwrapResult result;
  for (const double share : {ChartSizeTuning::kLargestShare, ChartSizeTuning::kSecondShare,
                             ChartSizeTuning::kThirdShare}) {
    const UnwrapResult layout = LaidOut(clean, surface, cut, share, options, progress);
    if (result.charts == 0 || layout.stretch.utilisation > result.stretch.utilisation)
      result = layout;
    if (result.stretch.utilisation >= options.enough_utilisation) break;
  }
  const double area = SurfaceArea(clean.points, clean.faces);
  result.texels_per_unit = std::sqrt(result.stretch.utilisation / area) * options.texture_size;
  MeasureSeams(surface, exposure, result);
  return result;
}

}  // namespace keypose::texture
