#include <algorithm>
#include <cctype>

#include "capture/photographs.h"
#include "core/errors.h"
#include "core/io/files.h"
#include "core/io/image_io.h"
#include "core/parallel.h"

namespace keypose::capture {
namespace fs = std::filesystem;

namespace {

std::string Lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

bool LooksLikeImage(const fs::path& path) {
  const std::string extension = Lower(path.extension().string());
  return extension == ".jpg" || extension == ".jpeg" || extension == ".png" || extension == ".tif" || extension == ".tiff";
}

std::uint64_t Fnv1a(const std::string& bytes) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  return hash;
}

std::vector<fs::path> ImagesIn(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_regular_file() && LooksLikeImage(entry.path()) && entry.path().filename().string().front() != '.')
      files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

Photograph Inspect(const fs::path& file) {
  const ImageInfo info = ReadImageInfo(file);
  const std::string bytes = ReadFile(file);
  Photograph photograph;
  photograph.name = file.filename().string();
  photograph.width = info.width;
  photograph.height = info.height;
  photograph.digest = Fnv1a(bytes);
  photograph.bytes = bytes.size();
  photograph.camera_model = info.camera_model;
  photograph.focal_px =
      FocalPx(info.width, info.height, info.focal_35mm.value_or(0), info.focal_mm.value_or(0), info.sensor_width_mm.value_or(0));
  return photograph;
}

}  // namespace

std::vector<fs::path> ListPhotographs(const fs::path& folder) {
  std::vector<fs::path> files = ImagesIn(folder);
  std::erase_if(files, [](const fs::path& file) { return Lower(file.stem().string()) == "background"; });
  if (files.empty())
    throw InputError("capture: " + folder.string() + " has no photographs (.jpg, .jpeg, .png, .tif, .tiff); check the folder's path");
  return files;
}

fs::path FindBackground(const fs::path& folder) {
  for (const fs::path& file : ImagesIn(folder))
    if (Lower(file.stem().string()) == "background") return file;
  return {};
}

std::vector<Photograph> InspectPhotographs(const std::vector<fs::path>& files) {
  std::vector<Photograph> photographs(files.size());
  std::vector<std::string> faults(files.size());
  ParallelFor(static_cast<std::int64_t>(files.size()), [&](std::int64_t k) {
    const auto i = static_cast<std::size_t>(k);
    try {
      photographs[i] = Inspect(files[i]);
    } catch (const InputError& error) {
      faults[i] = files[i].filename().string();
    }
  });
  std::erase(faults, "");
  if (!faults.empty())
    throw InputError("capture: " + std::to_string(faults.size()) + " of " + std::to_string(files.size()) +
                     " photographs cannot be read (truncated, or not images): " + JoinNames(faults) +
                     "; copy them from the camera again, or leave them out");
  return photographs;
}

fs::path FindMask(const fs::path& folder, const std::string& photograph_name) {
  const std::string stem = fs::path(photograph_name).stem().string();
  for (const fs::path& file : ImagesIn(folder)) {
    const std::string mask = file.stem().string();
    if (mask == stem || mask == photograph_name || mask == stem + "_mask") return file;
  }
  return {};
}

}  // namespace keypose::capture
