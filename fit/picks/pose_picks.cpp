#include "fit/picks/pose_picks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "core/errors.h"
#include "core/io/files.h"
#include "core/io/landmarks_io.h"

namespace keypose::fit {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Places = std::map<std::string, SurfacePoint>;

/// One pick's fields; messages name file and pick.
class PickReader {
 public:
  PickReader(const json& pick, const std::string& file, int number) : pick_(pick) {
    where_ = fmt::format("{}: pick {}", file, number);
    if (!pick.is_object()) Fail("is not an object");
    if (!pick.contains("name") || !pick["name"].is_string()) Fail("needs a 'name'");
    name_ = pick["name"].get<std::string>();
    where_ = fmt::format("{}: pick '{}'", file, name_);
  }
  const std::string& name() const { return name_; }
  [[noreturn]] void Fail(const std::string& what) const { throw InputError(where_ + " " + what); }

  bool HasPlace() const { return pick_.contains("vertex") || pick_.contains("face"); }
  SurfacePoint Point(const Mesh& mesh) const;
  int Image(const ImageSet& images) const;
  Eigen::Vector2d Pixel(const CapturedImage& image) const;
  Eigen::Vector3d Position() const {
    const std::vector<double> position = Numbers("position", 3);
    return {position[0], position[1], position[2]};
  }

 private:
  std::vector<double> Numbers(const char* name, std::size_t count) const;
  int Index(const char* name, int count, const char* things) const;

