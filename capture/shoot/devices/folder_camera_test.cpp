#include "capture/shoot/devices/folder_camera.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/shoot/devices/patience.h"
#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"

namespace keypose::capture::shoot::folder_camera_test {

namespace fs = std::filesystem;
using ::testing::ElementsAre;

std::string Jpeg(int level) {
  const TestingFolder folder;
  WriteImage(folder.path() / "a.jpg", Image8(64, 48, 3, static_cast<std::uint8_t>(level)));
  return ReadFile(folder.path() / "a.jpg");
}

/// Time that passes only while somebody waits: no test depends on the machine's speed.
class CountedPatience final : public Patience {
 public:
  void Wait(double seconds) override { now_ += seconds; }
  double Now() const override { return now_; }

 private:
  double now_ = 0;
};

class FolderCamera : public ::testing::Test, public TestingFolder {
 protected:
  void SetUp() override {
    fs::create_directories(folder);
    fs::create_directories(into);
  }
  void Connect() { camera->Connect(patience); }
  void Put(const std::string& name, const std::string& bytes) const {
    WriteFile(folder / name, bytes);
  }
  /// Names of the files that arrive within a time, photograph by photograph, and the levels of
  /// JPEGs.
  std::vector<std::vector<std::string>> Arrivals(double seconds) {
    std::vector<std::vector<std::string>> arrivals;
    const double until = patience.Now() + seconds;
    while (patience.Now() < until) {
      if (const auto exposure = camera->Arrived(into, patience)) {
        arrivals.emplace_back();
        for (const fs::path& file : exposure->files) {
          arrivals.back().push_back(file.filename().string());
          if (file.extension() == ".jpg" && file.stem() != "damaged")
            levels.push_back(ReadImage(file, 1).data[0]);
        }
      }
      patience.Wait(0.01);
    }
    return arrivals;
  }

  const fs::path folder = path() / "tether", into = path() / "taken";
  CountedPatience patience;
  std::unique_ptr<CameraDevice> camera =
      MakeFolderCamera(folder, {.still_s = 0.1, .pair_s = 0.2, .unfinished_s = 1});
  std::vector<int> levels;
};

using FileNames = std::vector<std::string>;

TEST_F(FolderCamera, AFileThatIsReplacedUnderItsNameIsANewPhotograph) {
  Put("capt0000.jpg", Jpeg(10));
  Connect();
  for (const int level : {60, 120, 180}) {
    Put("capt0000.jpg", Jpeg(level));
    EXPECT_THAT(Arrivals(0.4), ElementsAre(FileNames{"capt0000.jpg"})) << level;
  }
  EXPECT_THAT(levels, ElementsAre(60, 120, 180));
}

TEST_F(FolderCamera, AFileThatIsTouchedIsNone) {
  Connect();
  Put("a.jpg", Jpeg(60));
  EXPECT_THAT(Arrivals(0.4), ElementsAre(FileNames{"a.jpg"}));
  fs::last_write_time(folder / "a.jpg", fs::file_time_type::clock::now() + std::chrono::hours(1));
  EXPECT_THAT(Arrivals(0.4), ElementsAre());
  Put("a.jpg", Jpeg(60));
  EXPECT_THAT(Arrivals(0.4), ElementsAre()) << "the same bytes again";
}

TEST_F(FolderCamera, ThatIsWrittenWithAPauseIsTakenWhole) {
  Connect();
  const std::string bytes = Jpeg(60);
  Put("a.jpg", bytes.substr(0, bytes.size() / 2));
  EXPECT_THAT(Arrivals(0.4), ElementsAre()) << "it ends in the middle";
  Put("a.jpg", bytes);
  EXPECT_THAT(Arrivals(0.4), ElementsAre(FileNames{"a.jpg"}));
  Put("damaged.jpg", bytes.substr(0, bytes.size() / 2));
  EXPECT_THAT(Arrivals(1.5), ElementsAre(FileNames{"damaged.jpg"}))
      << "later checks say what is wrong with it";
}

TEST_F(FolderCamera, TheSecondFileOfAPairMayComeLate) {
  Connect();
  Put("IMG_1.CR2", "raw");
  EXPECT_THAT(Arrivals(0.3), ElementsAre(FileNames{"IMG_1.CR2"}));
  Put("IMG_1.jpg", Jpeg(60));
  EXPECT_THAT(Arrivals(0.5), ElementsAre()) << "the photograph was taken";
  // Now it is known that they come apart.
  Put("IMG_2.CR2", "raw");
  EXPECT_THAT(Arrivals(0.3), ElementsAre());
  Put("IMG_2.jpg", Jpeg(90));
  EXPECT_THAT(Arrivals(0.6), ElementsAre(FileNames{"IMG_2.CR2", "IMG_2.jpg"}));
}

}  // namespace keypose::capture::shoot::folder_camera_test
