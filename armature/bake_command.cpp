// `keypose armature bake`: recorded curves as the frames of an animation.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "armature/armature_commands.h"
#include "armature/bake_options.h"
#include "armature/live/joint_timing.h"
#include "armature/live/pose_text.h"
#include "armature/live/posed_puppet.h"
#include "armature/live/puppet_files.h"
#include "armature/recording/joint_curves.h"
#include "core/io/meshes/bvh_io.h"
#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/frame_folder.h"
#include "core/io/text/files.h"
#include "core/stage/stage.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::armature {
namespace {

namespace fs = std::filesystem;

constexpr int kMostFrames = 1000000;

StageSpec BakeSpec() {
  StageSpec spec;
  spec.name = "armature bake";
  spec.version = "2";
  spec.summary = "Makes the frames of an animation from recorded curves of an armature.";
  spec.inputs = PuppetPorts();
  spec.inputs.insert(
      spec.inputs.begin() + 2,
      {"curves", "file", "recorded curves (curves.json of a session)", "", false, false});
  spec.outputs = {
      {"frames", "folder", "frame_0000.ply ... and distortion.json", "frames", false, false},
      {"motion", "file", "the computer skeleton's motion (.bvh)", "motion.bvh", true, false},
      {"rest", "file", "the mesh at rest, with the frames' vertices (.ply)", "rest.ply", true,
       false},
      {"timeline", "file", "when each key stands, for interpolate (.json); with between keys",
       "timeline.json", true, false}};
  spec.memory_gib = 1;
  spec.common = {"between", "step"};
  return spec;
}

JointCurves BakedCurves(StageContext& stage, const Armature& armature) {
  const fs::path path = stage.Input("curves");
  JointCurves curves = ParseCurvesJson(ReadFile(path), PrintableName(path), armature);
  if (curves.frame_count() == 0)
    throw InputError("armature bake: " + PrintableName(path) +
                     " has no frame; record some with `keypose armature record`");
  if (const std::string words = LeftOutWords(curves); !words.empty()) stage.Warn(words);
  return curves;
}

int StepOf(const JointCurves& curves, const BakeOptions& options) {
  const int step = options.step > 0 ? options.step : curves.step;
  if (static_cast<double>(curves.frame_count()) * step > kMostFrames)
    throw InputError(
        fmt::format("armature bake: {} recorded frames of {} film frames each; at "
                    "most {} are possible",
                    curves.frame_count(), step, kMostFrames));
  return step;
}

Eigen::MatrixXd KeyValues(const Eigen::MatrixXd& recorded) {
  const std::vector<PoseRun> runs = PoseRuns(recorded);
  Eigen::MatrixXd keys(SizeOf(runs), recorded.cols());
  for (int k = 0; k < SizeOf(runs); ++k) keys.row(k) = recorded.row(runs[k].first);
  return keys;
}

Eigen::MatrixXd ValuesOf(const Eigen::MatrixXd& recorded, int step, const std::string& between) {
  if (between == "keys") return KeyValues(recorded);
  return FilmValues(recorded, step, BetweenNamed(between));
}

/// The timeline on which interpolate puts the keys: each where it was recorded, standing as long as
/// the puppet rested.
std::string TimelineText(const Eigen::MatrixXd& recorded, int step, double fps) {
  const std::vector<PoseRun> runs = PoseRuns(recorded);
  if (runs.size() < 2)
    throw InputError(
        "armature bake: all recorded frames are one pose; in-betweens need two at least");
  nlohmann::ordered_json keys = nlohmann::ordered_json::array();
  for (const PoseRun& run : runs) {
    nlohmann::ordered_json key = {{"pose", fmt::format("recorded_{}", run.first)},
                                  {"time", run.first * step / fps}};
    if (run.count > 1) key["hold"] = (run.count - 1) * step / fps;
    keys.push_back(key);
  }
  const nlohmann::ordered_json all = {{"schema", 2}, {"fps", fps}, {"keys", keys}};
  return all.dump(1) + "\n";
}

/// Writes frames and keeps what is known of them.
class Baker {
 public:
  Baker(StageContext& stage, const PuppetParts& parts)
      : stage_(stage),
        parts_(parts),
        out_(stage.Output("frames")),
        puppet_(parts),
        writer_(parts.mesh),
        area_(SurfaceArea(parts.mesh.points, parts.mesh.faces)),
        volume_(SignedVolume(parts.mesh.points, parts.mesh.faces)) {}

