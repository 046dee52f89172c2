#include "synth/scores/surface_score.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/frame_folder.h"
#include "core/io/pictures/image_io.h"
#include "core/io/project/rig_calibration.h"
#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/pictures/mask_overlap.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "synth/photographs/mask_fill.h"

namespace keypose::synth {
namespace {

namespace fs = std::filesystem;

/// Distances of the true surface's points from the mesh.
std::vector<double> DistancesFrom(const Mesh& mesh, const PointsX3& truth) {
  const RayScene scene(mesh.points, mesh.faces);
  std::vector<double> distances;
  for (Eigen::Index v = 0; v < truth.rows(); ++v)
    distances.push_back(std::sqrt(scene.ClosestPoint(truth.row(v)).squared_distance));
  return distances;
}

double MeanOf(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return values.empty() ? 0 : sum / static_cast<double>(values.size());
}

/// Mean over the frames of the vertices' second differences in time.
double SecondDifference(const std::vector<fs::path>& frames) {
  const int count = SizeOf(frames);
  std::vector<PointsX3> last;
  double sum = 0;
  for (const fs::path& path : frames) {
    last.push_back(ReadMesh(path).points);
    if (last.size() < 3) continue;
    sum += (last[0] - 2 * last[1] + last[2]).rowwise().norm().mean();
    last.erase(last.begin());
  }
  return count > 2 ? sum / (count - 2) : 0;
}

void ScoreOutlines(const SurfaceScoreCommand& command, const std::vector<fs::path>& frames,
                   MovingSurfaceScore* score) {
  const View view =
      ReadRigCalibration(command.performance / "held_out" / "calibration.yml").views.front();
  std::vector<double> ious(frames.size());
  ParallelFor(SizeOf(frames), [&](std::int64_t f) {
    const Mesh mesh = ReadMesh(frames[f]);
    const fs::path mask =
        command.performance / "truth" / "masks" / view.name / fmt::format("{:03}.png", f);
    ious[f] = MaskIoU(ReadImage(mask, 1), FillMask(mesh.points, mesh.faces, view), 1);
  });
  score->iou_held_out = MeanOf(ious);
  score->iou_held_out_least = *std::min_element(ious.begin(), ious.end());
}

}  // namespace

MovingSurfaceScore ScoreMovingSurface(const SurfaceScoreCommand& command) {
  const std::vector<fs::path> frames = NumberedFrames(command.frames, "synth"),
                              truth =
                                  NumberedFrames(command.performance / "truth" / "frames", "synth");
  if (frames.size() != truth.size())
    throw InputError(
        fmt::format("synth: there are {} frames, but {} true ones", frames.size(), truth.size()));
  std::vector<int> measured;
  for (int f = 0; f < SizeOf(frames); f += std::max(1, command.every)) measured.push_back(f);
  std::vector<std::vector<double>> distances(measured.size());
  ParallelFor(SizeOf(measured), [&](std::int64_t i) {
    distances[i] =
        DistancesFrom(ReadMesh(frames[measured[i]]), ReadMesh(truth[measured[i]]).points);
  });
  MovingSurfaceScore score;
  score.frames = SizeOf(measured);
  std::vector<double> all;
  for (int i = 0; i < SizeOf(measured); ++i) {
    const double mean = MeanOf(distances[i]);
    if (mean > score.worst_frame_mean_m) {
      score.worst_frame_mean_m = mean;
      score.worst_frame = measured[i];
    }
    all.insert(all.end(), distances[i].begin(), distances[i].end());
  }
  score.mean_m = MeanOf(all);
  score.p95_m = QuantileAbove(std::move(all), 0.95);
  ScoreOutlines(command, frames, &score);
  const double true_difference = SecondDifference(truth);
  if (true_difference > 0) score.second_difference = SecondDifference(frames) / true_difference;
  return score;
}

std::string ToJson(const MovingSurfaceScore& score) {
  nlohmann::ordered_json json;
  json["frames"] = score.frames;
  json["mean_mm"] = 1000 * score.mean_m;
  json["p95_mm"] = 1000 * score.p95_m;
  json["worst_frame_mean_mm"] = 1000 * score.worst_frame_mean_m;
  json["worst_frame"] = score.worst_frame;
  json["iou_held_out"] = score.iou_held_out;
  json["iou_held_out_least"] = score.iou_held_out_least;
  json["second_difference"] = score.second_difference;
  return json.dump(1) + "\n";
}

}  // namespace keypose::synth
