// keypose-track: a body's motion from what several cameras filmed of it.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <string>
#include <vector>

#include "core/io/meshes/bvh_io.h"
#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/frame_folder.h"
#include "core/io/pictures/image_io.h"
#include "core/io/project/rig_calibration.h"
#include "core/io/text/files.h"
#include "core/numbers/parallel.h"
#include "core/pictures/render.h"
#include "core/stage/stage.h"
#include "core/surfaces/geometry.h"
#include "core/values/angles.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "motion/body/body_clip.h"
#include "motion/films/track_input.h"
#include "motion/films/track_options.h"
#include "motion/films/track_output.h"
#include "motion/tracking/actor_fit.h"
#include "motion/tracking/calm_take.h"
#include "motion/tracking/camera_turns.h"
#include "motion/tracking/limb_retracking.h"
#include "motion/tracking/tracker.h"

namespace keypose::motion {
namespace {

constexpr int kBatch = 8;          // frames that are read at once
constexpr double kUnseenDeg = 20;  // an angle less sure than this counts as not seen
constexpr int kGoodCameras = 8, kFewCameras = 5;
constexpr int kTurnFrames = 24, kLeastTurnFrames = 8;  // that tell how a camera is turned
constexpr double kLeastTurn_px = 2;                    // of the reduced pictures
constexpr double kTurnGain = 0.9;                      // of the outlines' cost, at most

StageSpec Spec() {
  StageSpec spec;
  spec.name = "track";
  spec.version = "14";
  spec.summary = "A body's motion from the films of several cameras, by silhouettes.";
  spec.title = "Tracked body";
  spec.measurements = {{"frames", "frames"},
                       {"cameras", "cameras"},
                       {"iou_mean", "overlap with the masks, mean", "IoU", 0.9},
                       {"iou_least", "overlap with the masks, least", "IoU"},
                       {"limbs_found_again", "limbs lost and found again"},
                       {"actor_height_m", "height of the actor", "m"}};
  spec.inputs = {
      {"video", "folder",
       "one folder of numbered pictures, or one video, for each camera; masks/ and background/ "
       "beside them",
       "", false, false},
      {"calibration", "path", "cameras: OpenCV YAML, a COLMAP model, Qualisys' text, or matrices",
       "", false, false},
      {"masks", "folder", "masks/CAMERA/ of the films; by default those beside the films", "", true,
       false},
      {"actor", "file", "actor.json of an earlier run with the same actor", "", true, false}};
  spec.outputs = {
      {"frames", "folder",
       "template poses frame_0000.ply ..., distortion.json, angles.csv, actor.json", "frames",
       false, false},
      {"reference", "file", "the template upright, arms and legs apart, to pick marks on (.ply)",
       "reference.ply", true, false},
      {"motion", "file", "the motion (.bvh), y up", "motion.bvh", false, false},
      {"clocks", "file", "offsets between the films' clocks, for video3d (.json)", "clocks.json",
       true, false},
      {"rig", "file",
       "the cameras for the films' pictures, turned back where one was touched (OpenCV YAML)",
       "rig.yml", true, false},
      {"picture", "file", "the template over the film (.jpg)", "tracked.jpg", true, false}};
  spec.memory_gib = 1;
  spec.common = {"actor_frame", "cameras", "height_m", "fps", "calm"};
  return spec;
}

/// All frames tracked, from `first` to both ends.
std::vector<TrackedFrame> TrackAll(TrackInput& input, const BodyShape& shape, const BodyPose& start,
                                   int first, Progress* progress) {
  std::vector<TrackedFrame> frames(static_cast<std::size_t>(input.frames()));
  int done = 0;
  for (const int step : {1, -1}) {
    Tracker tracker(shape, start);
    const int begin = step > 0 ? first : first - 1,
              count = step > 0 ? input.frames() - first : first;
    // Backwards, the tracker starts from the pose that was found, not from the rough one.
    if (step < 0) tracker = Tracker(shape, frames[first].pose);
    for (int f = 0; f < count; f += kBatch) {
      if (progress && progress->cancelled()) throw Cancelled();
      const int batch = std::min(kBatch, count - f);
      const auto silhouettes = input.Read(begin + f * step, batch, step);
      for (int i = 0; i < batch; ++i) frames[begin + (f + i) * step] = tracker.Next(silhouettes[i]);
      done += batch;
      ReportProgress(progress, static_cast<double>(done) / input.frames(), "tracking");
    }
  }
  return frames;
}

/// Silhouettes of frames that lie near each other, asked for in rising or falling order.
class NearFrames {
 public:
  explicit NearFrames(TrackInput& input) : input_(input) {}
  const std::vector<Silhouette>& operator()(int f) {
    const int end = first_ + SizeOf(read_);
    if (f >= first_ && f < end) return read_[f - first_];
    // Who goes on to a neighbour will go on further; films are read fastest in rising order.
    const int begin = f == first_ - 1 ? std::max(0, f - kBatch + 1) : f;
    const int count = f == end ? std::min(kBatch, input_.frames() - f) : f - begin + 1;
    read_ = input_.Read(begin, count);
    first_ = begin;
    return read_[f - first_];
  }

