#include "core/io/image_set.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/io/files.h"

namespace keypose {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

json CornersJson(const std::vector<PlateCorner>& corners) {
  json list = json::array();
  for (const PlateCorner& corner : corners) list.push_back({corner.id, corner.pixel.x(), corner.pixel.y()});
  return list;
}

std::vector<PlateCorner> CornersFrom(const json& list, const PlateLayout& plate) {
  std::vector<PlateCorner> corners;
  for (const json& entry : list) {
    const PlateCorner corner{entry.at(0), Eigen::Vector2d(entry.at(1).get<double>(), entry.at(2).get<double>())};
    if (corner.id < 0 || corner.id >= plate.CornerCount()) throw InputError("a plate corner has the id " + std::to_string(corner.id));
    corners.push_back(corner);
  }
  return corners;
}

PlateLayout PlateFrom(const json& entry) {
  PlateLayout plate{entry.at("columns"), entry.at("rows"), entry.at("square_m"), entry.at("marker_m")};
  if (const auto problems = plate.Problems(); !problems.empty()) throw InputError(problems.front());
  return plate;
}

}  // namespace

int ImageSet::Find(const std::string& name) const {
  const auto it =
      std::lower_bound(images.begin(), images.end(), name, [](const CapturedImage& image, const std::string& n) { return image.name < n; });
  return it != images.end() && it->name == name ? static_cast<int>(it - images.begin()) : -1;
}

ImageSet ReadImageSet(const fs::path& folder) {
  const fs::path file = folder / "capture.json";
  if (!fs::exists(file))
    throw InputError(folder.string() + " has no capture.json: it is not an images folder; make one with 'keypose capture --photos " +
                     folder.string() + "'");
  ImageSet set;
  set.folder = folder;
  try {
    const json root = json::parse(ReadFile(file));
    set.camera_model = root.value("camera_model", "");
    if (root.contains("plate")) set.plate = PlateFrom(root.at("plate"));
    for (const json& entry : root.at("images")) {
      CapturedImage image;
      image.name = entry.at("name");
      image.width = entry.at("width");
      image.height = entry.at("height");
      image.focal_px = entry.value("focal_px", 0.0);
      image.mask = entry.value("mask", "");
      image.mask_given = entry.value("mask_given", false);
      image.trusted = entry.value("trusted", true);
      image.why = entry.value("why", "");
      image.sharpness = entry.value("sharpness", 0.0);
      image.exposure = entry.value("exposure", 0.0);
      image.mask_fraction = entry.value("mask_fraction", 0.0);
      image.group = entry.value("group", "");
      if (set.plate && entry.contains("plate_corners")) image.plate_corners = CornersFrom(entry.at("plate_corners"), *set.plate);
      set.images.push_back(std::move(image));
    }
  } catch (const InputError& error) {
    throw InputError(file.string() + " is damaged (" + error.what() + "); run 'keypose capture' again");
  } catch (const json::exception& error) {
    throw InputError(file.string() + " is damaged (" + error.what() + "); run 'keypose capture' again");
  }
  std::sort(set.images.begin(), set.images.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  for (std::size_t i = 0; i < set.images.size(); ++i)
    if (!fs::exists(folder / set.images[i].name))
      throw InputError(file.string() + " names " + set.images[i].name + ", but that photograph is not in the folder");
  return set;
}

void WriteImageSet(const ImageSet& set) {
  json root;
  root["schema"] = 1;
  root["camera_model"] = set.camera_model;
  root["images"] = json::array();
  if (set.plate)
    root["plate"] = {{"dictionary", "DICT_5X5_100"},
                     {"columns", set.plate->columns},
                     {"rows", set.plate->rows},
                     {"square_m", set.plate->square_m},
                     {"marker_m", set.plate->marker_m}};
  for (const CapturedImage& image : set.images) {
    json entry = {
        {"name", image.name}, {"width", image.width},         {"height", image.height},     {"focal_px", image.focal_px},
        {"mask", image.mask}, {"sharpness", image.sharpness}, {"exposure", image.exposure}, {"mask_fraction", image.mask_fraction}};
    if (image.mask_given) entry["mask_given"] = true;
    if (!image.trusted) entry["trusted"] = false, entry["why"] = image.why;
    if (!image.group.empty()) entry["group"] = image.group;
    if (!image.plate_corners.empty()) entry["plate_corners"] = CornersJson(image.plate_corners);
    root["images"].push_back(std::move(entry));
  }
  WriteFile(set.folder / "capture.json", root.dump(1) + "\n");
}

}  // namespace keypose
