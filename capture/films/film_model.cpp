#include "capture/films/film_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "capture/films/motion_evidence.h"
#include "capture/pictures/cv_image.h"
#include "capture/segmentation/region_cut.h"
#include "capture/segmentation/trimap.h"
#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"

namespace keypose::capture {

namespace {

constexpr float kColourWeight = 0.75F, kColourLimit = 4;
constexpr float kModeLimit = 4;  // log odds of a colour that is always on the same side
// The first rounds trust colours more: a leg that stands still all the time looks like the set
// until its colour is known.
constexpr float kFirstModeLimit = 1.5F;
constexpr float kEvidence = 2.5F;       // log odds of the strongest evidence from motion
constexpr float kTextureWeight = 0.5F;  // against that of edges
constexpr float kOtherThanSet = 2;      // log odds of a colour that the pixel never had before
constexpr double kReach = 0.06;  // of the longer side: so far from motion everything is the set
constexpr float kShadowLean =
    2;  // log odds against the actor where a colour may be the set's shadow
constexpr std::size_t kFramesForColours = 16;
constexpr float kTold = 12;

/// Darker than the set, with its hue.
bool MayBeShadow(const std::uint8_t* lab, const std::uint8_t* set) {
  constexpr double kLeastLight = 0.45, kLargestHue = 5;
  const double left = lab[0] / std::max<double>(set[0], 1);
  if (left >= 1 || left < kLeastLight) return false;
  return std::hypot(lab[1] - 128 - left * (set[1] - 128), lab[2] - 128 - left * (set[2] - 128)) <
         kLargestHue;
}

/// The network's opinion as evidence; its middle values say nothing.
float Opinion(std::uint8_t salience) {
  constexpr int kSure = 200, kSureNot = 20;
  if (salience > kSure) return 1.0F;
  return salience < kSureNot ? -0.7F : 0.0F;
}

int ReachOf(const Image8& area) {
  return std::max(4, static_cast<int>(std::lround(kReach * std::max(area.width, area.height))));
}

/// The median colour of what is told of one side.
std::array<std::uint8_t, 3> ToldColour(const Image8& lab, const Image8& told, std::uint8_t side) {
  std::array<std::vector<std::uint8_t>, 3> values;
  for (std::size_t p = 0; p < told.data.size(); ++p)
    for (std::size_t c = 0; told.data[p] == side && c < 3; ++c)
      values[c].push_back(lab.data[3 * p + c]);
  std::array<std::uint8_t, 3> median{};
  for (std::size_t c = 0; c < 3; ++c) median[c] = UpperMedian(std::move(values[c]));
  return median;
}

/// A stroke means the patch that it lies on: what is told spreads to neighbours of nearly the
/// stroke's median colour; a stroke that goes a little too far does not spread there.
void GrowTold(const Image8& lab, double radius, Image8& told) {
  struct Grown {
    cv::Point at, from;
  };
  const double step = 0.5 * radius, patch = 1.5 * radius;
  const int reach = ReachOf(told);
  const std::array<std::uint8_t, 3> colours[] = {ToldColour(lab, told, kBackground),
                                                 ToldColour(lab, told, kObject)};
  std::vector<Grown> open;
  for (int y = 0; y < told.height; ++y)
    for (int x = 0; x < told.width; ++x)
      if (*told.at(x, y) != kUnknown) open.push_back({{x, y}, {x, y}});
  for (std::size_t i = 0; i < open.size(); ++i) {
    const Grown here = open[i];
    const std::uint8_t side = *told.at(here.at.x, here.at.y);
    for (const cv::Point& to : {here.at + cv::Point(1, 0), here.at - cv::Point(1, 0),
                                here.at + cv::Point(0, 1), here.at - cv::Point(0, 1)}) {
      if (!cv::Rect(0, 0, told.width, told.height).contains(to) ||
          *told.at(to.x, to.y) != kUnknown || cv::norm(to - here.from) > reach)
        continue;
      const std::uint8_t* colour = lab.at(to.x, to.y);
      if (ModeDistance(colour, lab.at(here.at.x, here.at.y)) > step ||
          ModeDistance(colour, colours[side == kObject].data()) > patch)
        continue;
      *told.at(to.x, to.y) = side;
      open.push_back({to, here.from});
    }
  }
}

cv::Rect Around(const Image8& area, int margin) {
  const cv::Rect box = cv::boundingRect(MatOf(area));
  if (box.empty()) return {0, 0, area.width, area.height};
  return cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin) &
         cv::Rect(0, 0, area.width, area.height);
}

/// 0 where things move, down to -limit beyond the reach.
ImageF PriorOf(const Image8& area, double limit) {
  ImageF prior(area.width, area.height, 1);
  cv::Mat distance;
  cv::distanceTransform(MatOf(area) == 0, distance, cv::DIST_L2, 5);
  const int reach = ReachOf(area);
  for (std::size_t p = 0; p < prior.data.size(); ++p)
    prior.data[p] = static_cast<float>(
        -limit * std::min(1.0, static_cast<double>(distance.ptr<float>()[p]) / reach));
  return prior;
}

}  // namespace

