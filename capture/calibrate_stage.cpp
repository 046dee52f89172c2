// keypose-calibrate: lenses and places of fixed cameras, from films of a board that is moved about.
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "capture/board/board_detection.h"
#include "capture/rig/rig_calibrator.h"
#include "core/errors.h"
#include "core/io/files.h"
#include "core/io/rig_calibration.h"
#include "core/parallel.h"
#include "core/size_of.h"
#include "core/stage/stage.h"
#include "views/shot/shot.h"

namespace keypose::capture {
namespace {

constexpr double kLeastCoverage = 0.4, kMostRms = 1.0;
constexpr int kReportEvery = 10;  // batches of frames

struct CalibrateOptions {
  int board_columns = BoardLayout{}.columns, board_rows = BoardLayout{}.rows;
  double board_square_mm = 1000 * BoardLayout{}.square_m;
  int every = 5;
  int floor_frame = 0;

  BoardLayout Board() const {
    const double square_m = board_square_mm / 1000;
    return {board_columns, board_rows, square_m, BoardLayout::kMarkerShare * square_m};
  }
  void Describe(OptionVisitor& visit) {
    visit("board_columns", board_columns,
          {"squares along the board's longer side", "", 3, 100, {}});
    visit("board_rows", board_rows, {"squares along its shorter side", "", 3, 100, {}});
    visit("board_square_mm", board_square_mm,
          {"side of a square, as measured on the print", "mm", 2, 500, {}});
    visit("every", every, {"only every so many frames are looked at", "frames", 1, 1000, {}});
    visit("floor_frame", floor_frame,
          {"the frame in which the board lies on the floor: it becomes z = 0 and the origin",
           "",
           0,
           1e6,
           {}});
  }
  std::vector<std::string> Problems() const { return Board().Problems(); }
};

StageSpec Spec() {
  StageSpec spec;
  spec.name = "calibrate";
  spec.version = "1";
  spec.summary = "Lenses and places of fixed cameras, from films of a calibration board.";
  spec.inputs = {{"video", "folder",
                  "one folder of numbered pictures, or one video, for each camera", "", false,
                  false}};
  spec.outputs = {{"calibration", "file", "the cameras (OpenCV YAML, metres, z up)",
                   "calibration.yml", false, false}};
  spec.memory_gib = 1;
  spec.common = {"board_columns", "board_rows", "board_square_mm", "floor_frame"};
  return spec;
}

std::string Fixed(double x, int digits) {
  char text[32];
  std::snprintf(text, sizeof text, "%.*f", digits, x);
  return text;
}

/// Looks for the board in all films, and tells the user while it does what is still missing.
class BoardFinder {
 public:
  BoardFinder(StageContext& stage, const CalibrateOptions& options)
      : stage_(stage), options_(options), shot_(OpenShot(stage.Input("video"))) {
    for (const ShotCamera& camera : shot_.cameras) {
      if (camera.pictures.empty())
        throw InputError("calibrate: camera " + camera.name + " has no pictures");
      readers_.emplace_back(camera.pictures);
      frames_ = std::max(frames_, camera.frames());
    }
    cameras_.resize(shot_.cameras.size());
  }

  void Find() {
    const std::vector<int> frames = Chosen();
    for (int i = 0; i < SizeOf(frames); ++i) {
      if (stage_.progress() && stage_.progress()->cancelled()) throw Cancelled();
      std::vector<BoardSighting> found(cameras_.size());
      ParallelFor(SizeOf(cameras_),
                  [&](std::int64_t c) { found[c] = Look(static_cast<int>(c), frames[i]); });
      for (BoardSighting& s : found)
        if (!s.corners.empty()) sightings_.push_back(std::move(s));
      ReportProgress(stage_.progress(), 0.8 * (i + 1) / SizeOf(frames), "looking for the board");
      if ((i + 1) % kReportEvery == 0) Roll(frames[i]);
    }
    Roll(frames.back());
  }

  const std::vector<RigCamera>& cameras() const { return cameras_; }
  const std::vector<BoardSighting>& sightings() const { return sightings_; }

