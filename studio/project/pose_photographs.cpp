#include "studio/project/pose_photographs.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "core/io/pictures/drawn_mask.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_set.h"
#include "core/io/pictures/other_thing_notes.h"
#include "core/io/pictures/photograph_files.h"
#include "core/io/pictures/raw_io.h"
#include "core/io/project/colmap_io.h"
#include "core/io/text/files.h"
#include "core/pictures/given_matte.h"
#include "core/pictures/image_turns.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "pipeline/disk/real_disk.h"
#include "studio/project/kept_picture.h"
#include "studio/project/left_out_photographs.h"
#include "studio/project/originals.h"
#include "studio/project/own_masks.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr int kLargestThumbnail = 4096;

std::optional<ImageSet> SetOf(Snapshot& snapshot, const std::string& pose, bool agreed) {
  const auto folder =
      agreed ? snapshot.ResultPath(snapshot.IsFitted(pose) ? "fit" : "masks", pose, "masked")
             : snapshot.ResultPath("capture", pose, "images");
  if (!folder) return std::nullopt;
  return ReadImageSet(*folder);
}

json PhotographJson(const CapturedImage& image) {
  return {{"name", image.name},
          {"width", image.width},
          {"height", image.height},
          {"sharpness", image.crispness > 0 ? image.crispness : image.sharpness},
          {"exposure", image.exposure},
          {"mask_fraction", image.mask_fraction},
          {"mask_given", image.mask_given},
          {"trusted", image.trusted},
          {"why", image.why},
          {"another_thing", false},
          {"captured", true}};
}

[[noreturn]] void NoPhotograph(const std::string& pose, const std::string& name) {
  throw NotFound(fmt::format("pose '{}' has no photograph '{}'", pose, name));
}

/// Capture gives RAW and HEIC files another extension.
bool IsCaptured(const std::map<std::string, json>& captured, const std::string& name) {
  return captured.contains(name) || captured.contains(WrittenName(name));
}

/// As before capture has read it.
json NewPhotographJson(const std::string& name) {
  CapturedImage image;
  image.name = name;
  json one = PhotographJson(image);
  one["captured"] = false;
  return one;
}

bool IsSamePhotograph(const Originals& originals, const std::string& out, const std::string& name) {
  if (out == name) return true;
  const fs::path one = originals.FileOf(out);
  return !one.empty() && one == originals.FileOf(name);
}

/// What is left out of a subfolder is not captured, nor in the pose's own folder.
void AddLeftOut(const Originals& originals, const std::string& out,
                std::map<std::string, json>* by_name) {
  const fs::path file = originals.FileOf(out);
  if (file.empty()) return;
  for (const auto& [name, one] : *by_name)
    if (originals.FileOf(name) == file) return;
  const bool below = out.find('/') != std::string::npos;
  const std::string group = file.parent_path().filename();
  const std::string name = below ? group + "_" + WrittenName(file) : file.filename().string();
  if (IsValidUtf8(name)) (*by_name)[name] = NewPhotographJson(name);
}

/// What capture has left out, by the names it gives.
OtherThingNotes OtherThingsOf(Snapshot& snapshot, const std::string& pose) {
  const auto folder = snapshot.ResultPath("capture", pose, "images");
  return folder ? ReadOtherThingNotes(*folder) : OtherThingNotes{};
}

}  // namespace

json PhotographsJson(Snapshot& snapshot, const std::string& pose) {
  std::map<std::string, json> by_name;
  const auto captured = SetOf(snapshot, pose, false), agreed = SetOf(snapshot, pose, true);
  const OwnMasks masks(snapshot, pose);
  if (captured)
    for (const CapturedImage& image : captured->images) by_name[image.name] = PhotographJson(image);
  if (agreed) {
    for (const CapturedImage& image : agreed->images) {
      if (!by_name.contains(image.name)) continue;
      json& one = by_name[image.name];
      one["mask_fraction"] = image.mask_fraction;
      one["trusted"] = image.trusted;
      one["why"] = image.why;
    }
  }
  for (auto& [name, one] : by_name)
    if (masks.originals().WasShotAgain(name)) one = NewPhotographJson(name);
  for (const std::string& name : OriginalPhotographs(snapshot.PhotoFolder(pose)))
    if (IsValidUtf8(name) && !IsCaptured(by_name, name)) by_name[name] = NewPhotographJson(name);
  const OtherThingNotes other_things = OtherThingsOf(snapshot, pose);
  for (auto& [name, one] : by_name) {
    const auto why = other_things.find(other_things.contains(name) ? name : WrittenName(name));
    if (why == other_things.end() || masks.originals().WasShotAgain(name)) continue;
    one["another_thing"] = true;
    one["why"] = why->second;
  }
  const std::vector<std::string> left_out = LeftOutNames(snapshot, pose);
  for (const std::string& name : left_out) AddLeftOut(masks.originals(), name, &by_name);
  json all = json::array();
  for (auto& [name, one] : by_name) {
    one["left_out"] = std::any_of(left_out.begin(), left_out.end(), [&](const auto& out) {
      return IsSamePhotograph(masks.originals(), out, name);
    });
    // A mask that capture has not seen yet is one's own as well.
    const bool of_another = masks.IsOfAnother(name);
    if (of_another) one["mask_given"] = false;
    if (!masks.InForce(name).empty()) one["mask_given"] = true;
    one["mask_of_another"] = of_another;
    one["photograph"] = masks.originals().HashOf(name);
    all.push_back(std::move(one));
  }
  return all;
}

