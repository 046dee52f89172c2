// keypose-calibrate: lenses and places of fixed cameras, from films of a board that is moved about,
// from pictures of a board for each lens, and from points of known place.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "capture/board/board_choice.h"
#include "capture/board/board_survey.h"
#include "capture/calibrate_options.h"
#include "capture/rig/point_placement.h"
#include "capture/rig/rig_calibrator.h"
#include "core/io/project/known_points_io.h"
#include "core/io/project/rig_calibration.h"
#include "core/io/text/files.h"
#include "core/numbers/parallel.h"
#include "core/stage/stage.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "views/shot/shot.h"
#include "views/shot/view_for_pictures.h"

namespace keypose::capture {
namespace {

constexpr double kLeastCoverage = 0.4, kMostRms = 1.0;
constexpr double kMostApart_m = 0.02;  // of a point's place, from where the cameras see it
constexpr double kMostFocalError = 0.02;
constexpr int kReportEvery = 10;   // batches of frames
constexpr int kSurveyed = 24;      // frames of a camera that tell which board it is
constexpr int kLensPictures = 60;  // of a camera

StageSpec Spec() {
  StageSpec spec;
  spec.name = "calibrate";
  spec.version = "7";
  spec.summary =
      "Lenses and places of fixed cameras, from films of a calibration board or from points of "
      "known place.";
  spec.title = "Cameras of the films";
  spec.inputs = {
      {"video", "folder",
       "films of a moved board: one folder of numbered pictures, or one video, "
       "for each camera",
       "", true, false},
      {"lenses", "path",
       "pictures of a board for each camera, which need not be taken together; or a calibration "
       "whose lenses are taken",
       "", true, false},
      {"points", "file", "points.json: points of known place, clicked in each camera's picture", "",
       true, false}};
  spec.outputs = {{"calibration", "file", "the cameras (OpenCV YAML, metres, z up)",
                   "calibration.yml", false, false}};
  spec.memory_gib = 1;
  spec.common = {"board", "board_square_mm", "floor_frame"};
  return spec;
}

std::string Fixed(double x, int digits) { return fmt::format("{:.{}f}", x, digits); }
/// Looks for the board in the films of all cameras, and tells the user while it does what is still
/// missing.
class BoardFinder {
 public:
  /// @param share  of the stage's progress
  BoardFinder(StageContext& stage, std::vector<ShotCamera> films, double share)
      : stage_(stage), share_(share), films_(std::move(films)) {
    for (const ShotCamera& camera : films_) {
      if (camera.pictures.empty())
        throw InputError("calibrate: camera " + camera.name + " has no pictures");
      readers_.emplace_back(camera.pictures);
      most_frames_ = std::max(most_frames_, camera.frames());
      cameras_.push_back({camera.name, 0, 0});
    }
  }

  /// Every so many frames of films that run together, and one of them at any rate.
  void LookTogether(const CalibrateOptions& options) {
    std::vector<int> frames;
    for (int f = 0; f < most_frames_; f += options.every) frames.push_back(f);
    if (options.floor_frame < most_frames_ && options.floor_frame % options.every != 0)
      frames.insert(std::upper_bound(frames.begin(), frames.end(), options.floor_frame),
                    options.floor_frame);
    Look(options, std::vector<std::vector<int>>(films_.size(), frames));
  }
  /// Pictures spread over each camera's.
  void LookSeparately(const CalibrateOptions& options) {
    std::vector<std::vector<int>> frames;
    for (const ShotCamera& camera : films_) frames.push_back(Spread(camera.frames()));
    Look(options, frames);
  }

  const std::vector<RigCamera>& cameras() const { return cameras_; }
  const std::vector<BoardSighting>& sightings() const { return sightings_; }
  const BoardPattern& pattern() const { return pattern_; }
  /// For the end of a message about a board that was not seen.
  const std::string& seen() const { return seen_; }

