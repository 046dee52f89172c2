#include "synth/commands/performance_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/io/meshes/bvh_io.h"
#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/frame_folder.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/png_io.h"
#include "core/io/project/rig_calibration.h"
#include "core/io/text/files.h"
#include "core/numbers/parallel.h"
#include "core/pictures/render.h"
#include "core/surfaces/geometry.h"
#include "core/values/angles.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "synth/photographs/filmed_set.h"
#include "synth/photographs/mask_fill.h"
#include "synth/worlds/noise.h"

namespace keypose::synth {
namespace {

namespace fs = std::filesystem;

void MakeFilmFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw DiskError("synth: cannot create the folder " + folder.string() + ": " + error.message());
}

// Frames in which the actor stands with arms and legs apart, as actors do for their measures, and
// frames on the way from there into the motion.
constexpr int kStanding = 6, kOnTheWay = 18;

/// The values of a pose with arms and legs apart, where the given frame has its root.
Eigen::RowVectorXd StartValues(const MotionClip& clip, int frame) {
  Eigen::RowVectorXd values = Eigen::RowVectorXd::Zero(clip.channel_count());
  int column = 0;
  for (const ClipJoint& joint : clip.joints)
    for (const BvhChannel channel : joint.channels) {
      const bool root = joint.parent < 0;
      if (root && channel != BvhChannel::kXrotation && channel != BvhChannel::kZrotation)
        values[column] = clip.values(frame, column);
      if (channel == BvhChannel::kZrotation && joint.name == "LeftShoulder") values[column] = 55;
      if (channel == BvhChannel::kZrotation && joint.name == "RightShoulder") values[column] = -55;
      ++column;
    }
  return values;
}

/// The clip with another beginning: its own frames wait until the start pose is left.
void BeginStanding(MotionClip* clip) {
  const int before = std::min(kStanding + kOnTheWay, clip->frame_count() - 1);
  const Eigen::RowVectorXd start = StartValues(*clip, 0), first = clip->values.row(0);
  for (int f = clip->frame_count() - 1; f >= before; --f)
    clip->values.row(f) = clip->values.row(f - before).eval();
  for (int f = 0; f < before; ++f) {
    const double t = std::clamp((f - kStanding) / static_cast<double>(kOnTheWay), 0.0, 1.0);
    const double ease = t * t * (3 - 2 * t);
    clip->values.row(f) = (1 - ease) * start + ease * first;
  }
}

MotionClip ClipFor(const PerformanceCommand& command) {
  if (command.bvh.empty()) {
    MotionClip own = MakeOwnMotion(command.frames, 30, command.performer.seed);
    if (command.start_pose) BeginStanding(&own);
    return own;
  }
  MotionClip clip = ReadBvh(command.bvh);
  const int wanted =
      command.start_pose ? std::max(1, command.frames - kStanding - kOnTheWay) : command.frames;
  const int last = command.first_frame + (wanted - 1) * command.every;
  if (last >= clip.frame_count())
    throw InputError(fmt::format("synth: {} has {} frames; {} frames from {}, every {}, need {}",
                                 PrintableName(command.bvh.filename()), clip.frame_count(), wanted,
                                 command.first_frame, command.every, last + 1));
  MotionClip chosen = clip;
  chosen.values.resize(command.frames, clip.values.cols());
  for (int f = 0; f < command.frames; ++f)
    chosen.values.row(f) = clip.values.row(std::min(command.first_frame + f * command.every, last));
  chosen.frame_time_s = clip.frame_time_s * command.every;
  if (command.start_pose) BeginStanding(&chosen);
  return chosen;
}

/// How far from the middle of the floor the actor gets [m].
double ReachOf(const Performer& performer) {
  double reach = 0;
  for (int f = 0; f < performer.frame_count(); ++f)
    reach = std::max(reach, performer.Joints(f).leftCols<2>().rowwise().norm().maxCoeff());
  return reach;
}

std::string JointsCsv(const Performer& performer) {
  std::string text = "frame,joint,x,y,z\n";
  for (int f = 0; f < performer.frame_count(); ++f) {
    const PointsX3 joints = performer.Joints(f);
    for (int j = 0; j < joints.rows(); ++j)
      text += fmt::format("{},{},{:.6f},{:.6f},{:.6f}\n", f, Performer::JointNames()[j],
                          joints(j, 0), joints(j, 1), joints(j, 2));
  }
  return text;
}

/// Faces of the left arm from the shoulder on, in the bind pose's vertices: those beyond the joint.
FacesX3 WithoutLeftArm(const Mesh& bind, const Performer& performer, int frame,
                       const PointsX3& points) {
  const PointsX3 joints = performer.Joints(frame);
  const auto& names = Performer::JointNames();
  const auto at = [&](const char* name) {
    const auto found = std::find(names.begin(), names.end(), name);
    return Eigen::Vector3d(joints.row(found - names.begin()));
  };
  const Eigen::Vector3d elbow = at("LeftElbow"), shoulder = at("LeftShoulder"),
                        wrist = at("LeftWrist");
  const auto near = [](const Eigen::Vector3d& x, const Eigen::Vector3d& a,
                       const Eigen::Vector3d& b) {
    const double h = std::clamp((x - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
    return (x - a - h * (b - a)).norm() < 0.085;
  };
  const Eigen::Vector3d hand = wrist + 0.19 * (wrist - elbow).normalized();
  const Eigen::Vector3d upper = shoulder + 0.35 * (elbow - shoulder);
  std::vector<int> kept;
  for (int f = 0; f < bind.faces.rows(); ++f) {
    const Eigen::Vector3d x = points.row(bind.faces(f, 0));
    if (!near(x, upper, elbow) && !near(x, elbow, wrist) && !near(x, wrist, hand))
      kept.push_back(f);
  }
  FacesX3 faces(SizeOf(kept), 3);
  for (int i = 0; i < SizeOf(kept); ++i) faces.row(i) = bind.faces.row(kept[i]);
  return faces;
}

/// Writes one frame in all cameras.
class Filming {
 public:
  Filming(const PerformanceCommand& command, const Performer& performer,
          const std::vector<View>& views)
      : command_(command), performer_(performer), views_(views) {
    if (command.pictures) set_ = std::make_unique<FilmedSet>(views);
  }

  void WritePlates() const {
    if (!set_) return;
    for (int v = 0; v < command_.cameras; ++v)
      WriteImage(command_.output / "shot" / "background" / (views_[v].name + ".jpg"),
                 set_->Plate(v), command_.jpeg_quality);
  }

  void Write(int frame) const {
    const PointsX3 points = performer_.Points(frame);
    const FacesX3& faces = performer_.bind().faces;
    const bool hides = frame >= command_.hidden_from && frame < command_.hidden_to;
    const FacesX3 shown =
        hides ? WithoutLeftArm(performer_.bind(), performer_, frame, points) : faces;
    std::unique_ptr<FilmedFrame> filmed;
    if (set_) filmed = std::make_unique<FilmedFrame>(*set_, performer_.bind(), points);
    const std::string number = fmt::format("{:03}", frame);
    for (int v = 0; v < SizeOf(views_); ++v) {
      const bool held_out = v >= command_.cameras;
      const std::string& name = views_[v].name;
      const Image8 mask = FillMask(points, shown, views_[v]);
      WriteMaskPng(command_.output / "truth" / "masks" / name / (number + ".png"), mask);
      const std::uint64_t seed = Hash(command_.performer.seed * 1000003 + 1009 * frame + v);
      if (!held_out)
        WriteMaskPng(command_.output / "shot" / "masks" / name / (number + ".png"),
                     NoisyMask(mask, command_.noise_px, seed));
      const fs::path folder = held_out ? "held_out" : "shot";
      if (filmed)
        WriteImage(command_.output / folder / name / (number + ".jpg"), filmed->Picture(v, seed),
                   command_.jpeg_quality);
    }
  }

 private:
  const PerformanceCommand& command_;
  const Performer& performer_;
  const std::vector<View>& views_;
  std::unique_ptr<FilmedSet> set_;
};

void MakeFilmFolders(const PerformanceCommand& command, const std::vector<View>& views) {
  for (int v = 0; v < SizeOf(views); ++v) {
    const bool held_out = v >= command.cameras;
    MakeFilmFolder(command.output / "truth" / "masks" / views[v].name);
    if (!held_out) MakeFilmFolder(command.output / "shot" / "masks" / views[v].name);
    if (command.pictures)
      MakeFilmFolder(command.output / (held_out ? "held_out" : "shot") / views[v].name);
  }
  if (command.pictures) MakeFilmFolder(command.output / "shot" / "background");
  MakeFilmFolder(command.output / "held_out");
}

/// The actor's mesh in each frame, as stages exchange it: the filmed surface, more coarsely.
void WriteTrueFrames(const PerformanceCommand& command, const MotionClip& clip,
                     const Performer& filmed) {
  const fs::path folder = command.output / "truth" / "frames";
  MakeFilmFolder(folder);
  PerformerOptions options = command.performer;
  options.spacing_m = command.mesh_spacing_m;
  Performer performer(clip, options);
  performer.PlaceAs(filmed);
  PlyFrames writer(performer.bind());
  for (int f = 0; f < performer.frame_count(); ++f)
    writer.Write(folder / FrameFileName(f), performer.Points(f));
  const std::vector<FrameMeasures> measures(static_cast<std::size_t>(performer.frame_count()));
  WriteFile(folder / "distortion.json", FrameNotesText(measures, 1 / clip.frame_time_s, "truth"));
}

}  // namespace

std::vector<std::string> PerformanceCommand::Problems() const {
  std::vector<std::string> problems;
  if (frames < 1) problems.push_back("--frames must be at least 1");
  if (every < 1 || first_frame < 0)
    problems.push_back("--every must be at least 1, --first at least 0");
  if (cameras < 2 || cameras > 64) problems.push_back("--cameras must be from 2 to 64");
  if (size_px < 100 || size_px > 8000) problems.push_back("--size must be from 100 to 8000");
  if (mesh_spacing_m != 0 && !(mesh_spacing_m >= 0.005 && mesh_spacing_m <= 0.2))
    problems.push_back("--meshes must be from 0.005 to 0.2");
  if (noise_px < 0 || noise_px > 20) problems.push_back("--noise must be from 0 to 20");
  return problems;
}

std::vector<View> PerformanceCameras(int cameras, int size_px, double reach_m) {
  std::vector<View> views;
  const Eigen::Vector3d target(0, 0, 0.95);
  for (int i = 0; i <= cameras; ++i) {
    const bool held_out = i == cameras;
    View view;
    view.name = "cam" + std::to_string(i + 1);
    // The held-out camera looks from between two others.
    const double azimuth = 2 * kPi * (held_out ? 0.5 : i) / cameras + 0.2;
    const double distance = 4.2 + reach_m + 0.2 * std::sin(2.1 * i),
                 height = held_out ? 1.5 : 1.2 + 0.9 * (i % 3);
    const Eigen::Vector3d eye(distance * std::cos(azimuth), distance * std::sin(azimuth), height);
    view.camera_from_world = LookAt(eye, target);
    Camera& c = view.camera;
    c.width = c.height = size_px;
    // The actor fills the picture wherever on the path it is nearest to the camera.
    const double half = std::max(reach_m + 0.35, 1.15) / (distance - 0.5 * reach_m);
    c.fx = c.fy = 0.5 * size_px / half;
    c.cx = 0.5 * size_px + 3.3;
    c.cy = 0.5 * size_px - 2.7;
    c.k1 = -0.03;
    c.k2 = 0.008;
    views.push_back(view);
  }
  return views;
}

std::string RunPerformance(const PerformanceCommand& command, Progress* progress) {
  const std::vector<std::string> problems = command.Problems();
  if (!problems.empty()) throw UsageError("synth: " + problems.front());
  const MotionClip clip = ClipFor(command);
  const Performer performer(clip, command.performer);
  const std::vector<View> views =
      PerformanceCameras(command.cameras, command.size_px, ReachOf(performer));
  MakeFilmFolders(command, views);
  const std::vector<View> shot(views.begin(), views.end() - 1),
      held_out(views.end() - 1, views.end());
  WriteFile(command.output / "calibration.yml", OpenCvYaml(shot));
  WriteFile(command.output / "held_out" / "calibration.yml", OpenCvYaml(held_out));
  WriteFile(command.output / "truth" / "joints.csv", JointsCsv(performer));
  WriteBvh(command.output / "truth" / "motion.bvh", performer.clip());
  if (command.mesh_spacing_m > 0) WriteTrueFrames(command, clip, performer);
  const Filming writer(command, performer, views);
  writer.WritePlates();
  constexpr int kAtOnce = 16;
  for (int f = 0; f < command.frames; f += kAtOnce) {
    if (progress && progress->cancelled()) throw Cancelled();
    ReportProgress(progress, static_cast<double>(f) / command.frames, "filming");
    const int end = std::min(f + kAtOnce, command.frames);
    ParallelFor(end - f, [&](std::int64_t i) { writer.Write(f + static_cast<int>(i)); });
  }
  ReportProgress(progress, 1, "done");
  return fmt::format("{} frames of {} cameras in {}", command.frames, command.cameras,
                     (command.output / "shot").string());
}

}  // namespace keypose::synth
