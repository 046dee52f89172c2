#include "core/io/pictures/image_set.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "core/io/pictures/image_kind.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"

namespace keypose {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

json CornersJson(const std::vector<BoardCorner>& corners) {
  json list = json::array();
  for (const BoardCorner& corner : corners)
    list.push_back({corner.id, corner.pixel.x(), corner.pixel.y()});
  return list;
}

std::vector<BoardCorner> CornersFrom(const json& list, const BoardLayout& board) {
  std::vector<BoardCorner> corners;
  for (const json& entry : list) {
    const BoardCorner corner{entry.at(0),
                             Eigen::Vector2d(entry.at(1).get<double>(), entry.at(2).get<double>())};
    if (corner.id < 0 || corner.id >= board.CornerCount())
      throw InputError("a corner of the calibration board has the id " + std::to_string(corner.id));
    corners.push_back(corner);
  }
  return corners;
}

TurntablePlace PlaceFrom(const json& entry) {
  const TurntablePlace place{entry.at("ring"), entry.at("angle_deg"), entry.at("tilt_deg"),
                             entry.at("flip")};
  if (!(std::abs(place.angle_deg) <= 360 && std::abs(place.tilt_deg) <= 90) || place.ring < 1 ||
      place.flip < 0)
    throw InputError("a photograph has an impossible place on the turntable");
  return place;
}

json PlaceJson(const TurntablePlace& place) {
  return {{"ring", place.ring},
          {"angle_deg", place.angle_deg},
          {"tilt_deg", place.tilt_deg},
          {"flip", place.flip}};
}

void ReadBoard(const json& entry, ImageSet* set) {
  const BoardLayout board{entry.at("columns"), entry.at("rows"), entry.at("square_m"),
                          entry.at("marker_m")};
  BoardPrint print;
  if (entry.contains("dictionary")) {
    const std::string name = entry.at("dictionary");
    const std::optional<int> known = DictionaryNamed(name);
    if (!known) throw InputError("its board has the unknown dictionary '" + name + "'");
    print.dictionary = *known;
  }
  print.first_white = entry.value("first_white", false);
  print.inverted = entry.value("inverted", false);
  if (const auto problems = BoardProblems(board, print); !problems.empty())
    throw InputError(problems.front());
  set->board = board;
  set->board_print = print;
}

json BoardJson(const BoardLayout& board, const BoardPrint& print) {
  json entry = {{"dictionary", DictionaryName(print.dictionary)},
                {"columns", board.columns},
                {"rows", board.rows},
                {"square_m", board.square_m},
                {"marker_m", board.marker_m}};
  if (print.first_white) entry["first_white"] = true;
  if (print.inverted) entry["inverted"] = true;
  return entry;
}

/// Whether `relative` is a path below `folder`: without steps upwards, and without links that lead
/// outside. For a path that does not exist, the existing part is checked.
bool LiesBelow(const fs::path& folder, const fs::path& relative) {
  if (relative.empty() || relative.has_root_path() ||
      relative.native().find('\0') != std::string::npos)
    return false;
  std::error_code error;
  const fs::path base = fs::canonical(folder, error);
  if (error) return false;
  const fs::path resolved = fs::weakly_canonical(base / relative, error);
  if (error || std::find(relative.begin(), relative.end(), "..") != relative.end()) return false;
  return resolved != base && IsWithin(resolved, base);
}

/// Checks the names in an image's entry of capture.json. They decide which files are read and, in
/// stages that copy the set, which are written. Steps upwards and links must not lead outside of
/// the folder.
void RequireBelow(const fs::path& folder, const CapturedImage& image) {
  if (fs::path(image.name).filename() != image.name || !LiesBelow(folder, image.name))
    throw InputError("the photograph '" + image.name +
                     "' is not a file of the folder (links are followed)");
  if (!image.mask.empty() && !LiesBelow(folder, image.mask))
    throw InputError("the mask '" + image.mask + "' of " + image.name +
                     " lies outside of the folder (links are followed)");
}

void RequireUsableNumbers(const CapturedImage& image) {
  if (image.width < 0 || image.height < 0 || std::int64_t{image.width} * image.height > kMostPixels)
    throw InputError(image.name + " is " + std::to_string(image.width) + " x " +
                     std::to_string(image.height) + " pixels");
  if (image.photograph_width < 0 || image.photograph_height < 0 ||
      (image.photograph_width == 0) != (image.photograph_height == 0))
    throw InputError(image.name + " was made of a photograph of an impossible size");
  if (!(image.focal_px >= 0 && image.focal_px < 1e7))
    throw InputError(image.name + " has an impossible focal length");
}

}  // namespace

bool LiesAcross(const CapturedImage& image) {
  return image.photograph_width > 0 &&
         (image.photograph_width > image.photograph_height) != (image.width > image.height);
}

int ImageSet::Find(const std::string& name) const {
  const auto it = std::lower_bound(
      images.begin(), images.end(), name,
      [](const CapturedImage& image, const std::string& n) { return image.name < n; });
  return it != images.end() && it->name == name ? static_cast<int>(it - images.begin()) : -1;
}

