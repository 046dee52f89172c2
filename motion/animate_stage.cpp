// keypose-animate: a motion clip on a rigged mesh.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/io/meshes/bvh_io.h"
#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/frame_folder.h"
#include "core/io/text/files.h"
#include "core/numbers/statistics.h"
#include "core/stage/stage.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "motion/animate_options.h"
#include "motion/bvh_rig/joint_names.h"
#include "motion/bvh_rig/retarget.h"
#include "motion/bvh_rig/rig_text.h"
#include "motion/bvh_rig/rigged_mesh.h"

namespace keypose::motion {
namespace {

namespace fs = std::filesystem;

constexpr double kGroundShare = 0.1;  // of the frames whose lowest vertices lie on the ground

StageSpec Spec() {
  StageSpec spec;
  spec.name = "animate";
  spec.version = "4";
  spec.summary = "Moves a rigged mesh by a motion clip: a template for transfer.";
  spec.title = "Motion of a clip";
  spec.inputs = {
      {"clip", "file", "motion clip (.bvh)", "", false, false},
      {"mesh", "file", "the rig's mesh, in the pose in which it is bound", "", false, false},
      {"skeleton", "file", "the rig's bones (.mhskel or .tgf)", "", false, false},
      {"weights", "file", "the bones' weights (.mhw or .dmat)", "", false, false},
      {"joints", "file", "table of the clip's joints and the rig's bones (.json)", "", true,
       false}};
  spec.outputs = {
      {"frames", "folder", "frame_0000.ply ... and distortion.json", "frames", false, false},
      {"reference", "file", "the mesh as it is bound, upright (.ply)", "reference.ply", true,
       false}};
  spec.memory_gib = 1;
  spec.common = {"fps", "from", "to"};
  return spec;
}

/// {"joints": {"CLIP JOINT": "RIG BONE", ...}}
std::vector<JointName> LoadTable(const fs::path& path) {
  const std::string name = path.filename().string();
  const nlohmann::json root = nlohmann::json::parse(ReadFile(path), nullptr, false);
  if (!root.is_object() || !root.contains("joints") || !root["joints"].is_object())
    throw InputError("animate: " + name + " is not JSON with an object `joints`");
  std::vector<JointName> table;
  for (const auto& [joint, bone] : root["joints"].items()) {
    if (!bone.is_string())
      throw InputError("animate: " + name + ": the bone of '" + joint + "' is not a name");
    table.push_back({joint, bone});
  }
  if (table.empty()) throw InputError("animate: " + name + " names no joint");
  return table;
}

/// The moment of each frame of the result, in frames of the clip.
std::vector<double> MomentsOf(const MotionClip& clip, const AnimateOptions& options) {
  constexpr double kSameMoment = 0.02;  // of a frame: as times like 0.0083333 are rounded
  if (clip.frame_count() == 0) throw InputError("animate: the clip has no frames");
  const double length = clip.frame_time_s * (clip.frame_count() - 1),
               end = options.to > 0 ? std::min(options.to, length) : length;
  if (options.from > end)
    throw UsageError("animate: the clip is " + std::to_string(length) +
                     " s long; `from` must be before that and before `to`");
  std::vector<double> moments;
  for (int k = 0;; ++k) {
    const double at = options.from + k / options.fps;
    if (at > end + kSameMoment * clip.frame_time_s) break;
    const double moment = std::min(at / clip.frame_time_s, clip.frame_count() - 1.0),
                 whole = std::round(moment);
    moments.push_back(std::abs(moment - whole) < kSameMoment ? whole : moment);
  }
  return moments;
}

UpAxes UpOf(const RestUps& rest, const std::string& up) {
  if (up == "auto") return {rest.clip.axis, rest.rig.axis};
  return up == "y" ? UpAxes{1, 1} : UpAxes{2, 2};
}

/// What a person would otherwise only see in the frames.
void WarnOfClip(StageContext& stage, const MotionClip& clip, const RiggedMesh& rig,
                const std::vector<int>& joints, const RestUps& rest,
                const AnimateOptions& options) {
  std::string missing;
  for (const std::string& bone : BonesWithoutJoint(rig, joints))
    missing += (missing.empty() ? "" : ", ") + bone;
  if (!missing.empty())
    stage.Warn("no joint of the clip moves the bones " + missing +
               ": they only ride on the bones that they hang on. Name their joints with --joints: "
               "{\"joints\": {\"CLIP JOINT\": \"RIG BONE\", ...}}; the others are still found");
  if (rest.clip.has_legs && !rest.clip.upright)
    stage.Warn(
        "the clip's rest pose (all angles zero) does not stand on its legs, so trunk, head and "
        "feet are posed wrongly; export the clip from a rig that rests in a T pose or an A pose");
  const UpAxes up = UpOf(rest, options.up);
  if ((rest.clip.upright && rest.clip.axis != up.clip) ||
      (rest.rig.upright && rest.rig.axis != up.rig))
    stage.Warn("by their legs at rest, " + std::string(1, "xyz"[rest.clip.axis]) +
               " is up in the clip and " + std::string(1, "xyz"[rest.rig.axis]) +
               " in the rig, but `up` says otherwise; leave it at auto");
  if (BeginsWithItsRest(clip) && options.from < 0.5 * clip.frame_time_s) {
    char from[32];
    std::snprintf(from, sizeof from, "%.4f", clip.frame_time_s);
    stage.Warn(
        "the clip's first frame is its rest pose, and the motion begins after it; leave it "
        "out with --from " +
        std::string(from));
  }
}

/// y up to z up: what looks along z then looks along -y, to the front.
PointsX3 Upright(const PointsX3& points, bool y_up) {
  if (!y_up) return points;
  PointsX3 upright(points.rows(), 3);
  upright << points.col(0), -points.col(2), points.col(1);
  return upright;
}

/// The height on which the feet stand, through all frames.
double GroundOf(const RiggedMesh& rig, const Retarget& retarget, const std::vector<double>& moments,
                bool y_up) {
  std::vector<double> lowest;
  for (double moment : moments)
    lowest.push_back(Skinned(rig, retarget.At(moment)).col(y_up ? 1 : 2).minCoeff());
  return QuantileFloor(std::move(lowest), kGroundShare);
}

void Run(StageContext& stage, const AnimateOptions& options) {
  std::vector<std::string> notes;
  const MotionClip clip = ReadBvh(stage.Input("clip"), &notes);
  for (const std::string& note : notes) stage.Warn(note);
  Mesh mesh = ReadMesh(stage.Input("mesh"));
  RequireUsable(mesh, "animate: the rig's mesh");
  const fs::path skeleton = stage.Input("skeleton"), weights = stage.Input("weights");
  RiggedMesh rig = MakeRig(std::move(mesh), ReadFile(skeleton), skeleton.filename().string(),
                           ReadFile(weights), weights.filename().string());
  if (!options.all_parts) rig = LargestPart(rig);
  const std::vector<int> joints = MatchJoints(
      clip, rig, stage.Has("joints") ? LoadTable(stage.Input("joints")) : std::vector<JointName>());
  const RestUps rest = UpsAtRest(clip, rig, joints);
  const UpAxes up = UpOf(rest, options.up);
  const bool y_up = up.rig == 1;
  const Retarget retarget(clip, rig, joints, up);
  const std::vector<double> moments = MomentsOf(clip, options);
  WarnOfClip(stage, clip, rig, joints, rest, options);
  const double ground = GroundOf(rig, retarget, moments, y_up);
  const fs::path out = stage.Output("frames");
  Mesh bound;
  bound.faces = rig.mesh.faces;
  bound.points = Upright(rig.mesh.points, y_up);
  bound.points.col(2).array() -= bound.points.col(2).minCoeff();
  PlyFrames writer(bound);
  const double area = SurfaceArea(bound.points, bound.faces),
               volume = SignedVolume(bound.points, bound.faces);
  std::vector<FrameMeasures> measures;
  for (int k = 0; k < SizeOf(moments); ++k) {
    ReportProgress(stage.progress(), k / static_cast<double>(moments.size()), "posing");
    PointsX3 points = Upright(Skinned(rig, retarget.At(moments[k])), y_up);
    points.col(2).array() -= ground;
    writer.Write(out / FrameFileName(k), points);
    measures.push_back({area > 0 ? SurfaceArea(points, bound.faces) / area : 1,
                        volume != 0 ? SignedVolume(points, bound.faces) / volume : 1});
  }
  WriteFile(out / "distortion.json", FrameNotesText(measures, options.fps, "animate"));
  if (const fs::path reference = stage.Output("reference"); !reference.empty())
    WriteMesh(reference, bound);
  stage.Report("frames", SizeOf(moments));
  stage.Report("vertices", bound.vertex_count());
  stage.Report("bones", SizeOf(rig.bones));
  stage.Report("bones_with_joints", static_cast<int>(std::count_if(joints.begin(), joints.end(),
                                                                   [](int j) { return j >= 0; })));
  stage.Report("path_scale", retarget.scale());
  for (int b = 0; b < SizeOf(rig.bones); ++b)
    if (joints[b] >= 0)
      stage.Note("bone " + rig.bones[b].name + " follows joint " + clip.joints[joints[b]].name);
}

}  // namespace
}  // namespace keypose::motion

int main(int argc, char** argv) {
  return keypose::RunStage<keypose::motion::AnimateOptions>(argc, argv, keypose::motion::Spec(),
                                                            keypose::motion::Run);
}
