#include "fit/picks/pose_picks.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "core/io/project/landmarks_io.h"
#include "core/io/text/files.h"
#include "core/io/text/json_pick.h"
#include "core/numbers/sha256.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::fit {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Places = std::map<std::string, SurfacePoint>;

using Pick = JsonPick<json>;

/// SHA-256 of the photographs of a set, each read once.
class PhotographHashes {
 public:
  explicit PhotographHashes(const ImageSet& images) : images_(images) {}
  const std::string& Of(int i) {
    std::string& hash = hashes_[i];
    if (hash.empty()) hash = Sha256Of(ReadFile(images_.ImagePath(i)));
    return hash;
  }

 private:
  const ImageSet& images_;
  std::map<int, std::string> hashes_;
};

/// Which photograph the pick was made in; empty where only its name is known.
std::string PickedIn(const json& entry, const Pick& pick) {
  if (!entry.contains("photograph")) return "";
  if (!entry["photograph"].is_string())
    pick.Fail("has a 'photograph' that is no text: it is the SHA-256 of a file");
  return entry["photograph"].get<std::string>();
}

/// The number of the photograph that the pick is in; -1: it is known, and gone.
int ImageOf(const json& entry, const Pick& pick, const ImageSet& images) {
  if (!entry.contains("image") || !entry["image"].is_string())
    pick.Fail("needs an 'image', the file name of a photograph");
  const std::string image = entry["image"].get<std::string>();
  const int index = images.Find(image);
  if (index >= 0 || !PickedIn(entry, pick).empty()) return index;
  std::string names;
  constexpr int kMostNames = 8;
  for (int i = 0; i < std::min(kMostNames, SizeOf(images.images)); ++i)
    names += (i > 0 ? ", " : "") + images.images[i].name;
  pick.Fail(fmt::format("is in photograph '{}', which is not among the pose's {}: {}{}", image,
                        images.images.size(), names,
                        SizeOf(images.images) > kMostNames ? ", ..." : ""));
}

/// Whether a file's landmarks are places on a scan of the pose, such as the studio or MeshLab
/// writes for a scanned pose. The frame of that scan is not the template's.
bool IsOfAScan(const json& root) {
  return root.is_object() && root.contains("mesh") && root.contains("landmarks");
}

bool IsPickedPoints(const fs::path& path) {
  const std::string text = ReadFile(path);
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  return first != std::string::npos && text[first] == '<';
}

void WarnOfScan(const std::string& file, CarryLog* log) {
  if (log)
    log->warnings.push_back(
        file +
        ": its landmarks were picked on a mesh, not in photographs, as for a pose that is scanned; "
        "they are not used: pick the places in the photographs");
}

json ReadLists(const fs::path& path) {
  json root = ReadJson<json>(path);
  const bool has_pixels = root.is_object() && root.contains("pixels"),
             has_landmarks = root.is_object() && root.contains("landmarks");
  if ((!has_pixels && !has_landmarks) || (has_pixels && !root["pixels"].is_array()) ||
      (has_landmarks && !root["landmarks"].is_array()))
    throw InputError(PrintableName(path) +
                     " needs a list 'pixels', of picks in the pose's photographs, or a list "
                     "'landmarks', of places in space; docs/file-formats.md shows the format");
  return root;
}

/// The place of a pick: its own, or that of its name; none when the template has no such name.
std::optional<SurfacePoint> PlaceOf(const Pick& pick, const Mesh& mesh, const Places* named,
                                    PosePicks& picks) {
  if (!named) {
    if (!pick.HasPlace())
      pick.Fail(
          "needs its place on the template: a 'vertex', or a 'face' and 'barycentric'; or "
          "give the template's picks as a file before this one");
    return pick.Point(mesh, "template");
  }
  if (const auto found = named->find(pick.Name()); found != named->end()) return found->second;
  picks.unpaired.push_back(pick.Name());
  return std::nullopt;
}

