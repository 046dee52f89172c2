#include "composite/given_mattes.h"

#include <fmt/format.h>

#include "core/io/pictures/drawn_matte.h"
#include "core/pictures/given_matte.h"

namespace keypose::composite {
namespace {

/// The first of them, and how many more.
std::string SomeNames(const std::vector<std::string>& names) {
  return names.size() == 1 ? names[0] : fmt::format("{} and {} more", names[0], names.size() - 1);
}

}  // namespace

Image8 GivenMattes::Read(const std::filesystem::path& file, const MattePlace& place) {
  const std::string name = file.filename().string();
  DrawnMatte drawn = ReadDrawnMatte(file);
  MatteChange change;
  Image8 matte =
      PlacedMatte(std::move(drawn.matte), place.width, place.height, place.orientation,
                  fmt::format("{}: the {} {} of {}", stage_, what_, name, place.name), &change);
  if (drawn.stretched) stretched_.push_back(name);
  if (change.turned) turned_.push_back(name);
  if (change.resized) resized_.push_back(name);
  ++read_;
  empty_ += IsEmptyMatte(matte);
  full_ += IsFullMatte(matte);
  surround_ += CoversBorder(matte);
  return matte;
}

void GivenMattes::Tell(StageContext& stage) const {
  const auto tell = [&](const std::vector<std::string>& which, const char* words) {
    if (!which.empty())
      stage.Warn(fmt::format("{}: {}: {}", stage_, fmt::format(fmt::runtime(words), what_),
                             SomeNames(which)));
  };
  tell(stretched_,
       "this {} has two levels that are not black and white; the higher one is taken "
       "for white");
  tell(turned_, "this {} lies as its picture is stored, and was turned as EXIF says");
  tell(resized_, "this {} has another size than its picture, and was resized");
}

}  // namespace keypose::composite