fs::path PhotographSource(Snapshot& snapshot, const std::string& pose, const std::string& name,
                          bool as_captured) {
  if (!snapshot.HasPose(pose) || !IsOneName(name)) NoPhotograph(pose, name);
  const Originals originals(snapshot, pose);
  if (as_captured || !originals.WasShotAgain(name))
    if (const auto set = SetOf(snapshot, pose, false))
      if (const int i = set->Find(name); i >= 0) return set->ImagePath(i);
  const fs::path file = originals.FileOf(name);
  if (file.empty() || !fs::is_regular_file(file)) NoPhotograph(pose, name);
  return file;
}

fs::path PictureFile(const fs::path& folder, const fs::path& photograph, int width) {
  if (!fs::exists(photograph)) throw NotFound(photograph.filename().string() + " is gone");
  const bool raw = IsRawName(photograph);
  const std::string format = raw ? "raw" : ReadImageInfo(photograph).format;
  if (width <= 0 && (format == "jpeg" || format == "png")) return photograph;
  const int most = std::min(width, kLargestThumbnail);
  return KeptPicture(folder, photograph, std::to_string(most), ".jpg", [&](const fs::path& file) {
    Image8 image = raw ? ReadRaw(photograph) : ReadImage(photograph, 3);
    const double share = most > 0 && most < image.width ? 1.0 * most / image.width : 1;
    if (share < 1)
      image = Resized(image, most, std::max(1, static_cast<int>(image.height * share)));
    WriteImage(file, image, most > 0 ? 82 : 92);
  });
}

namespace {

/// A person's mask, by its levels and the right way round.
Image8 AsCaptureTakes(const fs::path& file) {
  Image8 mask = ReadDrawnMask(file);
  return CoversBorder(mask) ? InvertedMatte(std::move(mask)) : mask;
}

}  // namespace

fs::path MaskPicture(const fs::path& folder, const fs::path& mask, int width, int height) {
  const ImageInfo info = ReadImageInfo(mask);
  // Others than those of an images folder were drawn by a person, and may have any levels.
  const bool ours = fs::exists(mask.parent_path().parent_path() / "capture.json");
  if (ours && info.format == "png" &&
      (width == 0 || (info.width == width && info.height == height)))
    return mask;
  return KeptPicture(folder, mask, fmt::format("mask as drawn {} {}", width, height), ".png",
                     [&](const fs::path& file) {
                       Image8 image = ours ? ReadImage(mask, 1) : AsCaptureTakes(mask);
                       // Capture turns portraits among landscapes; masks lie as their photographs
                       // did.
                       if (width > 0 && (image.width > image.height) != (width > height))
                         image = QuarterTurned(image);
                       if (width > 0) image = Resized(image, width, height);
                       for (auto& value : image.data) value = value >= 128 ? 255 : 0;
                       WriteImage(file, image);
                     });
}

fs::path MaskFile(Snapshot& snapshot, const std::string& pose, const std::string& name,
                  const std::string& stage) {
  if (!snapshot.HasPose(pose)) NoPhotograph(pose, name);
  const OwnMasks masks(snapshot, pose);
  if (const fs::path own = masks.InForce(name); !own.empty()) return own;
  for (const bool agreed : {true, false}) {
    if ((agreed && stage != "masks") || masks.originals().WasShotAgain(name)) continue;
    const auto set = SetOf(snapshot, pose, agreed);
    if (!set) continue;
    if (const int i = set->Find(name); i >= 0) return set->MaskPath(i);
  }
  throw NotFound(fmt::format("photograph '{}' of pose '{}' has no mask yet", name, pose));
}

std::pair<int, int> PhotographSize(Snapshot& snapshot, const std::string& pose,
                                   const std::string& name) {
  if (!snapshot.HasPose(pose) || Originals(snapshot, pose).WasShotAgain(name)) return {0, 0};
  const auto set = SetOf(snapshot, pose, false);
  const int i = set ? set->Find(name) : -1;
  return i < 0 ? std::pair{0, 0} : std::pair{set->images[i].width, set->images[i].height};
}

json CamerasJson(Snapshot& snapshot, const std::string& pose) {
  const auto model = snapshot.CamerasPath(pose);
  json cameras = json::array();
  if (!model) return cameras;
  for (const View& view : ReadColmapModel(*model).views) {
    const Rigid3 world_from_camera = view.camera_from_world.Inverse();
    const Eigen::Matrix3d r = world_from_camera.rotation.toRotationMatrix();
    json rows = json::array();
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) rows.push_back(r(i, k));
      rows.push_back(world_from_camera.translation[i]);
    }
    cameras.push_back({{"name", view.name},
                       {"pose", rows},
                       {"focal_px", view.camera.fy},
                       {"width", view.camera.width},
                       {"height", view.camera.height},
                       {"cx", view.camera.cx},
                       {"cy", view.camera.cy}});
  }
  return cameras;
}

}  // namespace keypose::studio
