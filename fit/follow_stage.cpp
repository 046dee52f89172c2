// keypose-follow: bends a moving mesh, frame by frame, until it agrees with the films.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/frame_folder.h"
#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/numbers/parallel.h"
#include "core/pictures/render.h"
#include "core/stage/stage.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "fit/follow_input.h"
#include "fit/follow_options.h"
#include "fit/following/follow.h"
#include "fit/outline_picture.h"

namespace keypose::fit {
namespace {

namespace fs = std::filesystem;

constexpr double kUsualRate = 25;
constexpr int kBatch = 8;        // frames that are judged at once
constexpr double kUnseen = 0.1;  // confidence below which no view holds a vertex
constexpr double kLowOverlap = 0.75;

StageSpec Spec() {
  StageSpec spec;
  spec.name = "follow";
  spec.version = "7";
  spec.summary = "Bends a moving mesh, frame by frame, until it agrees with the films.";
  spec.title = "Surface from the films";
  spec.measurements = {{"iou_before_mean", "overlap with the masks before bending, mean", "IoU"},
                       {"iou_mean", "overlap with the masks, mean", "IoU"},
                       {"iou_least", "overlap with the masks, least", "IoU"},
                       {"flipped", "faces turned over", "", -kAnyNumber, 0}};
  spec.inputs = MovingMeshPorts();
  spec.inputs.push_back({"texture", "file",
                         "the mesh's own texture, which is then compared with the films too", "",
                         true, false});
  spec.outputs = {{"followed", "folder", "the bent frames: frame_0000.ply ..., distortion.json",
                   "followed", false, false},
                  {"confidence", "file",
                   "the first frame; grey says how surely the films hold each place (.ply)",
                   "confidence.ply", true, false},
                  {"picture", "file", "outlines before and after, over the films (.jpg)",
                   "followed.jpg", true, false}};
  spec.memory_gib = 2;
  spec.common = {"stiffness", "calm", "cameras"};
  return spec;
}

/// How a frame was before and is after.
struct FrameNote {
  bool seen = false;  // by any camera
  double iou_before = 0, iou = 0;
  double move_mean = 0, move_largest = 0;
  int flipped = 0;
  double area = 1, volume = 1;
};

struct Judged {
  std::vector<FrameNote> frames;
  double flicker_before = 0, flicker = 0;  // sums over the frames between two others
};

void NoteFrame(const Mesh& mesh, const PointsX3& base, const BentFrame& bent,
               const std::vector<PreparedView>& views, FrameNote& note) {
  note.seen = !views.empty();
  note.iou_before = MeanOverlap(base, mesh.faces, views);
  note.iou = MeanOverlap(bent.points, mesh.faces, views);
  const Eigen::VectorXd moves = (bent.points - base).rowwise().norm();
  note.move_mean = moves.mean();
  note.move_largest = moves.maxCoeff();
  note.flipped = bent.flipped;
  note.area = SurfaceArea(bent.points, mesh.faces);
  note.volume = SignedVolume(bent.points, mesh.faces);
}

/// Adds to the second differences in time; keeps the last two frames.
class FlickerSum {
 public:
  void Add(const PointsX3& points) {
    if (count_ >= 2) sum_ += Flicker(before_, now_, points);
    before_ = std::move(now_);
    now_ = points;
    ++count_;
  }
  double sum() const { return sum_; }