 private:
  TrackInput& input_;
  int first_ = 0;
  std::vector<std::vector<Silhouette>> read_;
};

/// Limbs that jump followed on from both sides.
void LookAtJumps(StageContext& stage, TrackInput& input, const BodyShape& shape,
                 std::vector<TrackedFrame>* frames) {
  NearFrames near(input);
  const auto read = [&](int f) -> const std::vector<Silhouette>& {
    if (stage.progress() && stage.progress()->cancelled()) throw Cancelled();
    return near(f);
  };
  stage.Report("limbs_set_right", RetrackLimbs(shape, read, frames).changed);
}

/// Mean second difference in time of the joints' places [m/frame^2].
double SecondDifference(const std::vector<BodyPose>& poses, const BodyShape& shape) {
  std::vector<PosedBody> bodies;
  for (const BodyPose& pose : poses) bodies.push_back(Posed(pose, shape));
  double sum = 0;
  for (std::size_t f = 0; f + 2 < bodies.size(); ++f)
    for (int j = 0; j < kJoints; ++j)
      sum += (bodies[f].position[j] - 2 * bodies[f + 1].position[j] + bodies[f + 2].position[j])
                 .norm();
  return sum / kJoints / std::max(1.0, SizeOf(bodies) - 2.0);
}

/// Agreement with the masks, after poses were changed.
void CoverAgain(TrackInput& input, const BodyShape& shape, std::vector<TrackedFrame>* frames,
                Progress* progress) {
  const LocalSurface surface = SurfaceOf(shape);
  for (int f = 0; f < input.frames(); f += kBatch) {
    if (progress && progress->cancelled()) throw Cancelled();
    const int batch = std::min(kBatch, input.frames() - f);
    const auto silhouettes = input.Read(f, batch);
    ParallelFor(batch, [&](std::int64_t i) {
      TrackedFrame& frame = (*frames)[f + i];
      frame.coverage = CoverageOf(silhouettes[i], surface, Posed(frame.pose, shape));
    });
    ReportProgress(progress, static_cast<double>(f + batch) / input.frames(), "comparing");
  }
}

/// All frames made calm in time together.
void Calm(StageContext& stage, const BodyShape& shape, double strength,
          std::vector<TrackedFrame>* frames) {
  std::vector<FittedFrame> fitted;
  std::vector<BodyPose> before;
  for (const TrackedFrame& frame : *frames) {
    fitted.push_back({frame.pose, frame.evidence});
    before.push_back(frame.pose);
  }
  const CalmedTake take = CalmTake(fitted, strength);
  for (int f = 0; f < SizeOf(*frames); ++f) (*frames)[f].pose = take.poses[f];
  stage.Report("fit_noise", take.noise);
  const double trembled = SecondDifference(before, shape);
  if (trembled > 0)
    stage.Report("second_difference_ratio", SecondDifference(take.poses, shape) / trembled);
}

struct Actor {
  BodyShape shape;
  BodyPose pose;  ///< at actor_frame
};

/// The shape fitted to one pose in one frame.
/// @return how far outlines and proportions are then off
double FitFirst(const std::vector<Silhouette>& silhouettes, Actor* actor, Progress* progress) {
  std::vector<ActorFrame> frames(1);
  frames[0] = {silhouettes, actor->pose, {RestPrior()}};
  ActorOptions coarse;
  coarse.waves = false;
  coarse.rounds = 6;
  FitActor(&frames, &actor->shape, coarse, progress);
  const double cost = FitActor(&frames, &actor->shape, {}, progress);
  actor->pose = frames[0].pose.Recharted();
  return cost;
}

Actor FirstActor(TrackInput& input, const TrackOptions& options, const BodyShape* known,
                 Progress* progress) {
  constexpr int kPoses = 3;
  const int frame = std::min(options.actor_frame, input.frames() - 1);
  const std::vector<Silhouette> silhouettes = input.Read(frame, 1)[0];
  const double height = options.height_m > 0
                            ? options.height_m
                            : 0.98 * (input.hull().high.z() - input.hull().low.z());
  const BodyShape start = known ? *known : AverageShape(std::clamp(height, 1.2, 2.2));
  SubProgress searching(progress, 0, 0.7);
  const std::vector<BodyPose> poses =
      SearchPoses(silhouettes, input.hull(), input.up_from_world(), start, kPoses, &searching);
  Actor best{start, poses.front()};
  if (known) return best;
  double least = -1;
  for (const BodyPose& pose : poses) {
    Actor actor{start, pose};
    SubProgress fitting(progress, 0.7, 1);
    const double cost = FitFirst(silhouettes, &actor, &fitting);
    if (least < 0 || cost < least) {
      least = cost;
      best = actor;
    }
  }
  return best;
}

/// The shape fitted to frames spread over the performance, from a first pass over it.
void RefineActor(TrackInput& input, const TrackOptions& options,
                 const std::vector<TrackedFrame>& tracked, Actor* actor, Progress* progress) {
  const int count = std::min(options.actor_frames, input.frames());
  std::vector<ActorFrame> frames;
  for (int i = 0; i < count; ++i) {
    const int f = static_cast<int>((i + 0.5) * input.frames() / count);
    frames.push_back({input.Read(f, 1)[0], tracked[f].pose, {RestPrior()}});
  }
  ActorOptions fine;
  fine.first_reach = fine.reach;
  fine.rounds = 20;
  FitActor(&frames, &actor->shape, fine, progress);
  actor->pose = tracked[std::min(options.actor_frame, input.frames() - 1)].pose;
}

/// Turns cameras back that were touched since they were calibrated, where the outlines of many
/// frames say so.
/// @return whether any was
bool TurnCameras(StageContext& stage, TrackInput& input, const BodyShape& shape,
                 const std::vector<TrackedFrame>& tracked) {
  const int count = std::min(kTurnFrames, input.frames());
  if (count < kLeastTurnFrames) return false;
  std::vector<TurnFrame> frames;
  for (int i = 0; i < count; ++i) {
    const int f = static_cast<int>((i + 0.5) * input.frames() / count);
    frames.push_back({input.Read(f, 1)[0], tracked[f].pose});
  }
  const CameraTurns found = FindCameraTurns(std::move(frames), shape);
  const double most = *std::max_element(found.shift_px.begin(), found.shift_px.end());
  if (most < kLeastTurn_px || found.after > kTurnGain * found.before) return false;
  input.TurnCameras(found.turns);
  for (std::size_t i = 0; i < found.turns.size(); ++i) {
    if (found.shift_px[i] < kLeastTurn_px) continue;
    const View& view = input.cameras()[input.used()[i]].view();
    const double full = view.camera.fx / input.cameras()[input.used()[i]].pinhole().fx;
    char text[160];
    std::snprintf(text, sizeof text, "by %.1f degrees (%.0f pixels)",
                  found.turns[i].norm() * 180 / kPi, full * found.shift_px[i]);
    stage.Warn("by the outlines of all frames camera " + view.name + " is turned " + text +
               " against its calibration: it was touched since, or calibrated roughly; it is "
               "turned back for this motion, but calibrate the cameras again, by clicked points "
               "for example");
  }
  return true;
}

void WarnOfCameras(StageContext& stage, const TrackInput& input) {
  const int count = SizeOf(input.used());
  if (count >= kFewCameras) return;
  stage.Warn(
      std::to_string(count) +
      " cameras do not see everything: limbs that lie before or behind the "
      "body in all of them, the bend of limbs along their line of sight, and which way a limb "
      "turned are guessed; " +
      std::to_string(kGoodCameras) + " around the actor are good");
}

void WarnOfUnseen(StageContext& stage, const std::vector<TrackedFrame>& frames) {
  const std::vector<std::string> names = UnseenAngles(frames, kUnseenDeg);
  stage.Report("angles_not_seen", SizeOf(names));
  if (names.empty()) return;
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  stage.Note(
      "outlines do not tell these angles (a limb's twist about its own axis moves no outline): " +
      text + "; their variance in angles.csv is large");
}

void ReportQuality(StageContext& stage, TrackInput& input,
                   const std::vector<TrackedFrame>& frames) {
  double sum = 0, least = 1;
  int worst = 0, found = 0;
  for (int f = 0; f < SizeOf(frames); ++f) {
    const double iou = frames[f].coverage.IoU();
    sum += iou;
    if (iou < least) {
      least = iou;
      worst = f;
    }
    found += SizeOf(frames[f].found);
  }
  stage.Report("frames", SizeOf(frames));
  stage.Report("cameras", SizeOf(input.used()));
  stage.Report("iou_mean", sum / SizeOf(frames));
  stage.Report("iou_least", least);
  stage.Report("iou_least_frame", worst);
  stage.Report("limbs_found_again", found);
  if (least < 0.75)
    stage.Warn("in frame " + std::to_string(worst) + " the template covers only " +
               std::to_string(static_cast<int>(100 * least)) +
               " % of the masks: look at that frame's masks and pose");
}

/// Cameras that were not fitted to, in the frame that the actor was fitted to.
void CompareOthers(StageContext& stage, TrackInput& input, const BodyShape& shape,
                   const std::vector<TrackedFrame>& frames, int at) {
  if (input.compared().empty()) return;
  const LocalSurface surface = SurfaceOf(shape);
  double sum = 0, least = 1;
  std::string worst;
  for (const int c : input.compared()) {
    const Silhouette s =
        MakeSilhouette(input.cameras()[c], c, input.cameras()[c].Reduced(input.Mask(c, at)), 100);
    const double iou = CoverageOf({s}, surface, Posed(frames[at].pose, shape)).IoU();
    sum += iou;
    if (iou < least) {
      least = iou;
      worst = input.cameras()[c].view().name;
    }
  }
  stage.Report("iou_other_cameras", sum / SizeOf(input.compared()));
  stage.Report("iou_other_cameras_least", least);
  stage.Note("in " + std::to_string(input.compared().size()) +
             " cameras that were not fitted to, the template "
             "and the masks agree by " +
             std::to_string(sum / SizeOf(input.compared())) + " (least: " + worst + ")");
}

void WriteFrames(StageContext& stage, const TrackInput& input, const BodyShape& shape,
                 const std::vector<TrackedFrame>& frames, double fps) {
  const std::filesystem::path folder = stage.Output("frames");
  const double units = 1 / input.metres_per_unit();
  const LocalSurface surface = SurfaceOf(shape);
  Mesh mesh{BodyPoints(surface, Posed(frames[0].pose, shape)) * units, BodyFaces(), {}, {}, {}, {}};
  PlyFrames writer(mesh);
  std::vector<BodyPose> poses;
  for (int f = 0; f < SizeOf(frames); ++f) {
    poses.push_back(frames[f].pose);
    writer.Write(folder / FrameFileName(f),
                 BodyPoints(surface, Posed(frames[f].pose, shape)) * units);
  }
  if (const std::filesystem::path reference = stage.Output("reference"); !reference.empty()) {
    mesh.points = BodyPoints(surface, Posed(MarkingPose(), shape)) * units;
    WriteMesh(reference, mesh);
  }
  // Segments are rigid: area and volume do not change.
  WriteFile(folder / "distortion.json",
            FrameNotesText(std::vector<FrameMeasures>(frames.size()), fps, "track"));
  WriteFile(folder / "angles.csv", AnglesCsv(frames, fps, units));
  WriteFile(folder / "actor.json", ActorText(shape));
  const Eigen::Quaterniond y_up(Eigen::AngleAxisd(-kPi / 2, Eigen::Vector3d::UnitX()));
  MotionClip clip = ClipOf(poses, shape, 1 / fps, y_up * input.up_from_world());
  for (ClipJoint& joint : clip.joints) joint.offset *= units;
  clip.values.leftCols<3>() *= units;
  WriteBvh(stage.Output("motion"), clip);
}

/// In the unit of the calibration, as the frames.
std::string CamerasText(const TrackInput& input) {
  std::vector<View> views;
  for (const SilhouetteCamera& camera : input.cameras()) {
    views.push_back(camera.view());
    views.back().camera_from_world.translation /= input.metres_per_unit();
  }
  return OpenCvYaml(views, input.metres_per_unit() == 1);
}

void WritePicture(StageContext& stage, TrackInput& input, const BodyShape& shape,
                  const std::vector<TrackedFrame>& frames) {
  const std::filesystem::path path = stage.Output("picture");
  if (path.empty()) return;
  const LocalSurface surface = SurfaceOf(shape);
  std::vector<int> cameras = input.used();
  cameras.insert(cameras.end(), input.compared().begin(), input.compared().end());
  std::vector<Image8> tiles;
  const int moments = frames.size() > 3 ? 4 : 1;
  for (int m = 0; m < moments; ++m) {
    const int f = moments == 1 ? 0 : m * (SizeOf(frames) - 1) / (moments - 1);
    const PointsX3 points = BodyPoints(surface, Posed(frames[f].pose, shape));
    for (std::size_t i = 0; i < cameras.size() && (moments == 1 || i < 4); ++i) {
      const Image8 picture =
          Overlay(input.Picture(cameras[i], f), input.cameras()[cameras[i]].view(), points);
      tiles.push_back(Resized(picture, 480, 480 * picture.height / picture.width));
    }
  }
  WriteImage(path, TileImages(tiles, 4), 88);
}

void Run(StageContext& stage, const TrackOptions& options) {
  TrackInput input(stage, stage.Input("video"), options.Input());
  WarnOfCameras(stage, input);
  const double own_fps = input.frames_per_second() > 0 ? input.frames_per_second() : 25;
  const double fps = options.fps > 0 ? options.fps : own_fps;
  BodyShape known;
  const bool has_actor = stage.Has("actor");
  if (has_actor)
    known = ParseActor(ReadFile(stage.Input("actor")), stage.Input("actor").filename().string());
  SubProgress starting(stage.progress(), 0, 0.2);
  Actor actor = FirstActor(input, options, has_actor ? &known : nullptr, &starting);
  const int at = std::min(options.actor_frame, input.frames() - 1);
  SubProgress first(stage.progress(), 0.2, 0.5), second(stage.progress(), 0.6, 0.95),
      last(stage.progress(), 0.95, 1);
  if (!has_actor && options.actor_frames > 1 && input.frames() > 1) {
    const std::vector<TrackedFrame> rough = TrackAll(input, actor.shape, actor.pose, at, &first);
    SubProgress refining(stage.progress(), 0.5, 0.6);
    // A camera that was touched bends the body; turned back, it lets the others say how it is.
    TurnCameras(stage, input, actor.shape, rough);
    RefineActor(input, options, rough, &actor, &refining);
  }
  const auto begin = std::chrono::steady_clock::now();
  const std::clock_t cores = std::clock();
  std::vector<TrackedFrame> frames = TrackAll(input, actor.shape, actor.pose, at, &second);
  LookAtJumps(stage, input, actor.shape, &frames);
  if (options.calm > 0) Calm(stage, actor.shape, options.calm, &frames);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  stage.Report("frames_per_second", input.frames() / seconds.count());
  stage.Report("core_seconds_per_frame",
               static_cast<double>(std::clock() - cores) / CLOCKS_PER_SEC / input.frames());
  stage.Report("actor_height_m", actor.shape.height());
  if (options.calm > 0) CoverAgain(input, actor.shape, &frames, &last);
  ReportQuality(stage, input, frames);
  WarnOfUnseen(stage, frames);
  CompareOthers(stage, input, actor.shape, frames, at);
  WriteFrames(stage, input, actor.shape, frames, fps);
  if (const auto clocks = stage.Output("clocks"); !clocks.empty())
    WriteFile(clocks, ClocksText(input.offsets(), input.cameras(), input.film_clocks()));
  if (const auto rig = stage.Output("rig"); !rig.empty()) WriteFile(rig, CamerasText(input));
  WritePicture(stage, input, actor.shape, frames);
}

}  // namespace
}  // namespace keypose::motion

int main(int argc, char** argv) {
  return keypose::RunStage<keypose::motion::TrackOptions>(argc, argv, keypose::motion::Spec(),
                                                          keypose::motion::Run);
}
