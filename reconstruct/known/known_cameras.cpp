#include "reconstruct/known/known_cameras.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "core/values/errors.h"

namespace keypose::reconstruct {
namespace {

std::string Stem(const std::string& name) { return name.substr(0, name.find_last_of('.')); }

Camera ForPhotograph(const View& known, const Camera& photograph) {
  Camera camera = known.camera;
  if (camera.fx < 0) camera.fx *= -photograph.width;
  if (camera.fy < 0) camera.fy *= -photograph.width;
  if (camera.width <= 0) camera.width = photograph.width;
  if (camera.height <= 0) camera.height = photograph.height;
  if (camera.cx <= 0) camera.cx = camera.width / 2.0;
  if (camera.cy <= 0) camera.cy = camera.height / 2.0;
  const double factor = static_cast<double>(photograph.width) / camera.width;
  if (std::abs(factor * camera.height - photograph.height) > 1.5)
    throw InputError("sfm: the known camera of " + known.name + " is for " +
                     std::to_string(camera.width) + " x " + std::to_string(camera.height) +
                     " pixels, but the photograph has " + std::to_string(photograph.width) + " x " +
                     std::to_string(photograph.height) +
                     "; give cameras for the photographs as capture wrote them");
  if (factor != 1) camera = camera.Scaled(factor);
  camera.width = photograph.width;
  camera.height = photograph.height;
  if (!(camera.fx > 0 && camera.fy > 0 && std::isfinite(camera.fx) && std::isfinite(camera.fy)))
    throw InputError("sfm: the known camera of " + known.name + " has no positive focal length");
  return camera;
}

/// The photographs of a set, by name and by what stands before the extension.
class PhotographNames {
 public:
  explicit PhotographNames(const std::vector<std::string>& names) {
    for (std::size_t i = 0; i < names.size(); ++i) {
      by_name_[names[i]] = i;
      by_stem_.emplace(Stem(names[i]), i);
    }
  }
  /// By the whole path of a view first, whose folders capture joins to the name with "_", then with
  /// fewer and fewer of its folders.
  std::optional<std::size_t> Find(std::string path) const {
    std::replace(path.begin(), path.end(), '\\', '/');
    while (true) {
      std::string name = path;
      std::replace(name.begin(), name.end(), '/', '_');
      if (const auto found = FindName(name)) return found;
      const std::size_t slash = path.find('/');
      if (slash == std::string::npos) return std::nullopt;
      path.erase(0, slash + 1);
    }
  }

 private:
  std::optional<std::size_t> FindName(const std::string& name) const {
    if (const auto found = by_name_.find(name); found != by_name_.end()) return found->second;
    for (const std::string& stem : {name, Stem(name)})
      if (const auto found = by_stem_.find(stem); found != by_stem_.end()) return found->second;
    return std::nullopt;
  }

  std::map<std::string, std::size_t> by_name_, by_stem_;
};

}  // namespace

std::vector<View> MatchKnownPoses(const std::vector<View>& known,
                                  const std::vector<std::string>& photographs,
                                  const std::vector<Camera>& sizes) {
  const PhotographNames names(photographs);
  std::map<std::string, View> matched;
  std::string strangers;
  int count = 0;
  for (const View& view : known) {
    const std::optional<std::size_t> found = names.Find(view.name);
    if (!found) {
      if (++count <= 12) strangers += (strangers.empty() ? "" : ", ") + view.name;
      continue;
    }
    View here = view;
    here.name = photographs[*found];
    here.camera = ForPhotograph(view, sizes[*found]);
    if (!matched.emplace(here.name, here).second)
      throw InputError("sfm: the known poses hold two cameras for " + here.name +
                       "; leave one out");
  }
  if (count > 0)
    throw InputError(
        "sfm: the known poses name " + std::to_string(count) +
        " photographs that are not in the set: " + strangers + (count > 12 ? " and more" : "") +
        "; the first photograph here is " + photographs.front() +
        ": give the poses the photographs' names, or leave out those that are not used");
  std::vector<View> views;
  for (auto& [name, view] : matched) views.push_back(std::move(view));
  return views;
}

}  // namespace keypose::reconstruct