 private:
  static std::vector<int> Spread(int count) {
    std::vector<int> frames;
    const int some = std::min(count, kLensPictures);
    for (int i = 0; i < some; ++i)
      frames.push_back(static_cast<int>(static_cast<std::int64_t>(i) * count / some));
    return frames;
  }
  void Look(const CalibrateOptions& options, const std::vector<std::vector<int>>& frames) {
    Survey(options, frames);
    std::size_t rounds = 0;
    for (const std::vector<int>& own : frames) rounds = std::max(rounds, own.size());
    for (std::size_t i = 0; i < rounds; ++i) {
      if (stage_.progress() && stage_.progress()->cancelled()) throw Cancelled();
      std::vector<BoardSighting> found(films_.size());
      ParallelFor(SizeOf(films_), [&](std::int64_t c) {
        if (i < frames[c].size()) found[c] = LookAt(static_cast<int>(c), frames[c][i]);
      });
      for (BoardSighting& s : found)
        if (!s.corners.empty()) sightings_.push_back(std::move(s));
      ReportProgress(stage_.progress(), share_ * static_cast<double>(i + 1) / rounds,
                     "looking for the board");
      if ((i + 1) % kReportEvery == 0) Roll(frames[0][std::min(i, frames[0].size() - 1)]);
    }
    Roll(frames[0].back());
  }
  /// Which board it is, by frames spread over all cameras.
  void Survey(const CalibrateOptions& options, const std::vector<std::vector<int>>& frames) {
    BoardSurvey survey(options.Wish());
    int pictures = 0;
    for (int i = 0; i < kSurveyed && !survey.sure(); ++i)
      for (int c = 0; c < SizeOf(films_) && !survey.sure(); ++c) {
        if (stage_.progress() && stage_.progress()->cancelled()) throw Cancelled();
        const int some = std::min(kSurveyed, SizeOf(frames[c]));
        if (i >= some) continue;
        const int frame = frames[c][static_cast<std::size_t>(i) * frames[c].size() / some];
        if (frame >= films_[c].frames()) continue;
        survey.Add(Read(c, frame));
        ++pictures;
      }
    if (const std::optional<BoardPattern> pattern = survey.Pattern()) {
      pattern_ = *pattern;
      if (const std::optional<SaidBoard> said = options.Said())
        pattern_ = SeenAsSaid(*pattern, *said, options.board_square_mm / 1000);
      seen_ = "; the pictures show " + pattern_.Name();
      stage_.Note("the pictures show " + pattern_.Name());
      SayAssumptions(options);
      return;
    }
    pattern_ = PatternOf(options.Said().value_or(SaidBoard{}), options.board_square_mm / 1000);
    const std::string what = survey.Seen();
    seen_ = fmt::format("; of {} pictures that were read with every dictionary, {}", pictures,
                        what.empty() ? "none showed markers or a checkerboard"
                                     : "some show " + what + ", but no board that can be laid out");
    stage_.Note(seen_.substr(2));
  }
  void SayAssumptions(const CalibrateOptions& options) {
    const BoardLayout own;
    const bool is_own = IsOwnPrint(pattern_, own) && pattern_.layout.rows == own.rows &&
                        HasOwnMarkers(pattern_.layout);
    if (!is_own && !options.SaysSide())
      stage_.Warn(
          "the board is not the one that `keypose capture` prints, and its squares are taken for " +
          Fixed(options.board_square_mm, 1) +
          " mm: measure one and give board_square_mm, or all lengths are wrong by one factor");
    if (pattern_.mirrored)
      stage_.Warn(
          "some pictures show the board in a mirror: its back, if that is printed too; otherwise a "
          "camera mirrors its pictures, and must be told not to");
  }
  Image8 Read(int camera, int frame) {
    Image8 picture = readers_[camera].Read(frame, 3);
    RigCamera& known = cameras_[camera];
    if (known.width != 0 && (known.width != picture.width || known.height != picture.height))
      throw InputError("calibrate: camera " + known.name + " changes its picture's size in frame " +
                       std::to_string(frame));
    known.width = picture.width;
    known.height = picture.height;
    return picture;
  }
  BoardSighting LookAt(int camera, int frame) {
    BoardSighting sighting{camera, frame, {}, false};
    if (frame >= films_[camera].frames()) return sighting;
    FoundBoard found = LookForBoard(Read(camera, frame), pattern_);
    sighting.corners = std::move(found.corners);
    sighting.partial = found.partial;
    return sighting;
  }
  void Roll(int frame) {
    std::string text = "frame " + std::to_string(frame) + ":";
    for (int c = 0; c < SizeOf(cameras_); ++c) {
      const auto boards = std::count_if(sightings_.begin(), sightings_.end(),
                                        [&](const BoardSighting& s) { return s.camera == c; });
      text += " " + films_[c].name + " " + std::to_string(boards) + " boards, " +
              Fixed(100 * CornerCoverage(sightings_, c, cameras_[c]), 0) + " % of the picture;";
    }
    stage_.Note(text);
  }

