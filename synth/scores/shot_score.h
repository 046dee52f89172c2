// `keypose synth score-shot`: compares a finished shot with its truth.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace keypose::synth {

struct ShotScoreCommand {
  std::filesystem::path shot;      ///< folder that RunShot wrote
  std::filesystem::path pictures;  ///< numbered pictures of the finished shot
  std::filesystem::path sheet;     ///< empty, or a PNG to write: made, true, four times difference
};

struct ShotPictureScore {
  int picture = 0;
  double psnr_db = 0;      ///< within the character's box
  double psnr_all_db = 0;  ///< of the whole picture
  double psnr_on_db = 0;   ///< on the character alone
};

struct ShotScore {
  std::vector<ShotPictureScore> pictures;  ///< those between filmed frames
  double worst_psnr_db = 0, mean_psnr_db = 0;
  int filmed = 0, filmed_unchanged = 0;  ///< filmed frames; those that are there bit for bit
};

/// @throws InputError  a folder without what belongs there, or pictures of other sizes
ShotScore ScoreShot(const ShotScoreCommand& command);
std::string ToJson(const ShotScore& score);

}  // namespace keypose::synth