namespace {

CapturedImage ImageFrom(const json& entry, const std::optional<BoardLayout>& board) {
  CapturedImage image;
  image.name = entry.at("name");
  image.width = entry.at("width");
  image.height = entry.at("height");
  if (entry.contains("photograph")) {
    image.photograph_width = entry.at("photograph").at(0);
    image.photograph_height = entry.at("photograph").at(1);
  }
  image.focal_px = entry.value("focal_px", 0.0);
  image.mask = entry.value("mask", "");
  image.mask_given = entry.value("mask_given", false);
  image.trusted = entry.value("trusted", true);
  image.why = entry.value("why", "");
  image.sharpness = entry.value("sharpness", 0.0);
  image.crispness = entry.value("crispness", 0.0);
  image.exposure = entry.value("exposure", 0.0);
  image.mask_fraction = entry.value("mask_fraction", 0.0);
  image.group = entry.value("group", "");
  if (board && entry.contains("board_corners"))
    image.board_corners = CornersFrom(entry.at("board_corners"), *board);
  if (entry.contains("turntable")) image.place = PlaceFrom(entry.at("turntable"));
  RequireUsableNumbers(image);
  return image;
}

/// @throws InputError  a name that is repeated, leads out of the folder, or has no file
void RequireUsableNames(const ImageSet& set, const fs::path& file) {
  for (std::size_t i = 0; i < set.images.size(); ++i) {
    const std::string& name = set.images[i].name;
    if (i > 0 && set.images[i - 1].name == name)
      throw InputError(file.string() + " names " + name + " twice; run 'keypose capture' again");
    try {
      RequireBelow(set.folder, set.images[i]);
    } catch (const InputError& error) {
      throw InputError(
          file.string() + ": " + error.what() +
          "; run 'keypose capture' again, and do not trust a folder with such entries");
    }
    if (!fs::exists(set.folder / name))
      throw InputError(file.string() + " names " + name +
                       ", but that photograph is not in the folder");
  }
}

/// Versions of masks before 17 wrote `true`, for a plane at z = 0.
std::optional<double> FloorFrom(const json& floor) {
  if (!floor.is_boolean()) return floor.get<double>();
  return floor.get<bool>() ? std::optional<double>(0) : std::nullopt;
}

}  // namespace

ImageSet ReadImageSet(const fs::path& folder) {
  const fs::path file = folder / "capture.json";
  if (!fs::exists(file))
    throw InputError(folder.string() +
                     " has no capture.json: it is not an images folder; make one with 'keypose "
                     "capture --photos " +
                     folder.string() + "'");
  ImageSet set;
  set.folder = folder;
  const std::string text = ReadFile(file);
  RequireShallowJson(text, file.string());
  try {
    const json root = json::parse(text);
    set.camera_model = root.value("camera_model", "");
    if (root.contains("board")) ReadBoard(root.at("board"), &set);
    if (root.contains("floor")) set.floor = FloorFrom(root.at("floor"));
    for (const json& entry : root.at("images")) set.images.push_back(ImageFrom(entry, set.board));
  } catch (const InputError& error) {
    throw InputError(file.string() + " is damaged (" + error.what() +
                     "); run 'keypose capture' again");
  } catch (const json::exception& error) {
    throw InputError(file.string() + " is damaged (" + JsonFault(error) +
                     "); run 'keypose capture' again");
  }
  std::sort(set.images.begin(), set.images.end(),
            [](const auto& a, const auto& b) { return a.name < b.name; });
  RequireUsableNames(set, file);
  return set;
}

void WriteImageSet(const ImageSet& set) {
  json root;
  root["schema"] = 1;
  root["camera_model"] = set.camera_model;
  root["images"] = json::array();
  if (set.floor) root["floor"] = *set.floor;
  if (set.board) root["board"] = BoardJson(*set.board, set.board_print);
  for (const CapturedImage& image : set.images) {
    json entry = {{"name", image.name},         {"width", image.width},
                  {"height", image.height},     {"focal_px", image.focal_px},
                  {"mask", image.mask},         {"sharpness", image.sharpness},
                  {"exposure", image.exposure}, {"mask_fraction", image.mask_fraction}};
    if (image.photograph_width > 0)
      entry["photograph"] = {image.photograph_width, image.photograph_height};
    if (image.crispness > 0) entry["crispness"] = image.crispness;
    if (image.mask_given) entry["mask_given"] = true;
    if (!image.trusted) {
      entry["trusted"] = false;
      entry["why"] = image.why;
    }
    if (!image.group.empty()) entry["group"] = image.group;
    if (!image.board_corners.empty()) entry["board_corners"] = CornersJson(image.board_corners);
    if (image.place) entry["turntable"] = PlaceJson(*image.place);
    root["images"].push_back(std::move(entry));
  }
  WriteFile(set.folder / "capture.json", root.dump(1) + "\n");
}

}  // namespace keypose