  StageContext& stage_;
  double share_;
  std::vector<ShotCamera> films_;
  std::vector<FrameReader> readers_;
  std::vector<RigCamera> cameras_;
  std::vector<BoardSighting> sightings_;
  BoardPattern pattern_;
  std::string seen_;
  int most_frames_ = 0;
};

void WarnOfCoverage(StageContext& stage, const std::string& name, double coverage) {
  if (coverage < kLeastCoverage)
    stage.Warn("camera " + name + " saw the board in " + Fixed(100 * coverage, 0) +
               " % of its picture: its lens is a guess elsewhere; move the board into its corners");
}

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
    stage.Note(
        fmt::format("{}: {:.2f} px over {} corners of {} boards, {:.0f} % of the picture, {} "
                    "boards shared with other cameras",
                    name, r.rms_px, r.corners, r.boards, 100 * r.coverage, r.shared));
    WarnOfCoverage(stage, name, r.coverage);
    if (r.rms_px > kMostRms)
      stage.Warn(
          fmt::format("camera {} misses the corners by {:.1f} px: the board was bent, moved "
                      "fast, or the films do not begin together",
                      name, r.rms_px));
  }
  stage.ReportJson("cameras", rows.dump());
  stage.Report("rms_px", result.rms_px);
}

/// Runs what needs boards; a board that was not seen is told with what was seen instead.
template <class Result>
Result WithSeen(const BoardFinder& finder, const std::function<Result()>& calibrate) {
  try {
    return calibrate();
  } catch (const InputError& error) {
    throw InputError(error.what() + finder.seen());
  }
}

std::vector<View> LensesOfPictures(StageContext& stage, const CalibrateOptions& options) {
  BoardFinder finder(stage, OpenSeparateFilms(stage.Input("lenses")),
                     stage.Has("video") ? 0.4 : 0.8);
  finder.LookSeparately(options);
  std::vector<View> lenses;
  nlohmann::ordered_json rows = nlohmann::json::array();
  for (int c = 0; c < SizeOf(finder.cameras()); ++c) {
    const RigCamera& camera = finder.cameras()[c];
    const CalibratedLens lens = WithSeen<CalibratedLens>(finder, [&] {
      return CalibrateLens(finder.sightings(), c, camera, finder.pattern().layout, kLensPictures);
    });
    rows.push_back({{"camera", camera.name},
                    {"rms_px", lens.rms_px},
                    {"worst_px", lens.worst_px},
                    {"boards", lens.boards},
                    {"left_out", lens.left_out},
                    {"corners", lens.corners},
                    {"coverage", lens.coverage}});
    stage.Note(
        fmt::format("lens of {}: {:.2f} px over {} corners of {} boards{}, {:.0f} % of the "
                    "picture, focal length {:.1f} px",
                    camera.name, lens.rms_px, lens.corners, lens.boards,
                    lens.left_out ? fmt::format(" ({} left out)", lens.left_out) : "",
                    100 * lens.coverage, lens.camera.fx));
    WarnOfCoverage(stage, camera.name, lens.coverage);
    if (lens.rms_px > kMostRms)
      stage.Warn(
          fmt::format("the lens of {} misses the corners by {:.1f} px: the board was bent or "
                      "moved fast",
                      camera.name, lens.rms_px));
    View view;
    view.name = camera.name;
    view.camera = lens.camera;
    lenses.push_back(view);
  }
  stage.ReportJson("lenses", rows.dump());
  return lenses;
}

