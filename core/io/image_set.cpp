#include "core/io/image_set.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/io/files.h"

namespace keypose {
namespace fs = std::filesystem;
using nlohmann::json;

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
    for (const json& entry : root.at("images")) {
      CapturedImage image;
      image.name = entry.at("name");
      image.width = entry.at("width");
      image.height = entry.at("height");
      image.focal_px = entry.value("focal_px", 0.0);
      image.mask = entry.value("mask", "");
      image.sharpness = entry.value("sharpness", 0.0);
      image.exposure = entry.value("exposure", 0.0);
      image.mask_fraction = entry.value("mask_fraction", 0.0);
      set.images.push_back(std::move(image));
    }
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
  for (const CapturedImage& image : set.images)
    root["images"].push_back({{"name", image.name},
                              {"width", image.width},
                              {"height", image.height},
                              {"focal_px", image.focal_px},
                              {"mask", image.mask},
                              {"sharpness", image.sharpness},
                              {"exposure", image.exposure},
                              {"mask_fraction", image.mask_fraction}});
  WriteFile(set.folder / "capture.json", root.dump(1) + "\n");
}

}  // namespace keypose
