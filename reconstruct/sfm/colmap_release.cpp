#include "reconstruct/sfm/colmap_release.h"

#include <regex>

#include "core/values/errors.h"

namespace keypose::reconstruct {
namespace {

/// An option that got another name.
struct Renamed {
  const char* before;
  const char* now;
  ColmapRelease since;
};

constexpr ColmapRelease kOldest{3, 7};

/// Cameras on rigs came with 3.12, features of several kinds with 3.13.
constexpr Renamed kRenamed[] = {
    {"--Mapper.fix_existing_images", "--Mapper.fix_existing_frames", {3, 12}},
    {"--Mapper.ba_global_images_ratio", "--Mapper.ba_global_frames_ratio", {3, 12}},
    {"--SiftExtraction.use_gpu", "--FeatureExtraction.use_gpu", {3, 13}},
    {"--SiftExtraction.num_threads", "--FeatureExtraction.num_threads", {3, 13}},
    {"--SiftExtraction.max_image_size", "--FeatureExtraction.max_image_size", {4, 0}},
};

}  // namespace

ColmapRelease ParseColmapRelease(const std::string& line) {
  static const std::regex pattern(R"(COLMAP\s+v?(\d{1,4})\.(\d{1,4}))");
  std::smatch found;
  if (!std::regex_search(line, found, pattern))
    throw ToolError(
        "the installed COLMAP does not say its release; the first line of its help is: " + line);
  const ColmapRelease release{std::stoi(found[1]), std::stoi(found[2])};
  if (release < kOldest)
    throw ToolError("COLMAP " + found[1].str() + "." + found[2].str() +
                    " is too old; install 3.8 or a later one");
  return release;
}

std::vector<std::string> ArgumentsFor(const ColmapRelease& release,
                                      std::vector<std::string> arguments) {
  for (std::string& argument : arguments)
    for (const Renamed& option : kRenamed)
      if (release >= option.since && argument == option.before) argument = option.now;
  return arguments;
}

}  // namespace keypose::reconstruct
