#include "synth/photographs/fresh_folder.h"

#include <algorithm>
#include <string>
#include <vector>

#include "core/io/pictures/photograph_files.h"
#include "core/values/errors.h"

namespace keypose::synth {
namespace {

namespace fs = std::filesystem;

/// IMG_0001.jpg, LYING_0001.jpg, their masks IMG_0001.jpg.png, and 0001.png.
bool IsNumbered(const fs::path& file) {
  std::string name = file.filename().string();
  name = name.substr(0, name.find('.'));
  for (const std::string prefix : {"IMG_", "LYING_"})
    if (name.starts_with(prefix)) name = name.substr(prefix.size());
  return name.size() >= 4 && std::all_of(name.begin(), name.end(),
                                         [](unsigned char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

void MakeFreshFolder(const fs::path& folder, const fs::path& made_here) {
  std::error_code error;
  fs::create_directories(folder, error);
  std::vector<fs::path> pictures;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (entry.is_regular_file(error) && IsPhotographName(entry.path()))
      pictures.push_back(entry.path());
  if (!pictures.empty() && !fs::is_directory(made_here))
    throw UsageError("synth: " + folder.string() +
                     " has pictures that synth did not make, such as " +
                     pictures.front().filename().string() + "; give another --output");
  for (const fs::path& picture : pictures)
    if (IsNumbered(picture) && !error) fs::remove(picture, error);
  if (error)
    throw DiskError("synth: cannot make the folder " + folder.string() + ": " + error.message());
}

}  // namespace keypose::synth