/// Lenses that are known before cameras are placed; none: nothing was given.
std::vector<View> Lenses(StageContext& stage, const CalibrateOptions& options) {
  if (!stage.Has("lenses")) return {};
  const std::filesystem::path path = stage.Input("lenses");
  bool pictures = std::filesystem::is_directory(path);
  if (pictures)
    for (const auto& entry : std::filesystem::directory_iterator(path))
      if (entry.path().extension() == ".yml" || entry.path().extension() == ".yaml")
        pictures = false;
  if (pictures) return LensesOfPictures(stage, options);
  const RigCalibration known = ReadLensCalibration(path);
  for (const std::string& note : known.notes) stage.Note(note);
  return known.views;
}

/// The lens of each camera, for pictures of its size.
std::vector<Camera> LensesFor(StageContext& stage, const std::vector<View>& lenses,
                              const std::vector<RigCamera>& cameras) {
  std::vector<std::string> names;
  for (const RigCamera& camera : cameras) names.push_back(camera.name);
  const std::vector<int> match = MatchCameraNames(names, lenses);
  std::vector<Camera> fitting;
  for (int c = 0; c < SizeOf(cameras); ++c) {
    if (match[c] < 0)
      throw InputError("calibrate: there is no lens for camera " + names[c] +
                       " in --lenses; give it pictures of the board too, by the same name");
    View lens = lenses[match[c]];
    lens.name = names[c];
    const AdjustedView view =
        ViewForPictures(lens, Image8(cameras[c].width, cameras[c].height, 1), {}, "calibrate");
    if (!view.note.empty()) stage.Note(view.note);
    fitting.push_back(view.view.camera);
  }
  return fitting;
}

void ReportPlaced(StageContext& stage, const KnownPoints& known, const PlacedCamera& placed,
                  nlohmann::ordered_json* rows) {
  nlohmann::ordered_json clicks = nlohmann::json::array();
  std::string errors;
  const std::string& name = placed.view.name;
  for (const ClickError& click : placed.clicks) {
    const std::string& point = known.points[click.point].name;
    clicks.push_back({{"point", point},
                      {"error_px", click.px},
                      {"wrong", click.wrong},
                      {"expected", {click.expected.x(), click.expected.y()}}});
    errors += fmt::format("{} {} {:.1f}", errors.empty() ? "" : ",", point, click.px);
    if (click.wrong)
      stage.Warn(
          fmt::format("camera {}: the click of '{}' is {:.0f} px from where the others "
                      "expect it, at ({:.0f}, {:.0f}), and was left out: click it again, or "
                      "measure the point again",
                      name, point, click.px, click.expected.x(), click.expected.y()));
  }
  rows->push_back({{"camera", name},
                   {"rms_px", placed.rms_px},
                   {"place_error_mm", 1000 * placed.place_error_m},
                   {"focal_error", placed.focal_error},
                   {"clicks", clicks}});
  stage.Note(fmt::format("{}: {:.1f} px over its clicks, place to about {:.0f} mm;{} px", name,
                         placed.rms_px, 1000 * placed.place_error_m, errors));
  if (placed.focal_error > kMostFocalError)
    stage.Warn(
        fmt::format("camera {}: its clicks tell the focal length to {:.0f} % only; give "
                    "pictures of a board (--lenses)",
                    name, 100 * placed.focal_error));
}

void ReportPoints(StageContext& stage, const KnownPoints& known,
                  const std::vector<PlacedCamera>& placed) {
  nlohmann::ordered_json rows = nlohmann::json::array();
  for (const SeenPoint& seen : SeePoints(known.cameras, placed, known.points)) {
    const std::string& name = known.points[seen.point].name;
    rows.push_back({{"point", name},
                    {"apart_mm", 1000 * seen.apart_m},
                    {"seen", {seen.seen.x(), seen.seen.y(), seen.seen.z()}},
                    {"cameras", seen.cameras}});
    const std::string text = fmt::format(
        "point '{}' is seen {:.0f} mm from its place by {} cameras, at ({:.3f}, {:.3f}, {:.3f})",
        name, 1000 * seen.apart_m, seen.cameras, seen.seen.x(), seen.seen.y(), seen.seen.z());
    if (seen.apart_m > kMostApart_m)
      stage.Warn(text + ": measure it again, or look at its clicks");
    else
      stage.Note(text);
  }
  stage.ReportJson("points", rows.dump());
}

