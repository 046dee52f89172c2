#include "studio/project/page_shot.h"

#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "core/io/pictures/image_io.h"
#include "core/io/project/shot_io.h"
#include "core/values/errors.h"
#include "pipeline/disk/real_disk.h"
#include "studio/project/changes.h"
#include "studio/project/pose_photographs.h"
#include "studio/project/shot_clicks.h"
#include "studio/project/shot_files.h"
#include "studio/project/shot_setup.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;
using pipeline::ShotRule;

namespace {

json FilmJson(Snapshot& snapshot, const ShotRule& rule) {
  json shot = {{"film", TextOf(rule.Given("film"))},
               {"fps", rule.fps},
               {"plate", TextOf(rule.Given("plate"))},
               {"mattes", TextOf(rule.Given("mattes"))},
               {"clicks", TextOf(rule.Given("clicks"))},
               {"holdout", TextOf(rule.Given("holdout"))},
               {"set", TextOf(rule.Given("set"))},
               {"camera", ShotCamera(snapshot)},
               {"shows", json::array()},
               {"frames", json::array()},
               {"width", 0},
               {"height", 0},
               {"problem", ""}};
  for (const ShotRule::Shows& show : rule.shows)
    shot["shows"].push_back({{"frame", show.frame}, {"pose", show.pose.text}});
  try {
    const auto pictures = PicturesOf(Resolved(snapshot, rule.Given("film")->text));
    for (const FilmPicture& picture : pictures)
      shot["frames"].push_back(
          {{"frame", picture.frame}, {"name", picture.path.filename().string()}});
    if (pictures.empty()) return shot;
    const ImageInfo first = ReadImageInfo(pictures.front().path);
    shot["width"] = first.width;
    shot["height"] = first.height;
  } catch (const Error& error) {
    shot["problem"] = error.what();
  }
  return shot;
}

/// What `locate` has measured of the camera; null where its report does not say.
json MeasuredJson(Snapshot& snapshot) {
  const json report = JsonOfFile(snapshot.Result("locate", "")->folder / "report.json");
  const json measured = report.value("measurements", json::object());
  json camera = json::object();
  for (const char* name : {"focal_seen", "one_place", "jitter_px", "camera_jitter_px"})
    camera[name] = measured.value(name, json());
  return camera;
}

json LocatedJson(Snapshot& snapshot) {
  const auto file = snapshot.ResultPath("locate", "", "shot");
  if (!file) return nullptr;
  const FilmedShot shot = ReadShot(*file);
  json located = {{"width", shot.camera.width},
                  {"height", shot.camera.height},
                  {"focal_px", shot.camera.fx},
                  {"focal", shot.focal},
                  {"focal_uncertainty", shot.focal_uncertainty},
                  {"still", shot.still},
                  {"measured", MeasuredJson(snapshot)},
                  {"has_picture", snapshot.ResultPath("locate", "", "picture").has_value()},
                  {"frames", json::array()}};
  const auto number = [](const auto& value) { return value ? json(*value) : json(); };
  for (const ShotFrame& frame : shot.frames)
    located["frames"].push_back({{"frame", frame.frame},
                                 {"pose", frame.pose},
                                 {"method", frame.method},
                                 {"contour_px", number(frame.contour_px)},
                                 {"iou", number(frame.iou)},
                                 {"inliers", number(frame.inliers)}});
  return located;
}

json FinishedJson(Snapshot& snapshot) {
  const auto folder = snapshot.ResultPath("composite", "", "pictures");
  if (!folder) return nullptr;
  const json made = JsonOfFile(*folder / "composite.json");
  const fs::path video = snapshot.project() / "out/shot/pictures/shot.mp4";
  json finished = {
      {"fps", made.at("fps")},       {"width", made.at("width")},
      {"height", made.at("height")}, {"pictures", made.at("pictures")},
      {"joins", made.at("joins")},   {"has_plate", fs::exists(*folder / "plate.png")},
      {"compared", json::array()},   {"video", fs::exists(video) ? "shot/pictures/shot.mp4" : ""}};
  for (const fs::path file : pipeline::RealDisk().Children(*folder / "compare"))
    if (int number = 0; std::sscanf(file.stem().c_str(), "%d", &number) == 1)
      finished["compared"].push_back(number);
  return finished;
}

}  // namespace

json ShotJson(Snapshot& snapshot) {
  json page = {{"revision", RevisionOf(snapshot.project() / "pipeline.yaml")},
               {"shot", nullptr},
               {"offers", ShotOffersJson(snapshot)},
               {"clicks", nullptr},
               {"located", nullptr},
               {"finished", nullptr}};
  if (!snapshot.file().shot) return page;
  page["shot"] = FilmJson(snapshot, *snapshot.file().shot);
  page["clicks"] = ClicksJson(snapshot);
  page["located"] = LocatedJson(snapshot);
  page["finished"] = FinishedJson(snapshot);
  return page;
}

fs::path FilmFrameFile(Snapshot& snapshot, int frame) {
  const ShotRule& shot = ShotOf(snapshot);
  for (const FilmPicture& picture : PicturesOf(Resolved(snapshot, shot.Given("film")->text)))
    if (picture.frame == frame) return picture.path;
  throw NotFound(fmt::format("the film has no frame {}", frame));
}

fs::path ShotPictureFile(Snapshot& snapshot, const std::string& what, int number) {
  if (what == "quick") {
    const fs::path picture = QuickFilesOf(snapshot.project(), number).picture;
    if (!fs::exists(picture)) throw NotFound("the camera of no frame was asked for yet");
    return picture;
  }
  if (what == "located") {
    const auto picture = snapshot.ResultPath("locate", "", "picture");
    if (!picture) throw NotFound("the camera is not found yet");
    return *picture;
  }
  const auto folder = snapshot.ResultPath("composite", "", "pictures");
  if (!folder) throw NotFound("the shot is not made yet");
  if (what == "plate" && fs::exists(*folder / "plate.png")) return *folder / "plate.png";
  const fs::path place = what == "compare" ? *folder / "compare" : *folder;
  const std::string stem = fmt::format("{:04}", number);
  if (what == "compare" || what == "result")
    for (const fs::path file : pipeline::RealDisk().Children(place))
      if (file.stem() == stem && !fs::is_directory(place / file)) return place / file;
  throw NotFound(fmt::format("the shot has no such picture: {} {}", what, number));
}

}  // namespace keypose::studio
