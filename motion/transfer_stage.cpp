// keypose-transfer: the motion of a template on another mesh.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/io/meshes/mesh_io.h"
#include "core/io/meshes/polygon_mesh.h"
#include "core/io/pictures/frame_folder.h"
#include "core/io/project/landmarks_io.h"
#include "core/io/text/files.h"
#include "core/stage/stage.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_binding.h"
#include "core/surfaces/mesh_checks.h"
#include "core/surfaces/seams.h"
#include "core/values/angles.h"
#include "core/values/errors.h"
#include "core/values/same_faces.h"
#include "core/values/size_of.h"
#include "motion/transfer.h"
#include "motion/transfer_options.h"

namespace keypose::motion {
namespace {

namespace fs = std::filesystem;

constexpr double kPoorWeight = -1e-3;
constexpr double kSurelyMirrored = 0.5;    // of the residual of the marks as they are
constexpr double kLeaning = 30 * kDegree;  // between the two meshes' uprights
constexpr double kOtherPose = 0.1;         // of the diagonal, that a mark moves
constexpr double kOtherRate = 0.01;        // of the rate
constexpr int kFewMarks = 8;
constexpr double kUsualRate = 24;  // frames per second

StageSpec Spec() {
  StageSpec spec;
  spec.name = "transfer";
  spec.version = "5";
  spec.summary = "Moves a mesh as a template moves, by marked triangles.";
  spec.title = "Moving scan";
  spec.measurements = {
      {"marks", "marks"},
      {"volume_deviation", "largest change of volume", "share", -kAnyNumber, 0.02}};
  spec.inputs = {
      {"template", "folder", "frames of the moving template: frame_0000.ply, ...", "", false,
       false},
      {"target", "file", "the mesh that shall move", "", false, false},
      {"marks", "file", "pairs of triangles: source on the template, target on the mesh", "", false,
       true},
      {"reference", "file",
       "the template in the pose that resembles the target's, on which the marks were picked; by "
       "default its first frame",
       "", true, false}};
  spec.inputs.push_back({"pins", "file", "marks that are held at places (.json)", "", true, false});
  spec.outputs = {
      {"frames", "folder", "frame_0000.ply ... and distortion.json", "frames", false, false}};
  spec.memory_gib = 1;
  spec.common = {"method", "turns"};
  return spec;
}

TransferOptions OptionsOf(const TransferStageOptions& given) {
  TransferOptions options;
  options.method = TransferMethod::kAuto;
  if (given.method == "paper") options.method = TransferMethod::kPaper;
  if (given.method == "literal") options.method = TransferMethod::kLiteral;
  options.align = given.align == "auto";
  options.follow = given.turns == "follow";
  options.rest = given.rest;
  options.volume = given.volume;
  options.stretch = given.stretch;
  options.scale = given.scale;
  options.feet = given.feet;
  return options;
}

/// Largest way of a mark on the template from where it was picked, over the diagonal; 0 where the
/// file does not say.
double LargestWay(const nlohmann::json& root, const Mesh& mesh) {
  double way = 0;
  try {
    for (const nlohmann::json& entry : root.at("pairs")) {
      const nlohmann::json& pick = entry.at("source");
      const auto face = pick.at("face").get<std::int64_t>();
      const auto at = pick.at("position").get<std::array<double, 3>>();
      if (face < 0 || face >= mesh.face_count()) continue;
      const Eigen::RowVector3d corner = mesh.points.row(mesh.faces(face, 0));
      way = std::max(way, (corner - Eigen::RowVector3d(at[0], at[1], at[2])).norm());
    }
  } catch (const nlohmann::json::exception&) {
    return 0;  // who reads the marks says what is wrong with them
  }
  return way / BoundingDiagonal(mesh.points);
}

/// The marks' file for this pose of the template. Frames of one template share their faces, so
/// marks that were picked in another pose hold by the numbers of their triangles; their places in
/// space, which the file has too, are not those of this pose.
std::vector<fs::path> MarksForPose(StageContext& stage, const Mesh& reference) {
  const std::vector<fs::path> given = stage.Inputs("marks");
  if (given.size() != 1) return given;
  const std::string text = ReadFile(given[0]);
  nlohmann::json root =
      IsShallowJson(text) ? nlohmann::json::parse(text, nullptr, false) : nlohmann::json();
  if (!root.is_object() || !root.contains("source") || !root["source"].is_object()) return given;
  nlohmann::json& binding = root["source"];
  const std::string geometry = GeometryHash(reference);
  if (binding.value("faces_sha256", nlohmann::json()) != NumberingHash(reference) ||
      binding.value("sha256", nlohmann::json()) == geometry)
    return given;
  binding["sha256"] = geometry;
  const fs::path carried = stage.Scratch() / given[0].filename();
  WriteFile(carried, root.dump());
  const std::string fact = given[0].filename().string() +
                           " was picked on the template in another pose than " +
                           (stage.Has("reference") ? "that of --reference" : "its first frame") +
                           ", and its triangles are taken by their numbers";
  if (LargestWay(root, reference) > kOtherPose)
    stage.Warn(fact +
               "; pass the pose that it was picked in as --reference, else the target's "
               "limbs are wrong by the difference");
  else
    stage.Note(fact);
  return {carried};
}

std::vector<Mark> LoadMarks(StageContext& stage, const Mesh& reference, const Mesh& target) {
  CarryLog log;
  int suggested = 0;
  std::vector<Mark> marks;
  for (const LandmarkPair& pair :
       ReadLandmarkPairs(MarksForPose(stage, reference), reference, target, &log)) {
    suggested += !pair.confirmed;
    marks.push_back({pair.name,
                     {pair.source.face, pair.source.barycentric},
                     {pair.target.face, pair.target.barycentric}});
  }
  for (const std::string& note : log.notes) stage.Note(note);
  for (const std::string& warning : log.warnings) stage.Warn(warning);
  if (suggested > 0)
    stage.Warn(std::to_string(suggested) +
               " marks are unconfirmed suggestions; look at them in the studio, or confirm them "
               "with keypose landmarks suggest --accept");
  if (SizeOf(marks) < kFewMarks)
    stage.Warn("there are only " + std::to_string(marks.size()) +
               " marks: a limb without a mark moves as the rest of the body; pick 20 to 80");
  return marks;
}

/// {"pins": [{"mark", "from", "to", "at": [x, y, z]}]}
std::vector<Pin> LoadPins(const fs::path& path) {
  const std::string name = path.filename().string();
  const nlohmann::json root = nlohmann::json::parse(ReadFile(path), nullptr, false);
  if (!root.is_object() || !root.contains("pins") || !root["pins"].is_array())
    throw InputError("transfer: " + name + " is not JSON with a list `pins`");
  std::vector<Pin> pins;
  for (const nlohmann::json& entry : root["pins"]) {
    const std::string what = "transfer: " + name + ": pin " + std::to_string(pins.size()) + " ";
    if (!entry.is_object() || !entry.contains("mark") || !entry["mark"].is_string())
      throw InputError(what + "names no `mark`");
    for (const char* key : {"from", "to"})
      if (!entry.contains(key) || !entry[key].is_number_integer())
        throw InputError(what + "needs whole numbers `from` and `to`: frames, counted from 0");
    Pin pin{entry["mark"], entry["from"], entry["to"], {}};
    if (entry.contains("at")) {
      const nlohmann::json& at = entry["at"];
      if (!at.is_array() || at.size() != 3 ||
          !std::all_of(at.begin(), at.end(), [](const auto& x) { return x.is_number(); }))
        throw InputError(what + "needs three numbers in `at`");
      pin.at = Eigen::RowVector3d(at[0], at[1], at[2]);
      if (!pin.at->allFinite()) throw InputError(what + "has a place that is not finite");
    }
    pins.push_back(std::move(pin));
  }
  return pins;
}

void WarnOfMarks(StageContext& stage, const TransferReport& report) {
  const Alignment& a = report.alignment;
  if (a.certain && a.mirrored < kSurelyMirrored * a.residual)
    stage.Warn(
        "the marks fit a mirror image better: left and right seem to be exchanged on one of "
        "the meshes; check the marks of hands and feet");
  if (a.certain && a.tilt > kLeaning)
    stage.Warn(
        "the target leans by " + std::to_string(std::lround(a.tilt / kDegree)) +
        " degrees against the template: z must be up in both, else feet, ground and the "
        "length of the path are wrong. Turn the one that does not stand (an OBJ from another "
        "program mostly has y up; frames of track stand as their calibration does)");
  if (report.least_weight < kPoorWeight)
    stage.Warn(
        "long thin triangles make the fields overshoot; remesh the target with keypose "
        "cleanup, or use --method auto");
  if (report.turned)
    stage.Note("the motion is turned by " + std::to_string(std::lround(a.heading / kDegree)) +
               " degrees about z, as the marks of the target are");
}

void ReportRun(StageContext& stage, const TransferReport& report,
               const std::vector<FrameMeasures>& measures, int marks, double diagonal) {
  stage.Report("frames", SizeOf(measures));
  stage.Report("marks", marks);
  stage.Report("heading_deg", report.turned ? report.alignment.heading / kDegree : 0.0);
  stage.Report("marks_residual", report.alignment.residual);
  stage.Report("path_scale", report.path_scale);
  stage.Report("largest_rest_turn_deg", report.largest_rest_turn / kDegree);
  stage.Report("least_weight", report.least_weight);
  stage.Report("parts_without_marks", report.unmarked_parts);
  stage.Report("largest_turn_between_marks_deg", report.largest_turn_between / kDegree);
  stage.Report("volume_deviation_before", report.volume_before);
  double deviation = 0;
  for (const FrameMeasures& frame : measures)
    deviation = std::max(deviation, std::abs(frame.volume - 1));
  stage.Report("volume_deviation", deviation);
  stage.Report("volume_move_over_diag", report.volume_move_over_diag);
  stage.Report("soles", report.holds.soles);
  stage.Report("contacts", report.holds.contacts);
  stage.Report("root_shift_over_diag", report.holds.root_shift / diagonal);
  stage.Report("held_move_over_diag", report.holds.held_move / diagonal);
}

/// Frames are not made anew for another rate.
void WarnOfRate(StageContext& stage, double wanted, double rate) {
  if (!(wanted > 0 && rate > 0) || std::abs(wanted - rate) <= kOtherRate * rate) return;
  char factor[32];
  std::snprintf(factor, sizeof factor, "%.3g", wanted / rate);
  stage.Warn(
      std::string("with this `fps` the motion goes ") + factor +
      " times as fast as the template, whose frames are not made anew; leave `fps` at 0, and "
      "make the template with the rate that you want");
}

/// The faces that the frames must have: those of the reference, or another cut of its polygons.
FacesX3 FacesOfFrames(StageContext& stage, const fs::path& first, const Mesh& reference) {
  return stage.Has("reference") ? ReadMeshCutAs(stage.Input("reference"), ReadMesh(first)).faces
                                : reference.faces;
}

Mesh ReadTemplate(const fs::path& path, const Mesh& reference, const FacesX3& faces) {
  Mesh frame = ReadMesh(path);
  if (frame.points.rows() != reference.points.rows() || !SameFaces(frame.faces, faces))
    throw InputError("transfer: " + path.filename().string() +
                     " of the template does not have the faces of its reference; all frames must "
                     "be of one mesh");
  RequireFinite(frame.points, "transfer: " + path.filename().string() + " of the template");
  return frame;
}

void Run(StageContext& stage, const TransferStageOptions& options) {
  const fs::path folder = stage.Input("template");
  const std::vector<fs::path> paths = NumberedFrames(folder, "transfer");
  const Mesh reference = ReadMesh(stage.Has("reference") ? stage.Input("reference") : paths[0]);
  RequireUsable(reference, "transfer: the template");
  const Mesh target = ReadMesh(stage.Input("target"));
  RequireUsable(target, "transfer: the target");
  const std::vector<Mark> marks = LoadMarks(stage, reference, target);
  const double rate = FrameRateOf(folder), own_fps = rate > 0 ? rate : kUsualRate;
  const double fps = options.fps > 0 ? options.fps : own_fps;
  WarnOfRate(stage, options.fps, rate);
  TransferOptions how = OptionsOf(options);
  how.fps = fps;
  if (stage.Has("pins")) how.pins = LoadPins(stage.Input("pins"));
  if (!how.pins.empty() && how.method != TransferMethod::kAuto)
    throw UsageError("transfer: pins need --method auto");
  const WeldedMesh whole = WeldWholeFaces(target);  // else charts of its texture part
  Transfer transfer(whole.mesh, reference.points, reference.faces, marks, how);
  WarnOfMarks(stage, transfer.report());
  SubProgress reading(stage.progress(), 0, 0.3), making(stage.progress(), 0.3, 1);
  const FacesX3 faces = FacesOfFrames(stage, paths[0], reference);
  for (const fs::path& path : paths) {
    ReportProgress(&reading, transfer.frame_count() / static_cast<double>(paths.size()),
                   "reading the template");
    transfer.Add(ReadTemplate(path, reference, faces).points, path.filename().string());
  }
  const fs::path out = stage.Output("frames");
  PlyFrames writer(target);
  const double area = SurfaceArea(target.points, target.faces),
               volume = SignedVolume(target.points, target.faces);
  std::vector<FrameMeasures> measures;
  transfer.Run(
      [&](int frame, const PointsX3& of_whole) {
        const PointsX3 points = of_whole(whole.of_input, Eigen::all);
        writer.Write(out / FrameFileName(frame),
                     options.space == "template" ? transfer.InTemplateSpace(points) : points);
        measures.push_back({area > 0 ? SurfaceArea(points, target.faces) / area : 1,
                            volume != 0 ? SignedVolume(points, target.faces) / volume : 1});
      },
      &making);
  WriteFile(out / "distortion.json", FrameNotesText(measures, fps, options.method));
  ReportRun(stage, transfer.report(), measures, SizeOf(marks), BoundingDiagonal(target.points));
}

}  // namespace
}  // namespace keypose::motion

int main(int argc, char** argv) {
  return keypose::RunStage<keypose::motion::TransferStageOptions>(
      argc, argv, keypose::motion::Spec(), keypose::motion::Run);
}