void AddPixels(const json& list, const std::string& file, const Mesh& mesh, const ImageSet& images,
               const Places* named, PosePicks& picks) {
  std::set<std::pair<std::string, int>> taken;
  PhotographHashes hashes(images);
  for (int i = 0; i < SizeOf(list); ++i) {
    const Pick reader(list[i], file, "pick", i + 1);
    PhotoPick pick;
    pick.name = reader.Name();
    pick.image = ImageOf(list[i], reader, images);
    const std::string picked_in = PickedIn(list[i], reader);
    const bool gone = pick.image < 0;
    if (gone || (!picked_in.empty() && picked_in != hashes.Of(pick.image))) {
      (gone ? picks.of_none : picks.of_another)
          .push_back(fmt::format("'{}' in {}", pick.name, list[i]["image"].get<std::string>()));
      continue;
    }
    const CapturedImage& image = images.images[pick.image];
    pick.pixel = reader.Pixel(image.width, image.height, "photograph " + image.name);
    if (!taken.emplace(pick.name, pick.image).second)
      reader.Fail("is there twice in photograph " + image.name + "; rename or delete one");
    const std::optional<SurfacePoint> point = PlaceOf(reader, mesh, named, picks);
    if (!point) continue;
    pick.point = *point;
    picks.pixels.push_back(std::move(pick));
  }
}

void AddPlaces(const json& list, const std::string& file, const Mesh& mesh, const Places* named,
               PosePicks& picks) {
  std::set<std::string> taken;
  for (int i = 0; i < SizeOf(list); ++i) {
    const Pick reader(list[i], file, "pick", i + 1);
    if (!taken.insert(reader.Name()).second) reader.Fail("is there twice; rename or delete one");
    const std::vector<double> position = reader.Numbers("position", 3);
    if (const auto point = PlaceOf(reader, mesh, named, picks))
      picks.places.push_back({reader.Name(), *point, {position[0], position[1], position[2]}});
  }
}

Places PlacesOfTemplate(const fs::path& path, const Mesh& mesh, CarryLog* log) {
  Places places;
  for (const Landmark& landmark : ReadPicks(path, mesh, log, "template"))
    places[landmark.name] = {mesh.faces.row(landmark.face).transpose(), landmark.barycentric};
  return places;
}

}  // namespace

PosePicks ReadPosePicks(const std::vector<fs::path>& paths, const Mesh& mesh,
                        const ImageSet& images, CarryLog* log) {
  if (paths.empty()) return {};
  if (paths.size() > 2)
    throw InputError("landmarks: give one file, or the template's picks and the pose's; not " +
                     std::to_string(paths.size()) + " files");
  const std::string file = PrintableName(paths.back());
  if (IsPickedPoints(paths.back())) {
    WarnOfScan(file, log);
    return {};
  }
  const json root = ReadLists(paths.back());
  const bool of_a_scan = IsOfAScan(root);
  if (of_a_scan) WarnOfScan(file, log);
  if (of_a_scan && root.value("pixels", json::array()).empty()) return {};
  Places places;
  if (paths.size() == 2)
    places = PlacesOfTemplate(paths[0], mesh, log);
  else if (log)
    log->warnings.push_back(PrintableName(paths[0]) +
                            " does not say on which mesh its places were picked; its numbers are "
                            "used unchanged, which is wrong if the template was made anew since. "
                            "Picks of the template in a file of their own follow it");
  const Places* named = paths.size() == 2 ? &places : nullptr;
  PosePicks picks;
  AddPixels(root.value("pixels", json::array()), file, mesh, images, named, picks);
  if (!of_a_scan) AddPlaces(root.value("landmarks", json::array()), file, mesh, named, picks);
  std::sort(picks.unpaired.begin(), picks.unpaired.end());
  picks.unpaired.erase(std::unique(picks.unpaired.begin(), picks.unpaired.end()),
                       picks.unpaired.end());
  const bool some_left_out = !picks.of_another.empty() || !picks.of_none.empty();
  if (picks.pixels.empty() && picks.places.empty() && !some_left_out)
    throw InputError(
        picks.unpaired.empty()
            ? file + " holds no pick"
            : fmt::format("{} and {} share no name; give the same spot of clay the same name in "
                          "both",
                          PrintableName(paths[0]), file));
  return picks;
}

}  // namespace keypose::fit