std::vector<View> PlacedByPoints(StageContext& stage, const std::vector<View>& lenses) {
  const KnownPoints known = ReadKnownPoints(stage.Input("points"));
  std::vector<RigCamera> sizes;
  for (const ClickedPicture& camera : known.cameras)
    sizes.push_back({camera.camera, camera.width, camera.height});
  const std::vector<Camera> fitting =
      lenses.empty() ? std::vector<Camera>{} : LensesFor(stage, lenses, sizes);
  std::vector<PlacedCamera> placed;
  nlohmann::ordered_json rows = nlohmann::json::array();
  for (int c = 0; c < SizeOf(known.cameras); ++c) {
    placed.push_back(PlaceCamera(
        known.cameras[c], fitting.empty() ? std::optional<Camera>{} : fitting[c], known.points));
    ReportPlaced(stage, known, placed.back(), &rows);
  }
  stage.ReportJson("cameras", rows.dump());
  ReportPoints(stage, known, placed);
  std::vector<View> views;
  for (const PlacedCamera& camera : placed) views.push_back(camera.view);
  return views;
}

/// The frame whose board becomes the floor: the one that was said, or, where nobody said one and
/// the first frame shows no board, the first that does.
int FloorFrame(StageContext& stage, const CalibrateOptions& options, const BoardFinder& finder,
               int least_corners) {
  int first = -1;
  for (const BoardSighting& s : finder.sightings()) {
    if (s.partial || SizeOf(s.corners) < least_corners) continue;
    if (s.frame == options.floor_frame) return s.frame;
    if (first < 0 || s.frame < first) first = s.frame;
  }
  if (first < 0 || options.floor_frame != 0) return options.floor_frame;
  stage.Warn(
      "no camera saw the board in frame 0: the world is that of the board in frame " +
      std::to_string(first) +
      ", whose z points up only if it lay on the floor then; give floor_frame, or tell later "
      "steps what is up");
  return first;
}

std::vector<View> PlacedByBoard(StageContext& stage, const CalibrateOptions& options,
                                const std::vector<View>& lenses) {
  const Shot shot = OpenShot(stage.Input("video"), FilmGaps::kLeftOut,
                             ParseClockWish(options.clock_offsets), stage.progress());
  for (const std::string& note : shot.join.notes) stage.Note(note);
  if (shot.join.frames_per_second > 0) stage.Report("film_mismatch_ms", 1000 * shot.join.worst_s);
  BoardFinder finder(stage, shot.cameras, 0.8);
  finder.LookTogether(options);
  RigCalibratorOptions rig;
  rig.floor_frame = FloorFrame(stage, options, finder, rig.least_corners);
  rig.turns = finder.pattern().Turns();
  if (!lenses.empty()) rig.lenses = LensesFor(stage, lenses, finder.cameras());
  SubProgress solving(stage.progress(), 0.8, 1);
  const RigResult result = WithSeen<RigResult>(finder, [&] {
    return CalibrateRig(finder.sightings(), finder.cameras(), finder.pattern().layout, rig,
                        &solving);
  });
  ReportRig(stage, result);
  return result.views;
}

void Run(StageContext& stage, const CalibrateOptions& options) {
  if (!stage.Has("video") && !stage.Has("lenses") && !stage.Has("points"))
    throw UsageError(
        "calibrate: give films of a moved board (--video), pictures of a board for each lens "
        "(--lenses), points of known place (--points), or lenses and one of the others");
  if (stage.Has("video") && stage.Has("points"))
    throw UsageError(
        "calibrate: --video and --points both place the cameras; give one of them, and pictures of "
        "the board for the lenses as --lenses");
  const std::vector<View> lenses = Lenses(stage, options);
  if (stage.Has("video"))
    WriteFile(stage.Output("calibration"), OpenCvYaml(PlacedByBoard(stage, options, lenses)));
  else if (stage.Has("points"))
    WriteFile(stage.Output("calibration"), OpenCvYaml(PlacedByPoints(stage, lenses)));
  else
    WriteFile(stage.Output("calibration"), OpenCvLensYaml(lenses));
}

}  // namespace
}  // namespace keypose::capture

int main(int argc, char** argv) {
  return keypose::RunStage<keypose::capture::CalibrateOptions>(argc, argv, keypose::capture::Spec(),
                                                               keypose::capture::Run);
}