 private:
  PointsX3 before_, now_;
  int count_ = 0;
  double sum_ = 0;
};

/// Makes, judges and writes the frames.
Judged WriteFrames(StageContext& stage, FollowInput& input, const FollowedFrames& frames,
                   Progress* progress) {
  const fs::path folder = stage.Output("followed");
  PlyFrames writer(input.given());
  Judged judged;
  judged.frames.resize(static_cast<std::size_t>(input.frames()));
  FlickerSum before, after;
  for (int first = 0; first < input.frames(); first += kBatch) {
    ReportProgress(progress, static_cast<double>(first) / input.frames(), "writing frames");
    const int count = std::min(kBatch, input.frames() - first);
    const std::vector<std::vector<PreparedView>> views = input.MaskViews(first, count);
    std::vector<PointsX3> bases(static_cast<std::size_t>(count)), made(bases.size());
    ParallelFor(count, [&](std::int64_t i) {
      const int f = first + static_cast<int>(i);
      bases[i] = input.Points(f);
      BentFrame bent = frames.At(f);
      NoteFrame(input.mesh(), bases[i], bent, views[i], judged.frames[f]);
      made[i] = std::move(bent.points);
    });
    for (int i = 0; i < count; ++i) {
      writer.Write(folder / FrameFileName(first + i), input.Opened(made[i]));
      before.Add(bases[i]);
      after.Add(made[i]);
    }
  }
  judged.flicker_before = before.sum();
  judged.flicker = after.sum();
  return judged;
}

void WriteNotes(StageContext& stage, const Judged& judged, double fps) {
  std::vector<FrameMeasures> measures;
  const FrameNote& first = judged.frames.front();
  for (const FrameNote& note : judged.frames)
    measures.push_back({note.area / std::max(1e-300, first.area),
                        first.volume != 0 ? note.volume / first.volume : 1});
  WriteFile(stage.Output("followed") / "distortion.json", FrameNotesText(measures, fps, "follow"));
}

nlohmann::json NodesOf(const std::vector<FrameNote>& notes) {
  nlohmann::json list = nlohmann::json::array();
  for (const FrameNote& note : notes) {
    nlohmann::json entry = {{"move_mean", note.move_mean}, {"move_largest", note.move_largest}};
    if (note.seen) {
      entry["iou_before"] = note.iou_before;
      entry["iou"] = note.iou;
    }
    list.push_back(entry);
  }
  return list;
}

void ReportFrames(StageContext& stage, const Judged& judged, double diagonal) {
  double before = 0, after = 0, least = 1, move = 0, largest = 0;
  int seen = 0, worst = 0, flipped = 0;
  for (int f = 0; f < SizeOf(judged.frames); ++f) {
    const FrameNote& note = judged.frames[f];
    move += note.move_mean / SizeOf(judged.frames);
    largest = std::max(largest, note.move_largest);
    flipped += note.flipped;
    if (!note.seen) continue;
    ++seen;
    before += note.iou_before;
    after += note.iou;
    if (note.iou < least) {
      least = note.iou;
      worst = f;
    }
  }
  stage.Report("frames", SizeOf(judged.frames));
  stage.Report("iou_before_mean", before / std::max(1, seen));
  stage.Report("iou_mean", after / std::max(1, seen));
  stage.Report("iou_least", least);
  stage.Report("iou_least_frame", worst);
  stage.Report("move_mean_over_diag", move / diagonal);
  stage.Report("move_largest_over_diag", largest / diagonal);
  stage.Report("flipped", flipped);
  if (judged.flicker_before > 0)
    stage.Report("second_difference_ratio", judged.flicker / judged.flicker_before);
  stage.ReportJson("per_frame", NodesOf(judged.frames).dump());
  if (least < kLowOverlap)
    stage.Warn("in frame " + std::to_string(worst) + " the bent mesh covers only " +
               std::to_string(static_cast<int>(100 * least)) +
               " % of what the masks show: look at that frame's masks and pose");
  if (after < before)
    stage.Warn(
        "the bent frames agree less with the masks than the frames before: look at the masks and "
        "the calibration");
}

/// Mean over the frames.
Eigen::VectorXd MeanConfidence(const std::vector<Offsets>& offsets) {
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(offsets.front().sure.size());
  for (const Offsets& frame : offsets) mean += frame.sure / SizeOf(offsets);
  return mean;
}

void ReportConfidence(StageContext& stage, const FollowInput& input, const FollowedMesh& followed,
                      const std::vector<Offsets>& offsets) {
  const Eigen::VectorXd sure = MeanConfidence(offsets);
  stage.Report("confidence_mean", sure.mean());
  stage.Report("unseen", static_cast<double>((sure.array() < kUnseen).count()) /
                             static_cast<double>(sure.size()));
  const fs::path path = stage.Output("confidence");
  if (path.empty()) return;
  Mesh mesh = input.given();
  mesh.colors.resize(mesh.points.rows(), 3);
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v)
    mesh.colors.row(v).setConstant(static_cast<std::uint8_t>(
        std::lround(255 * std::clamp(sure[followed.cell_of()[input.of_given()[v]]], 0.0, 1.0))));
  WriteMesh(path, mesh);
}

/// Outlines before and after, in some frames of some cameras.
void WritePicture(StageContext& stage, FollowInput& input, const FollowedFrames& frames) {
  const fs::path path = stage.Output("picture");
  if (path.empty()) return;
  constexpr int kMoments = 3, kHeight = 600;
  const int moments = std::min(kMoments, input.frames());
  std::vector<Image8> tiles;
  for (int m = 0; m < moments; ++m) {
    const int f = static_cast<int>((m + 0.5) * input.frames() / moments);
    const std::vector<PreparedView> views = input.Views(f, 1)[0];
    if (views.empty()) continue;
    const PreparedView& view = views[m * views.size() / moments];
    Mesh shown = input.mesh();
    for (const PointsX3& points : {input.Points(f), frames.At(f).points}) {
      shown.points = points;
      const Image8 picture = OutlinePicture(shown, {{view, {}}}, {view.camera_from_world}, {});
      tiles.push_back(
          Resized(picture, std::max(1, kHeight * picture.width / picture.height), kHeight));
    }
  }
  if (!tiles.empty()) WriteImage(path, TileImages(tiles, 2), 88);
}

void Run(StageContext& stage, const FollowStageOptions& options) {
  FollowInput input(stage, {options.cameras, options.max_size});
  const FollowedMesh followed(input.mesh().points, input.mesh().faces, options.vertices);
  const FollowSource source = input.Source();
  std::optional<SurfaceTexture> texture;
  if (!input.texture().empty()) texture.emplace(input.mesh(), input.texture());
  SubProgress bending(stage.progress(), 0, 0.9), writing(stage.progress(), 0.9, 1);
  const FollowOptions how{{options.stiffness, options.grey}, options.calm};
  const std::vector<Offsets> offsets =
      FollowFilms(followed, source, texture ? &*texture : nullptr, how, &bending);
  const FollowedFrames frames(followed, source, offsets, options.volume);
  const double fps = input.frames_per_second() > 0 ? input.frames_per_second() : kUsualRate;
  const Judged judged = WriteFrames(stage, input, frames, &writing);
  WriteNotes(stage, judged, fps);
  ReportFrames(stage, judged, BoundingDiagonal(input.mesh().points));
  stage.Report("volume_ratio", frames.volume_ratio());
  ReportConfidence(stage, input, followed, offsets);
  WritePicture(stage, input, frames);
}

}  // namespace
}  // namespace keypose::fit

int main(int argc, char** argv) {
  return keypose::RunStage<keypose::fit::FollowStageOptions>(argc, argv, keypose::fit::Spec(),
                                                             keypose::fit::Run);
}
