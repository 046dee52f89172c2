#include "synth/scores/shot_score.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/png_io.h"
#include "core/io/project/shot_io.h"
#include "core/io/text/files.h"
#include "core/pictures/render.h"
#include "core/values/errors.h"
#include "core/values/image.h"
#include "core/values/size_of.h"

namespace keypose::synth {
namespace {

namespace fs = std::filesystem;

/// The picture of that number, of any kind; empty: none.
fs::path PictureOf(const fs::path& folder, int number) {
  for (const char* kind : {".png", ".jpg", ".JPG", ".tif", ".exr"})
    if (const fs::path path = folder / fmt::format("{:04}{}", number, kind); fs::exists(path))
      return path;
  return {};
}

Image8 ReadLike(const fs::path& path, const Image8& like) {
  Image8 picture = ReadImage(path, like.channels);
  if (picture.width != like.width || picture.height != like.height)
    throw InputError(fmt::format("synth: {} has {} x {} pixels, the truth {} x {}",
                                 PrintableName(path), picture.width, picture.height, like.width,
                                 like.height));
  return picture;
}

PixelBox BoxOf(const Image8& matte) {
  PixelBox box{matte.width, matte.height, 0, 0};
  for (int y = 0; y < matte.height; ++y)
    for (int x = 0; x < matte.width; ++x) {
      if (*matte.at(x, y) < 128) continue;
      box.x0 = std::min(box.x0, x);
      box.x1 = std::max(box.x1, x + 1);
      box.y0 = std::min(box.y0, y);
      box.y1 = std::max(box.y1, y + 1);
    }
  return box;
}

/// @param matte  only pixels inside count; null: all of the box
double Psnr(const Image8& a, const Image8& b, const PixelBox& box, const Image8* matte) {
  double sum = 0, count = 0;
  for (int y = box.y0; y < box.y1; ++y)
    for (int x = box.x0; x < box.x1; ++x) {
      if (matte && *matte->at(x, y) < 255) continue;
      for (int c = 0; c < 3; ++c) {
        const double d = static_cast<double>(a.at(x, y)[c]) - b.at(x, y)[c];
        sum += d * d;
        ++count;
      }
    }
  if (count == 0 || sum == 0) return 99;
  return std::min(99.0, 10 * std::log10(255.0 * 255.0 * count / sum));
}

Image8 Row(const Image8& made, const Image8& truth) {
  Image8 row(3 * made.width, made.height, 3);
  for (int y = 0; y < made.height; ++y)
    for (int x = 0; x < made.width; ++x)
      for (int c = 0; c < 3; ++c) {
        const int a = made.at(x, y)[c], b = truth.at(x, y)[c];
        row.at(x, y)[c] = static_cast<std::uint8_t>(a);
        row.at(x + made.width, y)[c] = static_cast<std::uint8_t>(b);
        row.at(x + 2 * made.width, y)[c] =
            static_cast<std::uint8_t>(std::clamp(128 + 4 * (a - b), 0, 255));
      }
  return row;
}

void CountFilmed(const ShotScoreCommand& command, int per_frame, ShotScore* score) {
  for (const FilmPicture& picture : FilmPictures(command.shot / "film")) {
    ++score->filmed;
    const fs::path there = command.pictures / fmt::format("{:04}{}", picture.frame * per_frame,
                                                          picture.path.extension().string());
    score->filmed_unchanged += fs::exists(there) && ReadFile(there) == ReadFile(picture.path);
  }
}

}  // namespace

ShotScore ScoreShot(const ShotScoreCommand& command) {
  const fs::path truth = command.shot / "truth" / "shot";
  ShotScore score;
  std::vector<Image8> rows;
  int last = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(truth / "frames"))
    last = std::max(last, std::atoi(entry.path().stem().c_str()));
  for (int n = 0; n <= last; ++n) {
    const fs::path frame = truth / "frames" / fmt::format("{:04}.png", n);
    if (!fs::exists(frame)) continue;
    const fs::path made_path = PictureOf(command.pictures, n);
    if (made_path.empty())
      throw InputError(
          fmt::format("synth: {} has no picture {:04}", PrintableName(command.pictures), n));
    const Image8 real = ReadImage(frame, 3), made = ReadLike(made_path, real),
                 matte = ReadImage(truth / "between" / fmt::format("{:04}.png", n), 1);
    const PixelBox box = BoxOf(matte);
    score.pictures.push_back({n, Psnr(made, real, box, nullptr),
                              Psnr(made, real, {0, 0, real.width, real.height}, nullptr),
                              Psnr(made, real, box, &matte)});
    if (!command.sheet.empty()) rows.push_back(Row(made, real));
  }
  if (score.pictures.empty())
    throw InputError("synth: " + PrintableName(truth) + " has no true pictures between frames");
  score.worst_psnr_db = 99;
  for (const ShotPictureScore& picture : score.pictures) {
    score.worst_psnr_db = std::min(score.worst_psnr_db, picture.psnr_db);
    score.mean_psnr_db += picture.psnr_db / SizeOf(score.pictures);
  }
  const FilmedShot shot = ReadShot(truth / "shot.json");
  const int frames = shot.frames.back().frame;
  CountFilmed(command, frames ? std::max(1, (last + 1) / frames) : 1, &score);
  if (!rows.empty()) WritePng(command.sheet, TileImages(rows, 1));
  return score;
}

std::string ToJson(const ShotScore& score) {
  nlohmann::ordered_json root = {{"worst_psnr_db", score.worst_psnr_db},
                                 {"mean_psnr_db", score.mean_psnr_db},
                                 {"filmed", score.filmed},
                                 {"filmed_unchanged", score.filmed_unchanged},
                                 {"pictures", nlohmann::ordered_json::array()}};
  for (const ShotPictureScore& picture : score.pictures)
    root["pictures"].push_back({{"picture", picture.picture},
                                {"psnr_db", picture.psnr_db},
                                {"psnr_on_character_db", picture.psnr_on_db},
                                {"psnr_all_db", picture.psnr_all_db}});
  return root.dump(1) + "\n";
}

}  // namespace keypose::synth
