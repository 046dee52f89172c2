#include <algorithm>
#include <cctype>
#include <iterator>
#include <map>
#include <regex>
#include <set>

#include "capture/find_photographs.h"
#include "capture/shoot/develop/photograph.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_kind.h"
#include "core/io/pictures/photograph_files.h"
#include "core/io/text/files.h"
#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "core/values/exif_focal.h"
#include "core/values/file_names.h"

namespace keypose::capture {
namespace fs = std::filesystem;

namespace {

std::uint64_t Fnv1a(const std::string& bytes) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  return hash;
}

Photograph Inspect(const fs::path& file) {
  const ImageInfo info = shoot::ReadPhotographInfo(file);
  const std::string bytes = ReadFile(file);
  Photograph photograph;
  photograph.name = WrittenName(file);
  photograph.width = info.width;
  photograph.height = info.height;
  photograph.digest = Fnv1a(bytes);
  photograph.bytes = bytes.size();
  photograph.camera_model = info.camera_model;
  photograph.focal_px = FocalPx(info.width, info.height, info.focal_35mm.value_or(0),
                                info.focal_mm.value_or(0), info.sensor_width_mm.value_or(0));
  return photograph;
}

/// RAW files of a folder, without those that have a photograph of the same stem beside them.
std::vector<fs::path> RawFilesIn(const fs::path& folder, const std::vector<fs::path>& photographs) {
  std::set<fs::path> stems;
  for (const fs::path& file : photographs) stems.insert(file.stem());
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const fs::path& file = entry.path();
    if (entry.is_regular_file() && IsRawName(file) && !IsLitterName(file) &&
        !stems.contains(file.stem()))
      files.push_back(file);
  }
  return files;
}

/// @param with_raw  RAW files that have no other photograph of their stem beside them count too
std::vector<fs::path> PhotographsIn(const fs::path& folder, bool with_raw) {
  std::vector<fs::path> files = ImagesIn(folder);
  if (with_raw) {
    const std::vector<fs::path> raw = RawFilesIn(folder, files);
    files.insert(files.end(), raw.begin(), raw.end());
  }
  std::sort(files.begin(), files.end());
  std::erase_if(files, IsCleanPlateName);
  return files;
}

/// Of cameras and programs that put the RAW and the JPEG of each shot into two folders, the JPEG
/// counts.
void LeaveOutRawTwins(std::vector<PhotographGroup>* groups) {
  std::set<fs::path> stems;
  for (const PhotographGroup& group : *groups)
    for (const fs::path& file : group.files)
      if (!IsRawName(file)) stems.insert(file.stem());
  std::erase_if(*groups, [&](const PhotographGroup& group) {
    return std::all_of(group.files.begin(), group.files.end(), [&](const fs::path& file) {
      return IsRawName(file) && stems.contains(file.stem());
    });
  });
}

std::vector<PhotographGroup> GroupsBelow(const fs::path& folder, bool with_raw) {
  std::vector<PhotographGroup> groups;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    const bool ours = name == "masks" || name == kFocusStacks || IsLitterName(name);
    if (!entry.is_directory() || ours) continue;
    PhotographGroup group{name, entry.path(), PhotographsIn(entry.path(), with_raw)};
    if (!group.files.empty()) groups.push_back(std::move(group));
  }
  LeaveOutRawTwins(&groups);
  std::sort(groups.begin(), groups.end(),
            [](const auto& a, const auto& b) { return a.name < b.name; });
  return groups;
}

/// The placement that a photograph's name tells: "lying" as its first letters; `keypose shoot`
/// names further ones lying2_r1_a045, lying3_r1_a045.
std::string PlacementOf(const fs::path& file) {
  static const std::regex further("(lying[2-9])_r[0-9]+_a[0-9]+\\..*");
  const std::string name = LowerCase(file.filename().string());
  std::smatch match;
  if (std::regex_match(name, match, further)) return match[1];
  return name.starts_with("lying") ? "lying" : "upright";
}

/// Separates photographs whose names begin with "lying" from the others.
std::vector<PhotographGroup> SplitByName(const fs::path& folder,
                                         const std::vector<fs::path>& files) {
  std::map<std::string, PhotographGroup> by_name;
  for (const fs::path& file : files) {
    PhotographGroup& group = by_name[PlacementOf(file)];
    group.name = PlacementOf(file);
    group.folder = folder;
    group.files.push_back(file);
  }
  if (by_name.size() < 2) return {{"", folder, files}};
  std::vector<PhotographGroup> groups;
  for (auto& [name, group] : by_name) groups.push_back(std::move(group));
  return groups;
}

