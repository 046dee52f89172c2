#include "core/io/project/poses_io.h"

#include <algorithm>
#include <optional>

#include "core/io/project/colmap_io.h"
#include "core/io/project/lens_use.h"
#include "core/io/project/metashape_io.h"
#include "core/io/project/transforms_io.h"
#include "core/io/text/text_file.h"
#include "core/values/errors.h"

namespace keypose {
namespace fs = std::filesystem;

namespace {

/// What a folder without a COLMAP model holds.
fs::path FileIn(const fs::path& folder) {
  if (fs::exists(folder / "transforms.json")) return folder / "transforms.json";
  if (fs::exists(folder / "transforms_train.json"))
    throw InputError(folder.string() +
                     " has photographs in parts (transforms_train.json and so on): give one of "
                     "these files, with the photographs of that part");
  fs::path found;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".xml" || !IsMetashape(ReadTextFile(entry.path()))) continue;
    if (!found.empty())
      throw InputError(folder.string() + " has several files of Metashape; pass one of them");
    found = entry.path();
  }
  return found;
}

/// The program whose cameras these are, where it is one that is not read; else empty.
std::string OtherProgram(const std::string& text) {
  const std::string head = text.substr(0, 4096);
  const auto has = [&head](const char* words) { return head.find(words) != std::string::npos; };
  if (head.starts_with("# Bundle file")) return "Bundler";
  if (head.starts_with("NVM_V3")) return "VisualSFM (NVM)";
  if (head.starts_with("#name,") || head.starts_with("#cameras")) return "RealityCapture";
  if (has("\"sfm_data_version\"")) return "OpenMVG";
  if (has("\"version\"") && (has("\"featuresFolders\"") || has("\"viewId\""))) return "Meshroom";
  const std::size_t first = head.find_first_not_of(" \t\r\n");
  if (first != std::string::npos && head[first] == '[' && has("\"cameras\"")) return "OpenSfM";
  if (has("<BlocksExchange")) return "ContextCapture";
  return "";
}

/// @throws InputError  names the program
void RefuseOthers(const fs::path& path, const std::string& text) {
  const std::string program = OtherProgram(text);
  if (!program.empty())
    throw InputError(path.string() + " has cameras of " + program +
                     ", which are not read; export a COLMAP model from it, or let COLMAP convert "
                     "them, and give that folder");
}

std::vector<LensView> ReadPosesFile(const fs::path& path) {
  RefuseOthers(path, ReadTextFile(path));
  if (path.extension() == ".json") return ReadTransforms(path);
  if (path.extension() == ".xml") {
    const std::string text = ReadTextFile(path);
    if (IsMetashape(text)) return ParseMetashape(text, path.string());
  }
  throw InputError(
      path.string() +
      " is neither a transforms.json, nor Metashape's XML, nor a folder with one or with a "
      "COLMAP model");
}

std::vector<LensView> ReadAnyPoses(const fs::path& path) {
  if (!fs::is_directory(path)) return ReadPosesFile(path);
  if (HasColmapModel(path)) return ReadColmapLenses(path);
  const fs::path inside = FileIn(path);
  return inside.empty() ? ReadColmapLenses(path) : ReadPosesFile(inside);
}

/// A lens of a file that gives an angle but no size has its focal length in widths.
Camera CameraInWidths(const Lens& lens, const std::string& where) {
  if (lens.projection != LensProjection::kPerspective)
    throw InputError(where + " has the lens model " + lens.model +
                     " with an angle alone; give w, h and fl_x");
  if (const std::optional<Camera> camera = CameraOf(lens)) return *camera;
  throw InputError(where + " has k3 or k4 with an angle alone; give w, h and fl_x");
}

}  // namespace

std::vector<LensView> ReadLensPoses(const fs::path& path) {
  std::vector<LensView> views = ReadAnyPoses(path);
  if (views.empty()) throw InputError(path.string() + " holds no camera");
  std::sort(views.begin(), views.end(),
            [](const LensView& a, const LensView& b) { return a.name < b.name; });
  for (std::size_t i = 1; i < views.size(); ++i)
    if (views[i].name == views[i - 1].name)
      throw InputError(path.string() + " has two cameras for " + views[i].name);
  return views;
}

std::vector<View> ReadPoses(const fs::path& path) {
  std::vector<View> views;
  std::optional<Lens> last;  // most files have one lens
  Camera camera;
  for (const LensView& view : ReadLensPoses(path)) {
    const std::string where = path.string() + ", camera of " + view.name;
    if (!last || !(*last == view.lens))
      camera = view.lens.fx < 0 ? CameraInWidths(view.lens, where) : UsableCamera(view.lens, where);
    last = view.lens;
    views.push_back({view.name, camera, view.camera_from_world});
  }
  return views;
}

}  // namespace keypose
