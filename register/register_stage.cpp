// keypose-register: the template bent onto a pose.
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/geometry.h"
#include "core/io/files.h"
#include "core/io/landmarks_io.h"
#include "core/io/mesh_io.h"
#include "core/stage/stage.h"
#include "register/landmarks.h"
#include "register/nricp.h"
#include "register/quality.h"
#include "register/stiffness_map.h"

namespace keypose::registration {
namespace {

struct RegisterOptions {
  std::string method = "nricp";
  NricpOptions nricp;
  double max_surface_rms = 1;    ///< over the diagonal; more is a quality fault
  double max_flipped_share = 1;  ///< of faces; more is a quality fault

  void Describe(OptionVisitor& visit) {
    visit("method", method, {.help = "nricp: the paper's non-rigid ICP", .unit = "", .choices = {"nricp"}});
    visit("alpha_max", nricp.alpha_max, {"stiffness of the first round (target scaled to diagonal 2)", "", 1e-6, 1e6, {}});
    visit("alpha_min", nricp.alpha_min, {"stiffness of the last round", "", 1e-6, 1e6, {}});
    visit("alpha_steps", nricp.alpha_steps, {"rounds of falling stiffness", "", 1, 1000, {}});
    visit("beta_ratio", nricp.beta_ratio, {"landmark weight over stiffness", "", 0, 1e3, {}});
    visit("beta_until", nricp.beta_until, {"landmarks count while the stiffness is above this", "", 0, 1e6, {}});
    visit("gamma", nricp.gamma, {"weight of translation in the stiffness term", "", 1e-6, 1e6, {}});
    visit("epsilon", nricp.epsilon, {"an inner loop ends when the maps change less than this", "", 0, 1, {}});
    visit("max_inner", nricp.max_inner, {"solves in one round at most", "", 1, 1000, {}});
    visit("reject_crossing", nricp.reject_crossing, {"also drop correspondences that pass through the template", "", 0, 1, {}});
    visit("exact_solves", nricp.exact_solves, {"factor at every solve; about three times slower, same quality", "", 0, 1, {}});
    visit("max_surface_rms", max_surface_rms, {"fail when the surface distance is larger, over the diagonal", "", 0, 1, {}});
    visit("max_flipped_share", max_flipped_share, {"fail when a larger share of faces is flipped", "", 0, 1, {}});
  }
  std::vector<std::string> Problems() const {
    if (nricp.alpha_min > nricp.alpha_max) return {"alpha_min must not be larger than alpha_max: stiffness falls from round to round"};
    return {};
  }
};

StageSpec Spec() {
  StageSpec spec;
  spec.name = "register";
  spec.version = "1";
  spec.summary = "Bends the template onto a pose: same vertices, same faces, new positions.";
  spec.inputs = {{"source", "file", "template mesh", "", false, false},
                 {"target", "file", "clean mesh of the pose", "", false, false},
                 {"landmarks", "file", "pairs, or picks of source and target", "", true, true},
                 {"stiffness", "file", "a number for each vertex, or a mesh with painted greys", "", true, false}};
  spec.outputs = {{"registered", "file", "the template in the pose (.obj or .ply)", "registered.obj", false, false}};
  spec.memory_gib = 2;
  return spec;
}

CheckedLandmarks LoadLandmarks(StageContext& stage, const Mesh& source, const Mesh& target) {
  if (!stage.Has("landmarks")) return {};
  std::vector<PickedPair> picked;
  for (const LandmarkPair& p : ReadLandmarkPairs(stage.Inputs("landmarks"), source, target))
    picked.push_back({p.name, p.source.face, p.target.face, p.source.barycentric, p.target.barycentric});
  CheckedLandmarks checked = CheckLandmarks(picked, source, target);
  if (checked.duplicates > 0) stage.Note("dropped " + std::to_string(checked.duplicates) + " landmarks that repeat others");
  if (checked.coplanar) stage.Note("warning: the landmarks lie nearly in one plane, which flattens the result; add some off that plane");
  return checked;
}

Eigen::VectorXd LoadStiffness(StageContext& stage, int vertex_count) {
  if (!stage.Has("stiffness")) return {};
  const std::filesystem::path path = stage.Input("stiffness");
  const std::string text = ReadFile(path);
  if (text.starts_with("ply")) return StiffnessFromColors(ReadMesh(path), vertex_count, path.filename().string());
  return ParseStiffness(text, vertex_count, path.filename().string());
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
    stage.Note("warning: " + std::to_string(result.loose_components) +
               " parts of the template had too few correspondences to hold them; they stayed near their place");
}

void ReportLandmarks(StageContext& stage, const CheckedLandmarks& landmarks, const PointsX3& registered, double diagonal) {
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
  if (count == 0) return;
  stage.Report("landmark_mean_over_diag", sum / static_cast<double>(count));
  stage.Report("landmark_max_over_diag", worst);
  stage.ReportJson("landmark_residuals", list.dump());
}

RegistrationQuality ReportQuality(StageContext& stage, const Mesh& source, const PointsX3& registered, const Mesh& target) {
  const RegistrationQuality q = MeasureRegistration(source, registered, target);
  stage.Report("vertices", source.vertex_count());
  stage.Report("faces", source.face_count());
  stage.Report("flipped", q.flipped);
  stage.Report("degenerate", q.degenerate);
  stage.Report("surface_rms_over_diag", q.surface_rms);
  stage.Report("surface_mean_over_diag", q.surface_mean);
  stage.Report("hausdorff_to_target_over_diag", q.hausdorff_to_target);
  stage.Report("hausdorff_from_target_over_diag", q.hausdorff_from_target);
  stage.Report("target_diagonal", BoundingDiagonal(target.points));
  return q;
}

void Gate(const RegistrationQuality& q, int faces, const RegisterOptions& options) {
  if (q.surface_rms > options.max_surface_rms)
    throw QualityError("register: the surfaces are " + std::to_string(q.surface_rms) + " of the diagonal apart (limit " +
                       std::to_string(options.max_surface_rms) + "); add landmarks where the pose differs most");
  if (q.flipped > options.max_flipped_share * faces)
    throw QualityError("register: " + std::to_string(q.flipped) + " of " + std::to_string(faces) +
                       " faces are flipped, more than max_flipped_share allows; add landmarks where the pose differs most");
}

void Run(StageContext& stage, const RegisterOptions& options) {
  Mesh source = ReadMesh(stage.Input("source"));
  const Mesh target = ReadMesh(stage.Input("target"));
  RequireUsable(source, stage.Input("source").string());
  RequireUsable(target, stage.Input("target").string());
  const CheckedLandmarks landmarks = LoadLandmarks(stage, source, target);
  const Eigen::VectorXd stiffness = LoadStiffness(stage, source.vertex_count());
  SubProgress bending(stage.progress(), 0.0, 0.9);
  const NricpResult result = RegisterNricp(source, target, landmarks.goals, stiffness, options.nricp, &bending);
  ReportRun(stage, result);
  ReportLandmarks(stage, landmarks, result.points, BoundingDiagonal(target.points));
  Gate(ReportQuality(stage, source, result.points, target), source.face_count(), options);
  source.points = result.points;
  source.normals.resize(0, 3);
  WriteMesh(stage.Output("registered"), source);
}

}  // namespace
}  // namespace keypose::registration

int main(int argc, char** argv) {
  return keypose::RunStage<keypose::registration::RegisterOptions>(argc, argv, keypose::registration::Spec(), keypose::registration::Run);
}