/// Names must be UTF-8, because capture.json and reports contain them.
void RequireNamesInUtf8(const std::vector<PhotographGroup>& groups) {
  std::vector<std::string> odd;
  for (const PhotographGroup& group : groups) {
    if (!IsValidUtf8(group.name)) odd.push_back(PrintableName(group.name));
    for (const fs::path& file : group.files)
      if (!IsValidUtf8(file.filename().string())) odd.push_back(PrintableName(file));
  }
  if (!odd.empty())
    throw InputError("capture: these names are not in UTF-8: " + JoinNames(odd) +
                     "; rename them (another system wrote them in its own encoding)");
}

/// Two photographs of one name after HEIC became JPEG: a phone or a program wrote both.
void RequireDifferentNames(const std::vector<Photograph>& photographs) {
  std::set<std::string> names;
  for (const Photograph& photograph : photographs) {
    if (names.insert(photograph.name).second) continue;
    throw InputError("capture: " + photograph.name +
                     " is there twice, as HEIC and as JPEG, or as JFIF and as JPEG; leave one of "
                     "the two kinds out");
  }
}

/// Adds files of the folder that are not photographs, masks or the clean plate, and files of those
/// subfolders that contain no photographs.
void AddIgnored(const fs::path& folder, bool with_subfolders, std::vector<fs::path>* ignored) {
  const fs::path plate = FindBackground(folder);
  std::set<fs::path> stems;
  for (const fs::path& file : ImagesIn(folder)) stems.insert(file.stem());
  for (const auto& entry : fs::directory_iterator(folder)) {
    const fs::path name = entry.path().filename();
    // What `keypose shoot` puts beside the photographs: its notes, and RAW files of the same names.
    const bool shot = name == kShootNotes || name == kFocusStacks ||
                      (IsRawName(name) && stems.contains(name.stem()));
    if (IsLitterName(name) || name == "masks" || shot || entry.path() == plate) continue;
    if (entry.is_regular_file() && !IsPhotographName(entry.path()))
      ignored->push_back(entry.path());
    // A link to a parent folder would cause endless recursion.
    if (with_subfolders && entry.is_directory() && !entry.is_symlink() &&
        PhotographsIn(entry.path(), false).empty())
      AddIgnored(entry.path(), true, ignored);
  }
}

/// Reports why no photographs were found, and what to do.
[[noreturn]] void FailForWantOfPhotographs(const fs::path& folder) {
  const std::vector<fs::path> others = IgnoredFiles(folder, {});
  const std::string start = "capture: " + folder.string() + " has no photographs (" +
                            kReadablePhotographs + "; RAW: " + kReadableRaw + ")";
  if (others.empty()) throw InputError(start + "; check the folder's path");
  const std::string cure = CureFor(others);
  throw InputError(start + "; there are " + KindsOf(others) + "; " +
                   (cure.empty() ? "check the folder's path" : cure));
}

}  // namespace

std::vector<fs::path> ImagesIn(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_regular_file() && IsPhotographName(entry.path()) && !IsLitterName(entry.path()))
      files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<fs::path> IgnoredFiles(const fs::path& folder,
                                   const std::vector<PhotographGroup>& groups) {
  std::vector<fs::path> ignored;
  AddIgnored(folder, true, &ignored);
  for (const PhotographGroup& group : groups)
    if (group.folder != folder) AddIgnored(group.folder, false, &ignored);
  for (const PhotographGroup& group : groups)
    for (const fs::path& file : group.files) std::erase(ignored, file);  // RAW files that are used
  std::sort(ignored.begin(), ignored.end());
  return ignored;
}

std::vector<PhotographGroup> ListPhotographs(const fs::path& folder) {
  const std::vector<fs::path> files = PhotographsIn(folder, true);
  // A subfolder of RAW files beside photographs is a store, and no placement of the figure.
  const std::vector<PhotographGroup> below = GroupsBelow(folder, files.empty());
  if (files.empty() && below.empty()) FailForWantOfPhotographs(folder);
  if (!files.empty() && !below.empty())
    throw InputError("capture: " + folder.string() + " has photographs of its own (" +
                     files.front().filename().string() + ") and in its subfolder " +
                     below.front().name +
                     "; put those of each placement of the figure in a subfolder (upright, lying), "
                     "or all in one folder");
  return below.empty() ? SplitByName(folder, files) : below;
}

