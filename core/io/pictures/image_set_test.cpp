#include "core/io/pictures/image_set.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "core/io/testing/damaged_file.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::image_set_test {

namespace fs = std::filesystem;

using HostileImageSet = HostileFile;

TEST_F(HostileImageSet, NamesThatLeadOutsideOfTheFolderAreRefused) {
  const fs::path images = folder_ / "images";
  fs::create_directories(images / "masks");
  Put("secret.jpg", "x");
  WriteFile(images / "a.jpg", "x");
  WriteFile(images / "masks" / "a.jpg.png", "x");
  fs::create_symlink("../secret.jpg", images / "link.jpg");
  fs::create_symlink("..", images / "way");
  const auto read = [&](const std::string& name, const std::string& mask) {
    WriteFile(images / "capture.json", R"({"images":[{"name":")" + name + R"(","mask":")" + mask +
                                           R"(","width":4,"height":3}]})");
    return ReadImageSet(images);
  };
  EXPECT_EQ(read("a.jpg", "masks/a.jpg.png").images.size(), 1u);
  EXPECT_EQ(read("a.jpg", "").images.size(), 1u);
  for (const std::string bad :
       {"../secret.jpg", "/etc/passwd", "masks/../../secret.jpg", "masks/a.jpg.png", "..", ".", "",
        "link.jpg", "way/secret.jpg", "a.jpg\\u0000b"})
    EXPECT_TRUE(Says(Message<InputError>("capture.json", [&] { read(bad, ""); }), "photograph"))
        << bad;
  for (const std::string bad : {"../secret.jpg", "/etc/passwd", "masks/../../secret.jpg",
                                "link.jpg", "way/secret.jpg", "."})
    EXPECT_TRUE(Says(Message<InputError>("capture.json", [&] { read("a.jpg", bad); }), "mask"))
        << bad;
}

TEST_F(HostileImageSet, SizesThatCannotBeAndNamesTwiceAreRefused) {
  WriteFile(folder_ / "a.jpg", "x");
  const auto refuse = [&](const std::string& images) {
    WriteFile(folder_ / "capture.json", R"({"images":[)" + images + "]}");
    return Message<InputError>("capture.json", [&] { ReadImageSet(folder_); });
  };
  refuse(R"({"name":"a.jpg","width":-1,"height":3})");
  refuse(R"({"name":"a.jpg","width":100000,"height":100000})");
  refuse(R"({"name":"a.jpg","width":4,"height":3,"focal_px":-1})");
  refuse(R"({"name":"a.jpg","width":4,"height":3,"photograph":[-8,6]})");
  refuse(R"({"name":"a.jpg","width":4,"height":3,"photograph":[8]})");
  EXPECT_TRUE(
      Says(refuse(R"({"name":"a.jpg","width":4,"height":3},{"name":"a.jpg","width":4,"height":3})"),
           "twice"));
  EXPECT_TRUE(
      Says(refuse(R"({"name":"a.jpg","width":4,"height":3,"group":)" + std::string(150, '[')),
           "levels"));
}

class ImageSetIo : public ::testing::Test, public TestingFolder {};

TEST_F(ImageSetIo, PlateAndGroupsComeBackAsTheyWereWritten) {
  ImageSet set;
  set.folder = folder_;
  set.board = BoardLayout{9, 7, 0.030, 0.02};
  set.board_print.dictionary = 20;
  set.board_print.first_white = true;
  CapturedImage image;
  image.name = "a.jpg";
  image.group = "lying";
  image.photograph_width = 4000;
  image.photograph_height = 3000;
  image.board_corners = {{0, Eigen::Vector2d(1.25, 1.0 / 3)}, {47, Eigen::Vector2d(-2, 1e3)}};
  set.images = {image};
  WriteFile(folder_ / "a.jpg", "x");
  WriteImageSet(set);
  const ImageSet read = ReadImageSet(folder_);
  ASSERT_TRUE(read.board.has_value());
  EXPECT_EQ(read.board->columns, 9);
  EXPECT_EQ(read.board->marker_m, 0.02);
  EXPECT_EQ(read.board_print.dictionary, 20);
  EXPECT_TRUE(read.board_print.first_white);
  EXPECT_FALSE(read.board_print.inverted);
  EXPECT_EQ(read.images[0].group, "lying");
  EXPECT_EQ(read.images[0].photograph_width, 4000);
  EXPECT_EQ(read.images[0].photograph_height, 3000);
  ASSERT_EQ(read.images[0].board_corners.size(), 2u);
  EXPECT_EQ(read.images[0].board_corners[1].id, 47);
  EXPECT_EQ(read.images[0].board_corners[0].pixel, image.board_corners[0].pixel);
}

TEST_F(ImageSetIo, ABoardOfTodaysOrOlderFilesIsKeyposesOwnAndAnUnknownDictionaryIsDamage) {
  const auto read = [&](const std::string& more) {
    WriteFile(folder_ / "capture.json",
              R"({"images": [], "board": {"columns": 11, "rows": 8, "square_m": 0.022, )"
              R"("marker_m": 0.0165)" +
                  more + "}}");
    return ReadImageSet(folder_).board_print;
  };
  for (const char* older : {"", R"(, "dictionary": "DICT_5X5_100")"}) {
    EXPECT_EQ(read(older).dictionary, kOwnDictionary);
    EXPECT_FALSE(read(older).first_white);
  }
  EXPECT_THROW(read(R"(, "dictionary": "DICT_9X9_50")"), InputError);
  EXPECT_THROW(read(R"(, "dictionary": "DICT_APRILTAG_16h5")"), InputError) << "30 markers";
}

TEST_F(ImageSetIo, PlateCornerThatThePlateDoesNotHaveIsAnInputError) {
  ImageSet set;
  set.folder = folder_;
  set.board = BoardLayout{3, 3, 0.030, 0.02};
  CapturedImage image;
  image.name = "a.jpg";
  image.board_corners = {{4, Eigen::Vector2d::Zero()}};
  set.images = {image};
  WriteFile(folder_ / "a.jpg", "x");
  WriteImageSet(set);
  EXPECT_THROW(ReadImageSet(folder_), InputError);
}

}  // namespace keypose::image_set_test