  void Add(const Eigen::RowVectorXd& values, int frame) {
    puppet_.Update({values.data(), values.data() + values.size()});
    const PointsX3& points = puppet_.points();
    writer_.Write(out_ / FrameFileName(frame), points);
    measures_.push_back({area_ > 0 ? SurfaceArea(points, parts_.mesh.faces) / area_ : 1,
                         volume_ > 0 ? SignedVolume(points, parts_.mesh.faces) / volume_ : 1});
    poses_.push_back(puppet_.matcher().pose());
    for (const ChainState& chain : puppet_.matcher().chains()) {
      const double length = chain.chain_length;
      far_ = std::max(far_, chain.match.far_gap / length);
      near_ = std::max(near_, chain.match.near_gap / length);
      distance_ = std::max(distance_, chain.match.mean_distance / length);
    }
  }

  void Finish(double fps) {
    WriteFile(out_ / "distortion.json", FrameNotesText(measures_, fps, "armature"));
    if (const fs::path motion = stage_.Output("motion"); !motion.empty())
      WriteBvh(motion, SkeletonClip(parts_.skeleton, poses_, fps));
    if (const fs::path rest = stage_.Output("rest"); !rest.empty()) WriteMesh(rest, parts_.mesh);
    stage_.Report("frames", SizeOf(measures_));
    stage_.Report("fps", fps);
    stage_.Report("vertices", parts_.mesh.vertex_count());
    stage_.Report("near_anchor_gap_over_length", near_);
    stage_.Report("far_anchor_gap_over_length", far_);
    stage_.Report("curve_distance_over_length", distance_);
    if (std::max(near_, far_) > 1e-3)
      stage_.Warn(fmt::format(
          "a chain misses an anchor by up to {:.2g} % of its length: the computer skeleton's is "
          "too short for the armature's pose, or its joints are matched one to one; lengthen it, "
          "or choose with unreachable which anchor it keeps",
          100 * std::max(near_, far_)));
  }

 private:
  StageContext& stage_;
  const PuppetParts& parts_;
  const fs::path out_;
  PosedPuppet puppet_;
  PlyFrames writer_;
  double area_, volume_;
  std::vector<FrameMeasures> measures_;
  std::vector<SkeletonPose> poses_;
  double near_ = 0, far_ = 0, distance_ = 0;
};

void RunBake(StageContext& stage, const BakeOptions& options) {
  if (!stage.Output("timeline").empty() && options.between != "keys")
    throw UsageError("armature bake: a timeline is for keys; choose between keys");
  const LoadedPuppet loaded = LoadPuppet(PuppetPathsIn(stage), options.puppet);
  for (const std::string& note : loaded.notes) stage.Note(note);
  for (const std::string& warning : loaded.warnings) stage.Warn(warning);
  const JointCurves curves = BakedCurves(stage, loaded.parts.armature);
  const double fps = options.fps > 0 ? options.fps : curves.fps;
  const int step = StepOf(curves, options);
  const Eigen::MatrixXd recorded =
      options.smooth > 0 ? Smoothed(curves.values, options.smooth) : curves.values;
  const Eigen::MatrixXd values = ValuesOf(recorded, step, options.between);
  if (const fs::path timeline = stage.Output("timeline"); !timeline.empty())
    WriteFile(timeline, TimelineText(recorded, step, fps));
  const int count = static_cast<int>(values.rows());
  Baker baker(stage, loaded.parts);
  for (int f = 0; f < count; ++f) {
    ReportProgress(stage.progress(), f / static_cast<double>(count), "posing");
    baker.Add(values.row(f), f);
  }
  baker.Finish(fps);
}

}  // namespace

int BakeCommand(int argc, char** argv) {
  return RunStage<BakeOptions>(argc, argv, BakeSpec(), RunBake);
}

}  // namespace keypose::armature