fs::path FindBackground(const fs::path& folder) {
  const std::vector<fs::path> files = ImagesIn(folder);
  for (const fs::path& file : files)
    if (IsCleanPlateName(file)) return file;
  if (!files.empty()) return {};
  for (const fs::path& file : RawFilesIn(folder, {}))
    if (IsCleanPlateName(file)) return file;
  return {};
}

namespace {

/// Where some photographs cannot be read, those too that only decoding would find: all are mended
/// in one go. Without a fault no file is read twice.
void AddCutOff(const std::vector<std::pair<const PhotographGroup*, fs::path>>& files,
               std::vector<std::string>* faults, std::vector<std::string>* reasons) {
  if (std::all_of(faults->begin(), faults->end(), [](const auto& fault) { return fault.empty(); }))
    return;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const fs::path& file = files[i].second;
    if (!(*faults)[i].empty() || !IsPhotographName(file)) continue;
    const std::string fault = PhotographFault(ReadFile(file));
    if (fault.empty()) continue;
    (*faults)[i] = file.filename().string();
    (*reasons)[i] = file.string() + " " + fault;
  }
}

}  // namespace

std::vector<Photograph> InspectPhotographs(const std::vector<PhotographGroup>& groups) {
  std::vector<std::pair<const PhotographGroup*, fs::path>> files;
  for (const PhotographGroup& group : groups)
    for (const fs::path& file : group.files) files.emplace_back(&group, file);
  RequireNamesInUtf8(groups);
  const bool in_subfolders = groups.size() > 1 && groups[0].folder != groups[1].folder;
  std::vector<Photograph> photographs(files.size());
  std::vector<std::string> faults(files.size()), reasons(files.size());
  ParallelFor(std::ssize(files), [&](std::int64_t k) {
    const auto i = static_cast<std::size_t>(k);
    const auto& [group, file] = files[i];
    try {
      photographs[i] = Inspect(file);
      photographs[i].group = group->name;
      if (in_subfolders) photographs[i].name = group->name + "_" + photographs[i].name;
    } catch (const InputError& error) {
      faults[i] = file.filename().string();
      reasons[i] = error.what();
    }
  });
  AddCutOff(files, &faults, &reasons);
  std::erase(faults, "");
  std::erase(reasons, "");
  if (faults.size() == 1) throw InputError("capture: " + reasons[0]);
  if (!faults.empty())
    throw InputError(
        "capture: " + std::to_string(faults.size()) + " of " + std::to_string(files.size()) +
        " photographs cannot be read: " + JoinNames(faults) +
        "; copy them from the camera again, or leave them out. The first: " + reasons[0]);
  RequireDifferentNames(photographs);
  return photographs;
}

namespace {

std::string Folded(std::string name) {
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return name;
}

}  // namespace

bool IsMaskOf(const fs::path& file, const std::string& photograph_name) {
  const std::string stem = Folded(fs::path(photograph_name).stem().string()),
                    name = Folded(photograph_name);
  std::string mask = Folded(file.stem().string());
  for (const std::string prefix : {"mask_", "mask-"})
    if (mask.starts_with(prefix) && !stem.starts_with(prefix)) mask.erase(0, prefix.size());
  const auto is = [&](const std::string& ending) {
    return mask == stem + ending || mask == name + ending;
  };
  if (is("")) return true;
  for (const char separator : {'_', '-', '.'})
    for (const std::string word :
         {"mask", "masks", "matte", "alpha", "cutout", "out", "seg", "silhouette"})
      if (is(separator + word)) return true;
  return false;
}

fs::path FindMask(const fs::path& folder, const std::string& photograph_name) {
  // A mask by the plain name belongs to no other photograph: a.jpg beside a_out.jpg.
  const fs::path stem = fs::path(photograph_name).stem();
  fs::path found;
  for (const fs::path& file : ImagesIn(folder)) {
    if (file.stem() == stem || file.stem() == photograph_name) return file;
    if (found.empty() && IsMaskOf(file, photograph_name)) found = file;
  }
  return found;
}

}  // namespace keypose::capture