  const json& pick_;
  std::string where_, name_;
};

std::vector<double> PickReader::Numbers(const char* name, std::size_t count) const {
  std::vector<double> numbers;
  if (pick_.contains(name) && pick_[name].is_array() && pick_[name].size() == count)
    for (const json& number : pick_[name])
      if (number.is_number() && std::isfinite(number.get<double>())) numbers.push_back(number);
  if (numbers.size() != count) Fail(fmt::format("needs '{}': a list of {} numbers", name, count));
  return numbers;
}

int PickReader::Index(const char* name, int count, const char* things) const {
  const json& value = pick_[name];
  if (!value.is_number_integer()) Fail(fmt::format("has a '{}' that is not a whole number", name));
  const auto index = value.get<std::int64_t>();
  if (index < 0 || index >= count)
    Fail(
        fmt::format("has {} {}, but the template has {} {}, counted from 0; it was picked on "
                    "another mesh: pick it again",
                    name, index, count, things));
  return static_cast<int>(index);
}

SurfacePoint PickReader::Point(const Mesh& mesh) const {
  SurfacePoint point;
  if (pick_.contains("vertex")) {
    point.vertices.setConstant(Index("vertex", mesh.vertex_count(), "vertices"));
    return point;
  }
  const int face = Index("face", mesh.face_count(), "faces");
  const std::vector<double> weights = Numbers("barycentric", 3);
  const double sum = weights[0] + weights[1] + weights[2];
  if (*std::min_element(weights.begin(), weights.end()) < -1e-6 || std::abs(sum - 1) > 1e-6)
    Fail("has barycentric coordinates that do not lie in its triangle; pick it again");
  return {mesh.faces.row(face).transpose(), {weights[0], weights[1], weights[2]}};
}

int PickReader::Image(const ImageSet& images) const {
  if (!pick_.contains("image") || !pick_["image"].is_string())
    Fail("needs an 'image', the file name of a photograph");
  const std::string image = pick_["image"].get<std::string>();
  const int index = images.Find(image);
  if (index >= 0) return index;
  std::string names;
  constexpr int kMostNames = 8;
  for (int i = 0; i < std::min<int>(kMostNames, static_cast<int>(images.images.size())); ++i)
    names += (i > 0 ? ", " : "") + images.images[i].name;
  Fail(fmt::format("is in photograph '{}', which is not among the pose's {}: {}{}", image,
                   images.images.size(), names, images.images.size() > kMostNames ? ", ..." : ""));
}

Eigen::Vector2d PickReader::Pixel(const CapturedImage& image) const {
  const std::vector<double> pixel = Numbers("pixel", 2);
  if (pixel[0] < 0 || pixel[1] < 0 || pixel[0] > image.width || pixel[1] > image.height)
    Fail(
        fmt::format("has pixel [{:g}, {:g}], but photograph {} has {} x {} pixels; pick it again "
                    "in the photograph's full size",
                    pixel[0], pixel[1], image.name, image.width, image.height));
  return {pixel[0], pixel[1]};
}

json Parsed(const fs::path& path) {
  const std::string text = ReadFile(path), name = PrintableName(path);
  RequireShallowJson(text, name);
  json root;
  try {
    root = json::parse(text);
  } catch (const json::exception& fault) {
    throw InputError(name + " is not JSON: " + JsonFault(fault));
  }
  const bool has_pixels = root.is_object() && root.contains("pixels"),
             has_landmarks = root.is_object() && root.contains("landmarks");
  if ((!has_pixels && !has_landmarks) || (has_pixels && !root["pixels"].is_array()) ||
      (has_landmarks && !root["landmarks"].is_array()))
    throw InputError(name +
                     " needs a list 'pixels', of picks in the pose's photographs, or a list "
                     "'landmarks', of places in space; docs/file-formats.md shows the format");
  return root;
}

/// The place of a pick: its own, or that of its name; none when the template has no such name.
std::optional<SurfacePoint> PlaceOf(const PickReader& pick, const Mesh& mesh, const Places* named,
                                    PosePicks& picks) {
  if (!named) {
    if (!pick.HasPlace())
      pick.Fail(
          "needs its place on the template: a 'vertex', or a 'face' and 'barycentric'; or "
          "give the template's picks as a file before this one");
    return pick.Point(mesh);
  }
  if (const auto found = named->find(pick.name()); found != named->end()) return found->second;
  picks.unpaired.push_back(pick.name());
  return std::nullopt;
}

void AddPixels(const json& list, const std::string& file, const Mesh& mesh, const ImageSet& images,
               const Places* named, PosePicks& picks) {
  std::set<std::pair<std::string, int>> taken;
  for (int i = 0; i < static_cast<int>(list.size()); ++i) {
    const PickReader reader(list[i], file, i + 1);
    PhotoPick pick;
    pick.name = reader.name();
    pick.image = reader.Image(images);
    const CapturedImage& image = images.images[pick.image];
    pick.pixel = reader.Pixel(image);
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
  for (int i = 0; i < static_cast<int>(list.size()); ++i) {
    const PickReader reader(list[i], file, i + 1);
    if (!taken.insert(reader.name()).second) reader.Fail("is there twice; rename or delete one");
    const Eigen::Vector3d position = reader.Position();
    if (const auto point = PlaceOf(reader, mesh, named, picks))
      picks.places.push_back({reader.name(), *point, position});
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
  const json root = Parsed(paths.back());
  Places places;
  if (paths.size() == 2)
    places = PlacesOfTemplate(paths[0], mesh, log);
  else if (log)
    log->warnings.push_back(PrintableName(paths[0]) +
                            " does not say on which mesh its places were picked; its numbers are "
                            "used unchanged, which is wrong if the template was made anew since. "
                            "Picks of the template in a file of their own follow it");
  const Places* named = paths.size() == 2 ? &places : nullptr;
  const std::string file = PrintableName(paths.back());
  PosePicks picks;
  AddPixels(root.value("pixels", json::array()), file, mesh, images, named, picks);
  AddPlaces(root.value("landmarks", json::array()), file, mesh, named, picks);
  std::sort(picks.unpaired.begin(), picks.unpaired.end());
  picks.unpaired.erase(std::unique(picks.unpaired.begin(), picks.unpaired.end()),
                       picks.unpaired.end());
  if (picks.pixels.empty() && picks.places.empty())
    throw InputError(
        picks.unpaired.empty()
            ? file + " holds no pick"
            : fmt::format("{} and {} share no name; give the same spot of clay the same name in "
                          "both",
                          PrintableName(paths[0]), file));
  return picks;
}

}  // namespace keypose::fit
