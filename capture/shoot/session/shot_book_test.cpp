#include "capture/shoot/session/shot_book.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::capture::shoot::shot_book_test {

namespace fs = std::filesystem;

class Book : public ::testing::Test, public TestingFolder {
 protected:
  ShotBook Open(const ShotPlan& plan, bool given = true) const {
    return ShotBook(folder_ / "photos", "rest", plan, given);
  }
  /// A file in the incoming folder, as a camera gives it.
  Exposure Incoming(ShotBook& book, const std::vector<std::string>& names, int shade) const {
    Exposure exposure;
    const fs::path into = book.store().Incoming();
    for (const std::string& name : names) {
      exposure.files.push_back(into / name);
      WriteImage(into / "picture.jpg", Image8(64, 48, 3, static_cast<std::uint8_t>(shade)));
      fs::rename(into / "picture.jpg", into / name);
    }
    return exposure;
  }
  void Shoot(ShotBook& book, const Shot& shot, int shade = 100) const {
    book.store().Add(book.Name(shot), Incoming(book, {"DSC1.JPG"}, shade), 978307200 + shot.index);
    book.Enter(shot);
    book.Save();
  }
  std::vector<std::string> Files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_ / "photos"))
      names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  }
};

const ShotPlan kPlan{.rings_deg = {12}, .angles = 3};
using Names = std::vector<std::string>;

TEST_F(Book, ShootsInOrderAndChecksARingAtItsEnd) {
  ShotBook book = Open({.rings_deg = {12, 40}, .angles = 3});
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(book.Next().shot, (Shot{0, 1, i}));
    Shoot(book, {0, 1, i});
  }
  EXPECT_EQ(book.Next().kind, NextThing::Kind::kCheckRing);
  EXPECT_EQ(book.Next().shot, (Shot{0, 1, 0}));
  book.CheckRing({0, 1, 0}, 0.0);
  EXPECT_EQ(book.Next().shot, (Shot{0, 2, 0}));
  book.Skip({0, 2, 0});
  EXPECT_EQ(book.Next().shot, (Shot{0, 2, 1}));
}

TEST_F(Book, GoesOnWhereItWas) {
  {
    ShotBook book = Open(kPlan);
    EXPECT_FALSE(book.resumed());
    Shoot(book, {0, 1, 0});
    book.Skip({0, 1, 1});
    book.Save();
  }
  ShotBook book = Open({}, false);  // without flags its own plan goes on
  EXPECT_TRUE(book.resumed());
  EXPECT_EQ(book.side().plan, kPlan);
  EXPECT_EQ(book.Next().shot, (Shot{0, 1, 2}));
}

TEST_F(Book, TakesUpWhatLandedWithoutAnEntryAndDropsWhatIsGone) {
  {
    ShotBook book = Open(kPlan);
    for (int i = 0; i < 2; ++i) Shoot(book, {0, 1, i});
    book.store().Add("r1_a240", Incoming(book, {"DSC2.JPG"}, 90), 978307200);
  }
  fs::remove(folder_ / "photos/r1_a120.jpg");
  ShotBook book = Open(kPlan);
  EXPECT_TRUE(book.Has({0, 1, 2}));
  EXPECT_EQ(book.side().photographs.at({0, 1, 2}).width, 64);
  EXPECT_EQ(book.side().photographs.at({0, 1, 2}).time, 978307200);
  EXPECT_EQ(book.Next().shot, (Shot{0, 1, 1}));
}

TEST_F(Book, MeasuresAFileAnewThatWasReplacedBeforeItsEntryWasWritten) {
  {
    ShotBook book = Open(kPlan);
    Shoot(book, {0, 1, 0}, 100);
    book.store().Add("r1_a000", Incoming(book, {"DSC2.JPG"}, 200), 978307999);
  }
  EXPECT_NEAR(Open(kPlan).side().photographs.at({0, 1, 0}).exposure, 200, 1);
}

TEST_F(Book, MayBeGivenFurtherRingsButNoOtherAngles) {
  {
    ShotBook book = Open(kPlan);
    Shoot(book, {0, 1, 0});
  }
  EXPECT_EQ(Open({.rings_deg = {12, 40}, .angles = 3}).Total(), 6);
  EXPECT_THROW(Open({.rings_deg = {12}, .angles = 4}), InputError);
  EXPECT_THROW(Open({.rings_deg = {20}, .angles = 3}), InputError);
}

TEST_F(Book, ChecksARingAgainWhoseFirstAngleWasShotAgain) {
  ShotBook book = Open({.rings_deg = {12}, .angles = 3});
  for (int i = 0; i < 3; ++i) Shoot(book, {0, 1, i});
  book.CheckRing({0, 1, 0}, 0.0);
  EXPECT_TRUE(book.Complete());
  book.ForgetRing({0, 1, 1});
  EXPECT_TRUE(book.Complete());
  book.ForgetRing({0, 1, 0});
  EXPECT_FALSE(book.Complete());
}

TEST_F(Book, NamesAFileThatCannotBeRead) {
  ShotBook book = Open(kPlan);
  Shoot(book, {0, 1, 0});
  const std::string bytes = ReadFile(folder_ / "photos/r1_a000.jpg");
  WriteFile(folder_ / "photos/r1_a000.jpg", bytes.substr(0, bytes.size() / 2));
  book.Enter({0, 1, 0});
  EXPECT_EQ(book.side().photographs.at({0, 1, 0}).findings.at(0).code, "unreadable");
}

TEST_F(Book, LandsARawAndJpegPairUnderOneNameAndReplacesBoth) {
  ShotBook book = Open(kPlan);
  book.store().Add("r1_a000", Incoming(book, {"A.JPEG", "A.CR2"}, 80), 978307200);
  EXPECT_EQ(book.store().FileOf("r1_a000").filename(), "r1_a000.jpg");
  EXPECT_EQ(book.store().RawOf("r1_a000").filename(), "r1_a000.cr2");
  book.Enter({0, 1, 0});
  EXPECT_EQ(book.side().photographs.at({0, 1, 0}).raw, "r1_a000.cr2");
  Shoot(book, {0, 1, 0});
  EXPECT_EQ(Files(), (Names{".incoming", "r1_a000.jpg", "shoot.json"}));
  EXPECT_THROW(book.store().Add("r1_a120", Incoming(book, {"A.jpg", "B.JPG"}, 80), 0), InputError);
}

TEST_F(Book, KeepsAStacksPhotographsBesideTheMergedOne) {
  ShotBook book = Open(kPlan);
  const Exposure all = Incoming(book, {"F1.JPG", "F2.JPG", "merged.jpg"}, 80);
  book.store().AddStack("r1_a000", {{{all.files[0]}, {}}, {{all.files[1]}, {}}}, all.files[2],
                        978307200);
  EXPECT_EQ(Files(), (Names{".incoming", "r1_a000.jpg", "stacks"}));
  EXPECT_TRUE(fs::exists(folder_ / "photos/stacks/r1_a000_f2.jpg"));
}

}  // namespace keypose::capture::shoot::shot_book_test
