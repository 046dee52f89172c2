#include "capture/shoot/session/white_card.h"

#include <cmath>
#include <filesystem>
#include <regex>

#include "capture/shoot/develop/photograph.h"
#include "capture/shoot/develop/white_balance.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose::capture::shoot {

CarriedWhite WhiteOfCard(const std::string& text) {
  static const std::regex pattern("(.+):([0-9]{1,6}),([0-9]{1,6}),([0-9]{1,6}),([0-9]{1,6})");
  std::smatch match;
  const bool placed = std::regex_match(text, match, pattern);
  const std::filesystem::path file = placed ? match[1].str() : text;
  const Image8 image = ReadPhotograph(file);
  std::optional<PixelBox> box;
  if (placed)
    box = PixelBox{std::stoi(match[2]), std::stoi(match[3]), std::stoi(match[4]),
                   std::stoi(match[5])};
  else
    box = FindCard(image);
  if (!box)
    throw UsageError("--white-balance " + text +
                     ": no grey card is found in it; give its place as FILE:x,y,width,height");
  CarriedWhite white;
  white.gains = GainsFromCard(image, *box);
  for (double& gain : white.gains) gain = std::round(gain * 1e4) / 1e4;
  white.from = WithoutOddBytes(file.filename().string()) + ":" + std::to_string(box->x) + "," +
               std::to_string(box->y) + "," + std::to_string(box->width) + "," +
               std::to_string(box->height);
  return white;
}

}  // namespace keypose::capture::shoot
