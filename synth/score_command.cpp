#include "synth/score_command.h"

#include <nlohmann/json.hpp>
#include <optional>

#include "core/errors.h"
#include "core/geometry.h"
#include "core/io/colmap_io.h"
#include "core/io/landmarks_io.h"
#include "core/io/mesh_io.h"
#include "synth/pick.h"
#include "synth/score.h"
#include "synth/truth_files.h"

namespace keypose::synth {
namespace {

using Json = nlohmann::ordered_json;

// One pose of a reconstruction beside its truth.
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

Subject ReadSubject(const std::filesystem::path& truth, const std::filesystem::path& model, const std::filesystem::path& mesh) {
  Subject subject{ReadTruth(truth), {}, ReadMesh(mesh), {}};
  RequireUsable(subject.mesh, mesh.string());
  const Eigen::Vector3d center = subject.truth.surface.points.colwise().mean();
  subject.cameras = ScoreCameras(subject.truth.cameras, ReadColmapModel(model), center);
  subject.refined = RefineAlignment(subject.truth.surface, subject.mesh, subject.cameras.truth_from_model);
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
  const SurfaceScore s = ScoreSurface(subject.truth.surface, subject.InTruth(truth_from_model));
  return {{"mean_over_diag", s.mean()},
          {"to_truth", {{"mean", s.mean_to_truth}, {"p95", s.p95_to_truth}, {"max", s.max_to_truth}}},
          {"from_truth", {{"mean", s.mean_from_truth}, {"p95", s.p95_from_truth}, {"max", s.max_from_truth}}}};
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
          {"volume", c.volume}};
}

Json CorrespondenceJson(const Subject& a, const Subject& b, const PointsX3& registered, bool refined) {
  const Similarity3& from_a = refined ? a.refined : a.cameras.truth_from_model;
  const Similarity3& from_b = refined ? b.refined : b.cameras.truth_from_model;
  const CorrespondenceScore s = ScoreCorrespondence(a.truth.surface, b.truth.surface, a.InTruth(from_a), Transformed(from_b, registered));
  return {{"mean", s.mean}, {"p95", s.p95}, {"max", s.max}};
}

}  // namespace

std::string RunPick(const PickCommand& command) {
  const Truth truth = ReadTruth(command.truth);
  const Mesh mesh = ReadMesh(command.mesh);
  RequireUsable(mesh, command.mesh.string());
  const CameraScore cameras = ScoreCameras(truth.cameras, ReadColmapModel(command.model), truth.surface.points.colwise().mean());
  const Picks picks = PickLandmarks(truth.surface, truth.landmarks, mesh, cameras.truth_from_model, command.reach);
  if (picks.landmarks.size() < 3)
    throw InputError("synth: only " + std::to_string(picks.landmarks.size()) + " of " + std::to_string(truth.landmarks.size()) +
                     " landmarks are on " + command.mesh.string() + "; is it the mesh of this pose?");
  WriteLandmarks(command.output, mesh, picks.landmarks);
  std::string line = std::to_string(picks.landmarks.size()) + " landmarks in " + command.output.string();
  for (const std::string& name : picks.out_of_reach) line += "\n  the mesh has no " + name;
  return line;
}

std::string RunScore(const ScoreCommand& command) {
  const Subject subject = ReadSubject(command.truth, command.model, command.mesh);
  Json json{{"schema", 1},
            {"cameras", CamerasJson(subject.cameras)},
            {"surface", SurfaceJson(subject, subject.cameras.truth_from_model)},
            {"surface_refined", SurfaceJson(subject, subject.refined)},
            {"closed", ClosedJson(subject.mesh)}};
  if (!command.registered.empty()) {
    const Subject source = ReadSubject(command.template_truth, command.template_model, command.template_mesh);
    const Mesh registered = ReadMesh(command.registered);
    json["correspondence"] = CorrespondenceJson(source, subject, registered.points, false);
    json["correspondence_refined"] = CorrespondenceJson(source, subject, registered.points, true);
    json["registered_closed"] = ClosedJson(registered);
  }
  return json.dump(1) + "\n";
}

}  // namespace keypose::synth
