#include "synth/commands/score_command.h"

#include <nlohmann/json.hpp>
#include <optional>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/project/colmap_io.h"
#include "core/io/project/landmarks_io.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/values/errors.h"
#include "synth/photographs/truth_files.h"
#include "synth/scores/dense_score.h"
#include "synth/scores/pick.h"
#include "synth/scores/score.h"
#include "synth/scores/texel_score.h"
#include "synth/scores/true_hull.h"
#include "synth/worlds/outer_surface.h"

namespace keypose::synth {
namespace {

using Json = nlohmann::ordered_json;

// One pose of a reconstruction and its truth.
struct Subject {
  Truth truth;
  CameraScore cameras;
  Mesh mesh;            // in the model's frame
  Similarity3 refined;  // truth from model, after ICP

  Mesh InTruth(const Similarity3& truth_from_model) const {
    Mesh moved = mesh;
    moved.points = Transformed(truth_from_model, mesh.points);
    return moved;
  }
};

Subject ReadSubject(const std::filesystem::path& truth, const std::filesystem::path& model,
                    const std::filesystem::path& mesh) {
  Subject subject{ReadTruth(truth), {}, ReadMesh(mesh), {}};
  RequireUsable(subject.mesh, mesh.string());
  const Eigen::Vector3d center = subject.truth.surface.points.colwise().mean();
  subject.cameras = ScoreCameras(subject.truth.cameras, ReadColmapModel(model), center);
  subject.refined =
      RefineAlignment(subject.truth.outer, subject.mesh, subject.cameras.truth_from_model);
  return subject;
}

Json CamerasJson(const CameraScore& s) {
  return {{"placed", s.placed},
          {"total", s.total},
          {"mean_m", s.mean_m},
          {"max_m", s.max_m},
          {"mean_over_distance", s.mean_over_distance},
          {"max_over_distance", s.max_over_distance}};
}

Json SurfaceJson(const Subject& subject, const Similarity3& truth_from_model) {
  const SurfaceScore s = ScoreSurface(subject.truth.outer, subject.InTruth(truth_from_model));
  return {
      {"mean_over_diag", s.mean()},
      {"to_truth", {{"mean", s.mean_to_truth}, {"p95", s.p95_to_truth}, {"max", s.max_to_truth}}},
      {"from_truth",
       {{"mean", s.mean_from_truth}, {"p95", s.p95_from_truth}, {"max", s.max_from_truth}}}};
}

Json ClosedJson(const Mesh& mesh) {
  const ClosedReport c = CheckClosed(mesh);
  return {{"closed", c.closed()},
          {"faces", mesh.face_count()},
          {"bad_edges", c.bad_edges},
          {"bad_fans", c.bad_fans},
          {"zero_area_faces", c.zero_area_faces},
          {"components", c.components},
          {"euler", c.euler},
          {"genus", c.components - c.euler / 2},
          {"volume", c.volume}};
}

Json CorrespondenceJson(const Subject& a, const Subject& b, const PointsX3& registered,
                        bool refined) {
  const Similarity3& from_a = refined ? a.refined : a.cameras.truth_from_model;
  const Similarity3& from_b = refined ? b.refined : b.cameras.truth_from_model;
  const CorrespondenceScore s = ScoreCorrespondence(
      a.truth.surface, b.truth.surface, a.InTruth(from_a), Transformed(from_b, registered));
  return {{"mean", s.mean}, {"p95", s.p95}, {"max", s.max}, {"flipped", s.flipped}};
}

Json TexelsJson(const Subject& a, const Subject& b, const PointsX3& registered,
                const ScoreCommand& command) {
  const TexelScore s = ScoreTexels(
      a.truth.surface, b.truth.surface, a.InTruth(a.refined), Transformed(b.refined, registered),
      ReadImage(command.template_texture, 3), ReadImage(command.texture, 3));
  return {{"texels", s.texels},   {"mean", s.mean},
          {"p95", s.p95},         {"max", s.max},
          {"texel", s.texel},     {"mean_difference", s.mean_difference},
          {"psnr_db", s.psnr_db}, {"psnr_gain_db", s.psnr_gain_db}};
}

Json PointsJson(const Mesh& truth, const std::vector<View>& views, const PointsX3& points,
                double reach_m) {
  const PointsScore s = ScorePoints(truth, views, points, reach_m);
  return {{"points", s.points},
          {"within_one_footprint", s.within_one_footprint},
          {"median_footprints", s.median},
          {"p90_footprints", s.p90},
          {"p99_footprints", s.p99},
          {"completeness", s.completeness},
          {"completeness_seen", s.completeness_seen}};
}

/// Scores of the whole cloud, and of the points from stereo; the other points come from the hull
/// and have low confidence.
Json CloudJson(const Subject& subject, const std::filesystem::path& path) {
  constexpr float kSure = 0.3f;
  const PointCloud cloud = ReadPointCloud(path);
  const PointsX3 points = Transformed(subject.refined, cloud.points);
  const Mesh& truth = subject.truth.outer;
  const double height = truth.points.col(2).maxCoeff() - truth.points.col(2).minCoeff();
  Json json{{"all", PointsJson(truth, subject.truth.cameras.views, points, 0.01 * height)}};
  if (cloud.confidence.size() != points.rows()) return json;
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    if (cloud.confidence[i] >= kSure) rows.push_back(i);
  if (!rows.empty())
    json["sure"] =
        PointsJson(truth, subject.truth.cameras.views, points(rows, Eigen::all), 0.01 * height);
  return json;
}

Json HullJson(const Subject& subject, const std::filesystem::path& path) {
  const HullComparison c = CompareWithHull(subject.truth.outer, subject.truth.cameras.views,
                                           subject.InTruth(subject.refined), ReadMesh(path));
  return {{"mean_m", c.mean_m},
          {"hull_mean_m", c.hull_mean_m},
          {"ratio", c.ratio()},
          {"worse_share", c.worse_share},
          {"worst_excess_footprints", c.worst_excess_footprints}};
}

}  // namespace

std::string RunPick(const PickCommand& command) {
  const Truth truth = ReadTruth(command.truth);
  const Mesh mesh = ReadMesh(command.mesh);
  RequireUsable(mesh, command.mesh.string());
  const CameraScore cameras = ScoreCameras(truth.cameras, ReadColmapModel(command.model),
                                           truth.surface.points.colwise().mean());
  const Picks picks =
      PickLandmarks(truth.surface, truth.landmarks, mesh, cameras.truth_from_model, command.reach);
  if (picks.landmarks.size() < 3)
    throw InputError("synth: only " + std::to_string(picks.landmarks.size()) + " of " +
                     std::to_string(truth.landmarks.size()) + " landmarks are on " +
                     command.mesh.string() + "; is it the mesh of this pose?");
  WriteLandmarks(command.output, mesh, picks.landmarks);
  std::string line =
      std::to_string(picks.landmarks.size()) + " landmarks in " + command.output.string();
  for (const std::string& name : picks.out_of_reach) line += "\n  the mesh has no " + name;
  return line;
}

std::string RunScore(const ScoreCommand& command) {
  const Subject subject = ReadSubject(command.truth, command.model, command.mesh);
  Json json{{"schema", 1},
            {"cameras", CamerasJson(subject.cameras)},
            {"surface", SurfaceJson(subject, subject.cameras.truth_from_model)},
            {"surface_refined", SurfaceJson(subject, subject.refined)},
            {"closed", ClosedJson(subject.mesh)},
            {"true_genus", Genus(subject.truth.outer)}};
  const DetailScore detail =
      ScoreDetail(subject.truth.surface, subject.truth.smooth, subject.InTruth(subject.refined));
  if (detail.places > 0)
    json["detail"] = {
        {"places", detail.places}, {"gain", detail.gain}, {"correlation", detail.correlation}};
  if (!command.cloud.empty()) json["points"] = CloudJson(subject, command.cloud);
  if (!command.hull.empty()) json["hull"] = HullJson(subject, command.hull);
  if (!command.registered.empty()) {
    const Subject source =
        ReadSubject(command.template_truth, command.template_model, command.template_mesh);
    const Mesh registered = ReadMesh(command.registered);
    json["correspondence"] = CorrespondenceJson(source, subject, registered.points, false);
    json["correspondence_refined"] = CorrespondenceJson(source, subject, registered.points, true);
    json["registered_closed"] = ClosedJson(registered);
    if (!command.texture.empty())
      json["texels"] = TexelsJson(source, subject, registered.points, command);
  }
  return json.dump(1) + "\n";
}

std::string RunHull(const HullCommand& command) {
  const Truth truth = ReadTruth(command.truth);
  std::vector<Image8> masks;
  for (const View& view : truth.cameras.views)
    masks.push_back(ReadImage(command.truth / "masks" / (view.name + ".png"), 1));
  const Eigen::Vector3d low = truth.surface.points.colwise().minCoeff(),
                        high = truth.surface.points.colwise().maxCoeff();
  // The hull extends beyond the character only between two views, so this margin is sufficient.
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(0.15 * (high - low).norm());
  const Mesh hull =
      HullOfMasks(truth.cameras.views, masks, low - margin, high + margin, command.spacing_m);
  WriteMesh(command.output, hull);
  return std::to_string(hull.face_count()) + " faces of the true masks' visual hull in " +
         command.output.string();
}

}  // namespace keypose::synth