 private:
  /// The floor's frame, and every so many others.
  std::vector<int> Chosen() const {
    std::vector<int> frames;
    for (int f = 0; f < frames_; f += options_.every) frames.push_back(f);
    if (options_.floor_frame < frames_ && options_.floor_frame % options_.every != 0)
      frames.insert(std::upper_bound(frames.begin(), frames.end(), options_.floor_frame),
                    options_.floor_frame);
    return frames;
  }
  BoardSighting Look(int camera, int frame) {
    BoardSighting sighting{camera, frame, {}};
    if (frame >= shot_.cameras[camera].frames()) return sighting;
    const Image8 picture = readers_[camera].Read(frame, 3);
    RigCamera& known = cameras_[camera];
    if (known.width != 0 && (known.width != picture.width || known.height != picture.height))
      throw InputError("calibrate: camera " + known.name + " changes its picture's size in frame " +
                       std::to_string(frame));
    known = {shot_.cameras[camera].name, picture.width, picture.height};
    sighting.corners = FindBoard(picture, options_.Board());
    return sighting;
  }
  void Roll(int frame) {
    std::string text = "frame " + std::to_string(frame) + ":";
    for (int c = 0; c < SizeOf(cameras_); ++c) {
      const auto boards = std::count_if(sightings_.begin(), sightings_.end(),
                                        [&](const BoardSighting& s) { return s.camera == c; });
      text += " " + shot_.cameras[c].name + " " + std::to_string(boards) + " boards, " +
              Fixed(100 * CornerCoverage(sightings_, c, cameras_[c]), 0) + " % of the picture;";
    }
    stage_.Note(text);
  }

  StageContext& stage_;
  const CalibrateOptions& options_;
  Shot shot_;
  std::vector<FrameReader> readers_;
  std::vector<RigCamera> cameras_;
  std::vector<BoardSighting> sightings_;
  int frames_ = 0;
};

void ReportRig(StageContext& stage, const RigResult& result) {
  nlohmann::ordered_json rows = nlohmann::json::array();
  for (std::size_t c = 0; c < result.cameras.size(); ++c) {
    const RigCameraReport& r = result.cameras[c];
    const std::string& name = result.views[c].name;
    rows.push_back({{"camera", name},
                    {"rms_px", r.rms_px},
                    {"worst_px", r.worst_px},
                    {"boards", r.boards},
                    {"corners", r.corners},
                    {"coverage", r.coverage},
                    {"shared", r.shared}});
    stage.Note(name + ": " + Fixed(r.rms_px, 2) + " px over " + std::to_string(r.corners) +
               " corners of " + std::to_string(r.boards) + " boards, " +
               Fixed(100 * r.coverage, 0) + " % of the picture, " + std::to_string(r.shared) +
               " boards shared with other cameras");
    if (r.coverage < kLeastCoverage)
      stage.Warn(
          "camera " + name + " saw the board in " + Fixed(100 * r.coverage, 0) +
          " % of its picture: its lens is a guess elsewhere; move the board into its corners");
    if (r.rms_px > kMostRms)
      stage.Warn("camera " + name + " misses the corners by " + Fixed(r.rms_px, 1) +
                 " px: the board was bent, moved fast, or the films do not begin together");
  }
  stage.ReportJson("cameras", rows.dump());
  stage.Report("rms_px", result.rms_px);
}

void Run(StageContext& stage, const CalibrateOptions& options) {
  BoardFinder finder(stage, options);
  finder.Find();
  RigCalibratorOptions rig;
  rig.floor_frame = options.floor_frame;
  SubProgress solving(stage.progress(), 0.8, 1);
  const RigResult result =
      CalibrateRig(finder.sightings(), finder.cameras(), options.Board(), rig, &solving);
  ReportRig(stage, result);
  WriteFile(stage.Output("calibration"), OpenCvYaml(result.views));
}

}  // namespace
}  // namespace keypose::capture

int main(int argc, char** argv) {
  return keypose::RunStage<keypose::capture::CalibrateOptions>(argc, argv, keypose::capture::Spec(),
                                                               keypose::capture::Run);
}
