#include "views/shot/given_masks.h"

#include <algorithm>
#include <set>

#include "core/io/pictures/drawn_mask.h"
#include "core/io/pictures/drawn_matte.h"
#include "core/io/pictures/image_io.h"
#include "core/pictures/given_matte.h"
#include "core/pictures/mask_channels.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "views/decode/film_decoder.h"

namespace keypose {
namespace {

/// Frames that tell how masks were made: of a film the first ones, as it is decoded in order.
std::set<int> FramesToLookAt(const FrameSource& masks) {
  constexpr int kFilmed = 12;
  const int last = masks.frames - 1;
  if (masks.video.empty()) return {0, last / 2, last};
  return {0, std::min(kFilmed, last), std::min(2 * kFilmed, last)};
}

/// Share of the pixels that are in one of two masks alone.
double ShareOfDifference(const Image8& a, const Image8& b) {
  std::int64_t different = 0;
  for (std::size_t i = 0; i < a.data.size(); ++i)
    different += (a.data[i] > 127) != (b.data[i] > 127);
  return static_cast<double>(different) /
         static_cast<double>(std::max<std::size_t>(1, a.data.size()));
}

}  // namespace

GivenMasks::GivenMasks(const ShotCamera& camera, const std::string& stage)
    : name_(camera.name), stage_(stage), source_(camera.masks), reader_(camera.masks) {
  const std::set<int> frames = FramesToLookAt(source_);
  const Tally tally = is_film() ? LookAtFilm(frames) : LookAtPictures(frames);
  const std::string of = stage_ + ": the masks of camera " + name_;
  if (drawn_)
    warnings_.push_back(of +
                        " are not white on black; the higher of their levels, or their alpha, "
                        "is taken for the actor");
  if (tally.surround > 0 && tally.surround + tally.empty + tally.full == tally.looked) {
    inverted_ = true;
    warnings_.push_back(of +
                        " are white where the actor is not, and were turned round: black is "
                        "taken for the actor");
  }
  if (tally.empty == tally.looked)
    warnings_.push_back(of + " are black in all of the " + std::to_string(tally.looked) +
                        " frames that were looked at: nobody is drawn in them; make them again, or "
                        "leave the camera out");
}

std::filesystem::path GivenMasks::FileOf(int frame) const {
  const int picture =
      source_.order.empty() ? frame : source_.order[static_cast<std::size_t>(frame)];
  return source_.pictures[static_cast<std::size_t>(picture)];
}

bool GivenMasks::IsByAlpha(const Image8& alpha) const {
  return AlphaIsMask(alpha) || (alpha_ && !alpha.empty());
}

GivenMasks::Filmed GivenMasks::ReadFilmed(int frame) {
  if (!source_.index || !source_.index->has_alpha) return {reader_.Read(frame, 1), {}};
  const Image8 shown = reader_.Read(frame, 4);
  Image8 alpha(shown.width, shown.height, 1);
  for (std::size_t p = 0; p < alpha.data.size(); ++p) alpha.data[p] = shown.data[4 * p + 3];
  return {FilmLuma(shown), std::move(alpha)};
}

/// By levels and alpha; the noise of a film's levels is that of compression.
Image8 GivenMasks::Drawn(const Filmed& filmed) const {
  if (IsByAlpha(filmed.alpha)) return filmed.alpha;
  return MaskOfLevels(AsLevels(filmed.luma), false, source_.video.filename());
}

Image8 GivenMasks::DrawnPicture(int frame) const {
  const std::filesystem::path file = FileOf(frame);
  if (alpha_)
    if (const Image8 alpha = ReadAlpha(file); !alpha.empty())
      return MaskOfLevels(AsLevels(alpha), true, file.filename());
  return ReadDrawnMask(file);
}

GivenMasks::Tally GivenMasks::LookAtFilm(const std::set<int>& frames) {
  std::vector<Filmed> filmed;
  for (const int frame : frames) {
    filmed.push_back(ReadFilmed(frame));
    alpha_ |= AlphaIsMask(filmed.back().alpha);
  }
  Tally tally;
  for (const Filmed& one : filmed) LookAt(one.luma, Drawn(one), &tally);
  return tally;
}

GivenMasks::Tally GivenMasks::LookAtPictures(const std::set<int>& frames) {
  alpha_ = std::any_of(frames.begin(), frames.end(),
                       [this](int frame) { return AlphaIsMask(ReadAlpha(FileOf(frame))); });
  Tally tally;
  for (const int frame : frames) LookAt(reader_.Read(frame, 1), DrawnPicture(frame), &tally);
  return tally;
}

void GivenMasks::LookAt(const Image8& plain, const Image8& drawn, Tally* tally) {
  constexpr double kUnlike = 1e-3;
  drawn_ |= alpha_ || ShareOfDifference(plain, drawn) > kUnlike;
  ++tally->looked;
  tally->empty += IsEmptyMatte(drawn);
  tally->full += IsFullMatte(drawn);
  tally->surround += CoversBorder(drawn);
}

void GivenMasks::FitTo(int width, int height, int orientation) {
  fitted_ = true;
  width_ = width;
  height_ = height;
  orientation_ = orientation;
  MatteChange change;
  PlacedMatte(reader_.Read(0, 1), width_, height_, orientation_,
              stage_ + ": a mask of camera " + name_, &change);
  const std::string of = stage_ + ": the masks of camera " + name_;
  if (change.turned)
    warnings_.push_back(of + " lie as its pictures are stored, and were turned as EXIF says");
  if (change.resized)
    warnings_.push_back(of + " have another size than its pictures, and were resized");
}

Image8 GivenMasks::Read(int frame) {
  Image8 mask = !drawn_     ? reader_.Read(frame, 1)
                : is_film() ? Drawn(ReadFilmed(frame))
                            : DrawnPicture(frame);
  if (fitted_)
    mask = PlacedMatte(std::move(mask), width_, height_, orientation_,
                       stage_ + ": a mask of camera " + name_, nullptr);
  return inverted_ ? InvertedMatte(std::move(mask)) : mask;
}

}  // namespace keypose