float FilmModel::ModeOdds(std::size_t pixel, const std::uint8_t* lab) const {
  const PixelMode* modes = modes_.of(pixel);
  int best = -1;
  double nearest = radius_;
  for (int m = 0; m < kMostModes && modes[m].share > 0; ++m)
    if (const double d = ModeDistance(modes[m].lab.data(), lab); d < nearest) {
      nearest = d;
      best = m;
    }
  if (best >= 0) return mode_odds_[pixel * kMostModes + best];
  if (set_[pixel] < 0) return 0;
  return MayBeShadow(lab, modes[set_[pixel]].lab.data()) ? 0 : kOtherThanSet;
}

ImageF FilmModel::Odds(const Image8& rgb, const Image8& lab) const {
  ImageF odds = colours_.Of(rgb, kColourLimit);
  const auto limit = static_cast<float>(options_.odds_limit);
  for (std::size_t p = 0; p < odds.data.size(); ++p)
    odds.data[p] =
        std::clamp(kColourWeight * odds.data[p] + ModeOdds(p, &lab.data[3 * p]) + prior_.data[p],
                   -limit, limit);
  return odds;
}

Image8 FilmModel::Regions(const Image8& rgb, const ImageF& odds) const {
  const cv::Rect box = Around(area_, ReachOf(area_));
  ImageF near(box.width, box.height, 1);
  for (int y = 0; y < box.height; ++y)
    std::copy_n(odds.at(box.x, box.y + y), box.width, near.at(0, y));
  Image8 regions = CutLabels(ImageOf(MatOf(rgb)(box)), near, options_.smoothness);
  FillUnclearHoles(regions, near, 1);
  cv::Mat whole = cv::Mat::zeros(rgb.height, rgb.width, CV_8U);
  MatOf(regions).copyTo(whole(box));
  return ImageOf(whole);
}

double FilmModel::set_known() const {
  double known = 0, all = 0;
  for (std::size_t p = 0; p < set_.size(); ++p)
    if (area_.data[p]) {
      known += set_[p] >= 0;
      all += 1;
    }
  return all > 0 ? known / all : 1;
}

FilmLearning::FilmLearning(std::vector<Image8> rgb, std::vector<Image8> lab, PixelModes modes,
                           double radius, const Image8& area, FilmHints hints,
                           const FilmMaskOptions& options)
    : rgb_(std::move(rgb)),
      lab_(std::move(lab)),
      modes_(std::move(modes)),
      hints_(std::move(hints)) {
  model_.options_ = options;
  model_.radius_ = radius;
  model_.area_ = area;
  model_.modes_.width = modes_.width;
  model_.modes_.height = modes_.height;
  model_.modes_.modes = modes_.modes;
  model_.prior_ = PriorOf(area, options.odds_limit);
  for (std::size_t k = 0; k < hints_.told.size(); ++k)
    if (!hints_.told[k].empty()) GrowTold(lab_[k], radius, hints_.told[k]);
  Begin();
  for (int round = 0; round < options.rounds; ++round) {
    Cut();
    const float done = static_cast<float>(round) / static_cast<float>(options.rounds);
    TakeSides(kFirstModeLimit + done * (kModeLimit - kFirstModeLimit));
    LearnColours([&](std::size_t k) { return TrimapOf(masks_[k]); });
  }
  Cut();
}

void FilmLearning::Listen(std::vector<ImageF> odds) {
  constexpr int kRounds = 2;
  heard_ = std::move(odds);
  for (int round = 0; round < kRounds; ++round) {
    Cut();
    TakeSides(kModeLimit);
    LearnColours([&](std::size_t k) { return TrimapOf(masks_[k]); });
  }
  Cut();
}

// Each colour's odds from edges and the network.
void FilmLearning::Begin() {
  model_.mode_odds_ = EdgeEvidence(lab_, modes_, model_.area_, model_.radius_);
  const std::vector<float> texture = TextureEvidence(lab_, modes_, model_.area_, model_.radius_);
  for (std::size_t i = 0; i < texture.size(); ++i)
    model_.mode_odds_[i] += kTextureWeight * texture[i];
  AddSalience();
  for (float& odds : model_.mode_odds_) odds *= kEvidence;
  TakeTold();
  FindSet();
  LearnColours([&](std::size_t k) { return FirstTrimap(k); });
}

// Pixels whose evidence is strong enough to learn colours from.
Image8 FilmLearning::FirstTrimap(std::size_t k) const {
  constexpr float kStrong = 0.4F * kEvidence;
  Image8 trimap(modes_.width, modes_.height, 1, kUnknown);
  for (std::size_t p = 0; p < trimap.data.size(); ++p) {
    if (model_.prior_.data[p] <= -model_.options_.odds_limit) trimap.data[p] = kBackground;
    const std::uint8_t mode = modes_.labels[k].data[p];
    if (!model_.area_.data[p] || mode == kNoMode) continue;
    const float odds = model_.mode_odds_[p * kMostModes + mode];
    if (std::abs(odds) > kStrong) trimap.data[p] = odds > 0 ? kObject : kBackground;
  }
  return trimap;
}

