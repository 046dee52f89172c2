// keypose-capture on photographs in a folder of the test.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>

#include "capture/testing/test_images.h"
#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"

namespace keypose::capture {

namespace fs = std::filesystem;

struct Outcome {
  int code = -1;
  std::string output;
};

class CaptureProgram : public testing::Test, public TestingFolder {
 protected:
  void SetUp() override { fs::create_directories(photos); }

  void WritePhotos(int count, int width = 180, int height = 120,
                   const ExifToWrite* exif = nullptr) {
    for (int i = 0; i < count; ++i)
      WriteImage(photos / ("p" + std::to_string(10 + i) + ".jpg"),
                 MakeTestPhoto(i, width, height, TestWall::kDark).image, 95, exif);
  }

  /// @param first  shell commands to run before, such as limits
  Outcome Run(const std::string& more = "", const std::string& first = "") const {
    const fs::path log = root / "log.txt";
    const std::string command = first + BinFolder() + "/keypose-capture --photos " +
                                photos.string() + " --images " + images.string() + " --report " +
                                (root / "report.json").string() + " " + more + " > " +
                                log.string() + " 2>&1";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, ReadFile(log)};
  }
  /// With a true mask for each JPEG in the folder: for what is not about finding the figure, which
  /// then need not be found.
  Outcome RunMasked(const std::string& more = "", const std::string& first = "") const {
    const fs::path masks = root / "true_masks";
    fs::create_directories(masks);
    std::set<fs::path> names;
    for (const fs::directory_entry& entry : fs::directory_iterator(photos))
      if (entry.path().extension() == ".jpg" && !entry.is_symlink()) names.insert(entry.path());
    int index = 0;
    for (const fs::path& name : names) {
      const ImageInfo info = ReadImageInfo(name);
      WriteImage(masks / (name.filename().string() + ".png"),
                 MakeTestPhoto(index++, info.width, info.height, TestWall::kDark).truth);
    }
    return Run("--masks " + masks.string() + " " + more, first);
  }
  std::string Report() const { return ReadFile(root / "report.json"); }

  const fs::path root = path(), photos = root / "photos", images = root / "images";
};

}  // namespace keypose::capture
