#include "core/io/pictures/photograph_files.h"
#include "core/io/pictures/film_kind.h"
#include "core/values/file_names.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <map>

namespace keypose {
namespace fs = std::filesystem;

namespace {

template <std::size_t N>
bool IsOneOf(const std::string& extension, const std::array<const char*, N>& known) {
  return std::find(known.begin(), known.end(), extension) != known.end();
}

constexpr std::array<const char*, 3> kHeic = {".heic", ".heif", ".hif"};
constexpr std::array<const char*, 6> kPlain = {".jpg", ".jpeg", ".jfif", ".png", ".tif", ".tiff"};
constexpr std::array<const char*, 8> kRaw = {".cr2", ".cr3", ".nef", ".arw",
                                             ".dng", ".raf", ".orf", ".rw2"};
constexpr std::array kOtherRaw = {".raw", ".crw", ".nrw", ".pef", ".srw", ".x3f", ".3fr",
                                  ".iiq", ".erf", ".mrw", ".rwl", ".kdc", ".dcr", ".srf",
                                  ".sr2", ".mef", ".mos", ".gpr", ".fff"};
constexpr std::array kOtherPictures = {".webp", ".avif", ".bmp", ".gif", ".psd",  ".ppm",
                                       ".pgm",  ".pbm",  ".pnm", ".jxl", ".jp2",  ".j2k",
                                       ".tga",  ".exr",  ".hdr", ".jpe", ".apng", ".mpo",
                                       ".jxr",  ".dib",  ".sgi", ".dpx", ".xcf",  ".qoi"};

// Also those that are not read: they are refused by what they are, not taken for photographs.
constexpr std::array<const char*, 28> kMeshes = {
    ".obj",  ".ply",  ".off", ".stl", ".glb", ".gltf", ".fbx",   ".dae", ".usd", ".usda",
    ".usdc", ".usdz", ".abc", ".zip", ".x3d", ".wrl",  ".blend", ".3ds", ".3mf", ".drc",
    ".ma",   ".mb",   ".max", ".c4d", ".lwo", ".ztl",  ".3dm",   ".step"};
constexpr std::array<const char*, 33> kOtherScans = {
    ".stp", ".iges",  ".igs",    ".amf", ".las", ".laz", ".msh", ".mesh", ".pcd", ".vtk", ".vtp",
    ".vtu", ".xyz",   ".pts",    ".ptx", ".asc", ".csv", ".e57", ".dxf",  ".skp", ".ctm", ".zpr",
    ".spz", ".splat", ".ksplat", ".sog", ".x",   ".pmx", ".pmd", ".u3d",  ".kmz", ".zae", ".model"};
constexpr std::array<const char*, 6> kReadMeshes = {".obj", ".ply", ".off",
                                                    ".stl", ".glb", ".gltf"};

}  // namespace

bool IsMeshName(const fs::path& file) {
  const std::string ending = LowerExtension(file);
  return IsOneOf(ending, kMeshes) || IsOneOf(ending, kOtherScans);
}
bool IsReadableMeshName(const fs::path& file) { return IsOneOf(LowerExtension(file), kReadMeshes); }
bool IsHeicName(const fs::path& file) { return IsOneOf(LowerExtension(file), kHeic); }
bool IsRawName(const fs::path& file) { return IsOneOf(LowerExtension(file), kRaw); }
bool IsPhotographName(const fs::path& file) {
  return IsHeicName(file) || IsOneOf(LowerExtension(file), kPlain);
}

std::string WrittenName(const fs::path& file) {
  const bool other = IsHeicName(file) || IsRawName(file) || LowerExtension(file) == ".jfif";
  return other ? file.stem().string() + ".jpg" : file.filename().string();
}

bool IsLitterName(const fs::path& file) {
  const std::string name = file.filename().string();
  return name.starts_with('.') || name == "Thumbs.db" || name == "desktop.ini" ||
         name == "@eaDir" || name == "__MACOSX";
}

bool IsCleanPlateName(const fs::path& file) {
  return LowerCase(file.stem().string()) == "background";
}

bool IsShotName(const fs::path& file) {
  if (!IsPhotographName(file) && !IsRawName(file)) return false;
  const bool aside = std::any_of(file.begin(), file.end(), [](const fs::path& part) {
    return IsLitterName(part) || part == kFocusStacks || part == "masks";
  });
  const bool deep = std::distance(file.begin(), file.end()) > 2;
  return !aside && !deep && !IsCleanPlateName(file);
}

std::string KindsOf(const std::vector<fs::path>& files) {
  constexpr std::size_t kNamed = 2;
  std::map<std::string, std::vector<std::string>> kinds;
  for (const fs::path& file : files)
    kinds[LowerExtension(file)].push_back(file.filename().string());
  std::string text;
  for (auto& [kind, names] : kinds) {
    std::sort(names.begin(), names.end());
    text += text.empty() ? "" : ", ";
    text += std::to_string(names.size()) + " " + (kind.empty() ? "without an extension" : kind) +
            " (" + names[0];
    for (std::size_t i = 1; i < std::min(names.size(), kNamed); ++i) text += ", " + names[i];
    text += names.size() > kNamed ? " ...)" : ")";
  }
  return text;
}

std::string CureFor(const std::vector<fs::path>& files) {
  const auto some = [&](const auto& known) {
    return std::any_of(files.begin(), files.end(),
                       [&](const fs::path& file) { return IsOneOf(LowerExtension(file), known); });
  };
  std::string cure;
  const auto add = [&](const std::string& text) { cure += (cure.empty() ? "" : "; ") + text; };
  if (some(kRaw) || some(kOtherRaw))
    add("develop RAW files to JPEG or TIFF in the camera's program, all with the same settings");
  const bool film = std::any_of(files.begin(), files.end(), [](const fs::path& file) {
    return IsFilmName(file) && !IsOneOf(LowerExtension(file), kOtherPictures);
  });
  if (film)
    add("take photographs rather than a film, or save its sharpest pictures as JPEG, as in "
        "`ffmpeg -i FILM -vf fps=2 -q:v 1 %04d.jpg`");
  if (some(kOtherPictures))
    add("save pictures of other formats as JPEG or PNG, in any picture program or with "
        "ImageMagick's `mogrify -format png FILES`");
  if (some(kMeshes)) add(kHowToNameMeshes);
  return cure;
}

}  // namespace keypose
