// keypose-register: bends the template onto a pose.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/io/meshes/mesh_io.h"
#include "core/io/meshes/mesh_look.h"
#include "core/io/pictures/png_io.h"
#include "core/io/project/landmarks_io.h"
#include "core/io/project/stiffness_io.h"
#include "core/io/text/files.h"
#include "core/stage/stage.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/surfaces/seams.h"
#include "core/values/errors.h"
#include "register/auto/auto_registration.h"
#include "register/auto/fused_template.h"
#include "register/landmarks/landmarks.h"
#include "register/nricp/correspondence.h"
#include "register/nricp/nricp.h"
#include "register/quality/correspondence_picture.h"
#include "register/quality/registration_quality.h"
#include "register/register_options.h"

namespace keypose::registration {
namespace {

StageSpec Spec() {
  StageSpec spec;
  spec.name = "register";
  spec.version = "7";
  spec.summary = "Bends the template onto a pose: same vertices and faces, new positions.";
  spec.title = "Shared net";
  spec.measurements = {
      {"flipped", "flipped triangles"},
      {"flipped_clearly", "clearly flipped triangles"},
      {"degenerate", "degenerate triangles", "", -kAnyNumber, 0},
      {"iterations", "iterations"},
      {"landmarks", "landmarks"},
      {"landmark_mean_over_diag", "landmark residual, mean", "diagonal", -kAnyNumber, 0.03},
      {"landmark_max_over_diag", "landmark residual, largest", "diagonal"},
      {"surface_rms_over_diag", "distance to the target, rms", "diagonal", -kAnyNumber, 0.004},
      {"target_coverage", "target covered", "share"},
      {"self_intersections_gained", "self-intersections gained"},
      {"stretch_low", "stretch, 1 %", "", 0.4},
      {"stretch_high", "stretch, 99 %", "", -kAnyNumber, 2.5}};
  spec.inputs = {
      {"source", "file", "template mesh", "", false, false},
      {"target", "file", "clean mesh of the pose", "", false, false},
      {"landmarks", "file", "pairs, or picks of source and target", "", true, true},
      {"stiffness", "file", "the source with painted greys (.ply), or a number for each vertex", "",
       true, false}};
  spec.outputs = {
      {"registered", "file", "the template in the pose (.obj or .ply)", "registered.obj", false,
       false},
      {"correspondence", "file", "for each vertex the nearest target face and the point on it",
       "correspondence.txt", true, false},
      {"transforms", "file", "for each vertex the 3x4 map from template to pose", "transforms.txt",
       true, false},
      {"picture", "file", "a checker transferred from the template, and distances (.png)",
       "registered.png", true, false}};
  spec.memory_gib = 2;
  spec.common = {"method", "skeleton"};
  return spec;
}

void Tell(StageContext& stage, const CarryLog& log) {
  for (const std::string& note : log.notes) stage.Note(note);
  for (const std::string& warning : log.warnings) stage.Warn(warning);
}

/// @param unbound  set to whether the landmarks do not name the mesh on which they were picked
CheckedLandmarks LoadLandmarks(StageContext& stage, const Mesh& source, const Mesh& target,
                               bool* unbound) {
  if (!stage.Has("landmarks")) return {};
  const auto files = stage.Inputs("landmarks");
  const auto in_photographs = std::find_if(files.begin(), files.end(), HoldsPhotoPicksOnly);
  if (files.size() == 2 && in_photographs != files.end()) {
    stage.Warn(PrintableName(*in_photographs) +
               " holds picks in photographs, as for a pose from few photographs, and none on a "
               "mesh; it is not used");
    return {};
  }
  std::vector<PickedPair> picked;
  int suggested = 0;
  CarryLog log;
  for (const LandmarkPair& p : ReadLandmarkPairs(stage.Inputs("landmarks"), source, target, &log)) {
    suggested += !p.confirmed;
    picked.push_back(
        {p.name, p.source.face, p.target.face, p.source.barycentric, p.target.barycentric});
  }
  CheckedLandmarks checked = CheckLandmarks(picked, source, target);
  Tell(stage, log);
  *unbound = log.unbound;
  if (checked.duplicates > 0)
    stage.Note("dropped " + std::to_string(checked.duplicates) + " landmarks that repeat others");
  if (suggested > 0)
    stage.Warn(std::to_string(suggested) +
               " landmarks are unconfirmed suggestions; confirm them with keypose landmarks "
               "suggest --accept");
  for (const std::string& warning : checked.warnings) stage.Warn(warning);
  if (checked.coplanar)
    stage.Warn(
        "the landmarks are nearly in one plane, which flattens the result; add some outside that "
        "plane");
  return checked;
}

Eigen::VectorXd LoadStiffness(StageContext& stage, const Mesh& source) {
  if (!stage.Has("stiffness")) return {};
  CarryLog log;
  const Eigen::VectorXd stiffness = ReadStiffness(stage.Input("stiffness"), source, &log);
  Tell(stage, log);
  return stiffness;
}

void ReportRun(StageContext& stage, const NricpResult& result) {
  stage.Report("alignment", result.alignment.method);
  stage.Report("alignment_starts", result.alignment.starts);
  stage.Report("alignment_residual_over_diag", result.alignment.residual);
  stage.Report("alignment_scale", result.alignment.target_from_source.scale);
  stage.Report("iterations", result.iterations);
  stage.Report("factorisations", result.factorisations);
  stage.Report("pcg_steps", static_cast<std::int64_t>(result.pcg_steps));
  stage.Report("analyses", result.analyses);
  stage.Report("unconverged_rounds", result.unconverged_rounds);
  stage.Report("correspondences_kept", result.kept);
  stage.Report("unconstrained_components", result.loose_components);
  stage.Report("seconds_align", result.seconds_align);
  stage.Report("seconds_search", result.seconds_search);
  stage.Report("seconds_solve", result.seconds_solve);
  if (result.loose_components > 0)
    stage.Warn(std::to_string(result.loose_components) +
               " parts of the template had too few correspondences; they stayed where they were");
}

/// @return the largest residual, over the diagonal
double ReportLandmarks(StageContext& stage, const CheckedLandmarks& landmarks,
                       const PointsX3& registered, double diagonal) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  double sum = 0, worst = 0;
  for (const LandmarkGoal& goal : landmarks.goals) {
    const double residual = (PositionOf(goal.source, registered) - goal.target).norm() / diagonal;
    list.push_back({{"name", goal.name}, {"residual_over_diag", residual}});
    sum += residual;
    worst = std::max(worst, residual);
  }
  const std::size_t count = landmarks.goals.size();
  stage.Report("landmarks", static_cast<std::int64_t>(count));
  stage.Report("landmarks_dropped", landmarks.duplicates);
  stage.Report("landmarks_coplanar", landmarks.coplanar);
  if (count == 0) return 0;
  stage.Report("landmark_mean_over_diag", sum / static_cast<double>(count));
  stage.Report("landmark_max_over_diag", worst);
  stage.ReportJson("landmark_residuals", list.dump());
  return worst;
}

RegistrationQuality ReportQuality(StageContext& stage, const Mesh& source,
                                  const PointsX3& registered, const Mesh& target,
                                  const ResultSurfaces& surfaces) {
  const RegistrationQuality q = MeasureRegistration(source, registered, target, surfaces);
  stage.Report("vertices", source.vertex_count());
  stage.Report("faces", source.face_count());
  stage.Report("flipped", q.flipped);
  stage.Report("flipped_clearly", q.flipped_clearly);
  stage.Report("degenerate", q.degenerate);
  stage.Report("surface_rms_over_diag", q.surface_rms);
  stage.Report("surface_mean_over_diag", q.surface_mean);
  stage.Report("hausdorff_to_target_over_diag", q.hausdorff_to_target);
  stage.Report("hausdorff_from_target_over_diag", q.hausdorff_from_target);
  stage.Report("target_coverage", q.coverage);
  stage.Report("self_intersections", q.self_intersections);
  stage.Report("self_intersections_gained", q.self_intersections_gained);
  stage.Report("stretch_low", q.stretch.low);
  stage.Report("stretch_median", q.stretch.median);
  stage.Report("stretch_high", q.stretch.high);
  stage.Report("stretch_worst_ratio", q.stretch.worst_ratio);
  stage.Report("target_diagonal", BoundingDiagonal(target.points));
  return q;
}

void ReportAuto(StageContext& stage, const AutoResult& result) {
  nlohmann::ordered_json starts = nlohmann::ordered_json::array();
  for (const StartTrial& start : result.starts)
    starts.push_back({{"start", start.name},
                      {"gap_over_diag", start.gap},
                      {"strain", start.strain},
                      {"score", start.score},
                      {"words", start.words}});
  const StartTrial& chosen = result.starts[result.chosen];
  stage.Report("alignment", result.alignment.method);
  stage.Report("alignment_starts", result.alignment.starts);
  stage.Report("alignment_scale", result.scale);
  stage.ReportJson("starts", starts.dump());
  stage.Report("start_chosen", chosen.name);
  stage.Report("softened", result.softened);
  stage.Report("levels", result.levels);
  stage.Report("loose_parts", result.loose_parts);
  stage.Report("seam_vertices", result.seam_vertices);
  stage.Report("gap_over_diag", result.gap);
  std::string words = "start '" + chosen.name + "' chosen";
  if (result.starts.size() > 1)
    words += " of " + std::to_string(result.starts.size()) +
             " tried: it has the best score from distance to the target and strain";
  if (result.rigid_parts > 0) {
    stage.Report("unmoved_share", result.unmoved_share);
    stage.Report("rigid_parts", result.rigid_parts);
    char share[16];
    std::snprintf(share, sizeof share, "%.0f %%", 100 * result.unmoved_share);
    stage.Note(std::string(share) +
               " of the surface moved as one rigid body and is held in its place; without that the "
               "whole surface slides");
    return;
  }
  stage.Note(words + (result.softened ? "; the shape had to stretch to reach the surface"
                                      : "; bending without stretch was enough"));
}

void ReportAdvice(StageContext& stage, const Mesh& source, const PointsX3& registered,
                  const Mesh& target, const std::vector<LandmarkGoal>& landmarks,
                  const ResultSurfaces& surfaces) {
  nlohmann::ordered_json advice = nlohmann::ordered_json::array();
  for (const LandmarkAdvice& a : AdviseLandmarks(source, registered, target, landmarks, surfaces))
    advice.push_back({{"vertex", a.vertex},
                      {"position", {a.position[0], a.position[1], a.position[2]}},
                      {"misfit_over_diag", a.misfit},
                      {"stretch", a.stretch},
                      {"score", a.score},
                      {"reason", a.reason}});
  if (!advice.empty())
    stage.Note("one more landmark would help most at template vertex " +
               advice[0]["vertex"].dump() + ": " + advice[0]["reason"].get<std::string>());
  stage.ReportJson("landmark_advice", advice.dump());
}

void AppendNumbers(std::string& text, std::initializer_list<double> numbers) {
  char buffer[32];
  for (double x : numbers) {
    std::snprintf(buffer, sizeof buffer, " %.9g", x);
    text += buffer;
  }
}

/// One line per vertex: target face, barycentric coordinates, distance over the target's diagonal.
std::string CorrespondenceText(const PointsX3& registered, const FacesX3& faces,
                               const Mesh& target) {
  const TargetSurface surface(target.points, target.faces);
  const Feet feet = surface.FindFeet(registered, VertexNormals(registered, faces), -1);
  const double diagonal = BoundingDiagonal(target.points);
  std::string text =
      "# for each template vertex: target face, three barycentric coordinates, distance over the "
      "target's diagonal\n";
  for (Eigen::Index v = 0; v < registered.rows(); ++v) {
    text += std::to_string(feet.faces[v]);
    AppendNumbers(text, {feet.barycentric(v, 0), feet.barycentric(v, 1), feet.barycentric(v, 2),
                         (feet.points.row(v) - registered.row(v)).norm() / diagonal});
    text += '\n';
  }
  return text;
}

/// One line per vertex: the 3x4 map [A b], row by row, that moves points near the vertex from the
/// template to the pose.
std::string TransformsText(const PointsX3& before, const PointsX3& after,
                           const std::vector<Eigen::Matrix3d>& linear) {
  std::string text =
      "# for each template vertex: the 3x4 map from template to pose near it, row by row\n";
  for (Eigen::Index v = 0; v < before.rows(); ++v) {
    const Eigen::Matrix3d& a = linear[v];
    const Eigen::Vector3d b = after.row(v).transpose() - a * before.row(v).transpose();
    for (int r = 0; r < 3; ++r) AppendNumbers(text, {a(r, 0), a(r, 1), a(r, 2), b[r]});
    text += '\n';
  }
  return text;
}

/// Refuses landmarks that do not name their mesh and look like landmarks of another mesh: one ends
/// far from its target, and many faces are flipped. On seven real pairs, correct landmarks end
/// within 1 % of the diagonal, with up to 3 % of the faces flipped. Random vertex numbers end 4 to
/// 14 % off, with 7 to 23 % flipped. Another numbering of the same figure ends 7 % off, with 3 %
/// flipped.
void RefuseWrongNumbers(double off_its_mark, int flipped, int faces) {
  if (off_its_mark < 0.02 || flipped < 0.02 * faces) return;
  throw InputError(
      "register: the landmarks do not name the mesh on which they were picked, and they contradict "
      "the surfaces: one ends " +
      std::to_string(static_cast<int>(100 * off_its_mark)) +
      " % of the diagonal from its target, and " + std::to_string(flipped) + " of " +
      std::to_string(faces) +
      " faces are flipped. Pick them again; or, if their places are right, bind them: keypose "
      "landmarks bind --help");
}

void Gate(const RegistrationQuality& q, int faces, const RegisterOptions& options) {
  if (q.surface_rms > options.max_surface_rms)
    throw QualityError("register: the surfaces are " + std::to_string(q.surface_rms) +
                       " of the diagonal apart (limit " + std::to_string(options.max_surface_rms) +
                       "); add landmarks where the pose differs most");
  if (q.flipped_clearly > options.max_flipped_share * faces)
    throw QualityError("register: " + std::to_string(q.flipped_clearly) + " of " +
                       std::to_string(faces) +
                       " faces are flipped, more than max_flipped_share allows; add landmarks "
                       "where the pose differs most");
}

void RefuseFused(StageContext& stage, const Mesh& source, const Mesh& target, double off_pose,
                 bool allow) {
  const std::string problem = FusedTemplateProblem(source, target, off_pose);
  if (problem.empty()) return;
  if (!allow)
    throw InputError("register: " + problem +
                     ", or write the result anyway with --allow_fused true");
  stage.Warn(problem);
}

/// Closes the seams of a mesh, for measuring. Otherwise the mesh would intersect itself at seams,
/// and distances along the surface could not cross them. Vertices keep their numbers.
Mesh WithoutSeams(Mesh mesh, std::vector<LandmarkGoal>& landmarks) {
  const Seams seams = FindSeams(mesh);
  mesh.faces = WeldedFaces(mesh.faces, seams);
  for (LandmarkGoal& landmark : landmarks)
    for (int& v : landmark.source.vertices) v = seams.empty() ? v : seams.one[v];
  return mesh;
}

/// The registered mesh, and each vertex's map from the source.
struct Bent {
  Mesh mesh;
  std::vector<Eigen::Matrix3d> transforms;
};

Bent Bend(StageContext& stage, const Mesh& source, const Mesh& target,
          const std::vector<LandmarkGoal>& goals, const RegisterOptions& options) {
  const Eigen::VectorXd stiffness = LoadStiffness(stage, source);
  SubProgress bending(stage.progress(), 0.0, 0.9);
  Bent bent{source, {}};
  bent.mesh.normals.resize(0, 3);
  const auto take = [&](auto&& result) {
    bent.mesh.points = std::move(result.points);
    bent.transforms = std::move(result.transforms);
  };
  if (options.method == "auto") {
    AutoResult result = RegisterAuto(source, target, goals, stiffness, options.automatic, &bending);
    ReportAuto(stage, result);
    take(result);
  } else {
    NricpResult result = RegisterNricp(source, target, goals, stiffness, options.nricp, &bending);
    ReportRun(stage, result);
    take(result);
  }
  return bent;
}

void WriteResults(StageContext& stage, const Mesh& source, const Mesh& target, const Bent& bent,
                  const std::vector<LandmarkGoal>& goals) {
  if (const auto path = stage.Output("correspondence"); !path.empty())
    WriteFile(path, CorrespondenceText(bent.mesh.points, source.faces, target));
  if (const auto path = stage.Output("transforms"); !path.empty())
    WriteFile(path, TransformsText(source.points, bent.mesh.points, bent.transforms));
  if (const auto path = stage.Output("picture"); !path.empty())
    WritePng(path, DrawCorrespondence(source, bent.mesh.points, target, goals));
  WriteMesh(stage.Output("registered"), bent.mesh);
}

void Run(StageContext& stage, const RegisterOptions& options) {
  RequireMeshName(stage.Output("registered"));
  const Mesh source = ReadMesh(stage.Input("source"));
  const Mesh target = ReadMesh(stage.Input("target"));
  RequireUsable(source, stage.Input("source").string());
  RequireUsable(target, stage.Input("target").string());
  RequireArea(source, stage.Input("source").string());
  RequireArea(target, stage.Input("target").string());
  for (const std::string& warning : LookWarnings(stage.Input("source"), source))
    stage.Warn(warning);
  bool unbound = false;
  CheckedLandmarks landmarks = LoadLandmarks(stage, source, target, &unbound);
  const Mesh whole = WithoutSeams(source, landmarks.goals);
  const Bent bent = Bend(stage, source, target, landmarks.goals, options);
  const PointsX3& registered = bent.mesh.points;
  const double worst =
      ReportLandmarks(stage, landmarks, registered, BoundingDiagonal(target.points));
  const ResultSurfaces surfaces = MakeResultSurfaces(whole, registered, target);
  const RegistrationQuality quality = ReportQuality(stage, whole, registered, target, surfaces);
  if (unbound && options.method == "auto")
    RefuseWrongNumbers(worst, quality.flipped_clearly, source.face_count());
  ReportAdvice(stage, whole, registered, target, landmarks.goals, surfaces);
  Gate(quality, source.face_count(), options);
  RefuseFused(stage, source, target, quality.hausdorff_to_target, options.allow_fused);
  WriteResults(stage, source, target, bent, landmarks.goals);
}

}  // namespace
}  // namespace keypose::registration

int main(int argc, char** argv) {
  return keypose::RunStage<keypose::registration::RegisterOptions>(
      argc, argv, keypose::registration::Spec(), keypose::registration::Run);
}