void FilmLearning::AddSalience() {
  std::vector<float> sum(modes_.modes.size(), 0), count(sum);
  for (std::size_t k = 0; k < hints_.salience.size(); ++k) {
    const Image8& salience = hints_.salience[k];
    for (std::size_t p = 0; p < salience.data.size(); ++p) {
      const std::uint8_t mode = modes_.labels[k].data[p];
      if (mode == kNoMode || !model_.area_.data[p]) continue;
      sum[p * kMostModes + mode] += Opinion(salience.data[p]);
      count[p * kMostModes + mode] += 1;
    }
  }
  for (std::size_t i = 0; i < sum.size(); ++i) model_.mode_odds_[i] += sum[i] / (count[i] + 1);
}

void FilmLearning::LearnColours(const std::function<Image8(std::size_t)>& trimap_of) {
  ColorOdds colours;
  const std::size_t count = std::min(kFramesForColours, rgb_.size());
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t k = i * rgb_.size() / count;
    colours.Add(rgb_[k], trimap_of(k));
  }
  for (std::size_t k = 0; k < hints_.told.size(); ++k)
    if (!hints_.told[k].empty()) colours.Add(rgb_[k], hints_.told[k]);
  colours.Finish();
  model_.colours_ = std::move(colours);
}

void FilmLearning::Cut() {
  masks_.resize(rgb_.size());
  ParallelFor(std::ssize(rgb_), [&](std::int64_t i) {
    const auto k = static_cast<std::size_t>(i);
    ImageF odds = model_.Odds(rgb_[k], lab_[k]);
    for (std::size_t p = 0; !heard_.empty() && p < odds.data.size(); ++p)
      odds.data[p] += heard_[k].data[p];
    if (!hints_.told.empty() && !hints_.told[k].empty())
      for (std::size_t p = 0; p < odds.data.size(); ++p)
        if (const std::uint8_t told = hints_.told[k].data[p]; told != kUnknown)
          odds.data[p] = told == kObject ? kTold : -kTold;
    masks_[k] = model_.Regions(rgb_[k], odds);
  });
}

// Each colour of a pixel goes to the side on which the cuts have it.
void FilmLearning::TakeSides(float limit) {
  constexpr float kHalfSure = 2;  // frames that make a colour's side half sure
  std::vector<float> inside(modes_.modes.size(), 0), count(inside);
  for (std::size_t k = 0; k < rgb_.size(); ++k)
    for (std::size_t p = 0; p < masks_[k].data.size(); ++p) {
      const std::uint8_t mode = modes_.labels[k].data[p];
      if (mode == kNoMode) continue;
      inside[p * kMostModes + mode] += masks_[k].data[p] > 127;
      count[p * kMostModes + mode] += 1;
    }
  for (std::size_t i = 0; i < count.size(); ++i)
    model_.mode_odds_[i] =
        count[i] > 0 ? limit * (2 * inside[i] - count[i]) / (count[i] + kHalfSure) : 0;
  TakeTold();
  FindSet();
}

// What a person said of a pixel in one frame holds wherever it has the same colour.
void FilmLearning::TakeTold() {
  constexpr float kSaid = 1.5F * kModeLimit;
  for (std::size_t k = 0; k < hints_.told.size(); ++k)
    for (std::size_t p = 0; p < hints_.told[k].data.size(); ++p) {
      const std::uint8_t mode = modes_.labels[k].data[p];
      if (hints_.told[k].data[p] == kUnknown || mode == kNoMode) continue;
      model_.mode_odds_[p * kMostModes + mode] = hints_.told[k].data[p] == kObject ? kSaid : -kSaid;
    }
}

// The most frequent of each pixel's colours that are on the set's side; colours that may be its
// shadow lean to that side too.
void FilmLearning::FindSet() {
  constexpr float kSetSide = -0.5F;
  model_.set_.assign(modes_.modes.size() / kMostModes, -1);
  for (std::size_t p = 0; p < model_.set_.size(); ++p) {
    const PixelMode* modes = modes_.of(p);
    float* odds = &model_.mode_odds_[p * kMostModes];
    if (!model_.area_.data[p]) model_.set_[p] = 0;
    for (int m = 0; m < kMostModes && model_.set_[p] < 0 && modes[m].share > 0; ++m)
      if (odds[m] < kSetSide) model_.set_[p] = static_cast<std::int8_t>(m);
    if (model_.set_[p] < 0) continue;
    for (int m = 0; m < kMostModes && modes[m].share > 0; ++m)
      if (m != model_.set_[p] && MayBeShadow(modes[m].lab.data(), modes[model_.set_[p]].lab.data()))
        odds[m] -= kShadowLean;
  }
}

}  // namespace keypose::capture
