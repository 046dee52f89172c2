// Masks of photographs by the network of capture/salience alone, for tables.
//
//   salience_masks PHOTOS OUT
//
// Writes OUT/NAME.png for each photograph NAME: 255 where the network thinks that the figure is at
// least as likely as not.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "capture/salience/salience_network.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/photograph_files.h"
#include "core/values/errors.h"

namespace keypose::bench {
namespace {
namespace fs = std::filesystem;

std::vector<std::string> NamesIn(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_regular_file() && IsPhotographName(entry.path()))
      names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

int Run(const std::vector<std::string>& arguments) {
  if (arguments.size() != 2) throw UsageError("salience_masks PHOTOS OUT");
  const fs::path photos = arguments[0], out = arguments[1];
  if (!fs::is_directory(photos)) throw InputError(photos.string() + " is no folder");
  const auto file = capture::FindSalienceNetwork();
  if (!file) throw InputError(capture::kNoSalience);
  const auto network = capture::SalienceNetwork::Open(*file);
  fs::create_directories(out);
  for (const std::string& name : NamesIn(photos)) {
    Image8 mask = network->Of(ReadImage(photos / name, 3));
    for (std::uint8_t& value : mask.data) value = value > 127 ? 255 : 0;
    WriteImage(out / (name + ".png"), mask);
  }
  return 0;
}

}  // namespace
}  // namespace keypose::bench

int main(int argc, char** argv) {
  try {
    return keypose::bench::Run({argv + 1, argv + argc});
  } catch (const keypose::Error& error) {
    std::fprintf(stderr, "salience_masks: %s\n", error.what());
    return static_cast<int>(error.code());
  }
}
