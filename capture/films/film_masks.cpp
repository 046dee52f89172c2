#include "capture/films/film_masks.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/imgproc.hpp>

#include "capture/films/actor_regions.h"
#include "capture/films/film_exposure.h"
#include "capture/films/moving_regions.h"
#include "capture/pictures/cv_image.h"
#include "capture/segmentation/empty_set.h"
#include "capture/segmentation/trimap.h"
#include "core/numbers/parallel.h"
#include "core/values/errors.h"

namespace keypose::capture {
namespace {

constexpr int kMostLearnt = 60;     // frames
constexpr int kAsked = 4;           // frames that the network sees before the actor is known
constexpr std::size_t kLooks = 12;  // frames that it sees closely after that
constexpr double kRival = 0.25;     // of the actor's motion: another thing that is named
constexpr double kOther = 0.15;     // of the actor's area: another region that is named

/// A square about what moves, with a margin, within the picture.
cv::Rect SquareAround(const MovingRegion& region, int width, int height) {
  constexpr double kMargin = 1.2;
  const int side =
      static_cast<int>(kMargin * std::max(region.right - region.left, region.bottom - region.top));
  const cv::Rect square((region.left + region.right - side) / 2,
                        (region.top + region.bottom - side) / 2, side, side);
  return square & cv::Rect(0, 0, width, height);
}

Image8 SalienceIn(const cv::Rect& part, const Image8& rgb, const AskNetwork& network) {
  const Image8 seen = network(ImageOf(MatOf(rgb)(part)));
  cv::Mat whole = cv::Mat::zeros(rgb.height, rgb.width, CV_8U);
  MatOf(seen).copyTo(whole(part));
  return ImageOf(whole);
}

/// The mean of the network's opinion in a region, in the middle of the film.
double SalienceOf(const MovingRegion& region, const Image8& rgb, const AskNetwork& network) {
  const Image8 salience = SalienceIn(SquareAround(region, rgb.width, rgb.height), rgb, network);
  return cv::mean(MatOf(salience), MatOf(region.area))[0] / 255;
}

bool Holds(const MovingRegion& region, const Image8& trimap, TrimapLabel label) {
  for (std::size_t p = 0; p < trimap.data.size(); ++p)
    if (trimap.data[p] == label && region.area.data[p]) return true;
  return false;
}

void AddTo(ImageF& odds, const ImageF& more) {
  for (std::size_t p = 0; p < odds.data.size(); ++p) odds.data[p] += more.data[p];
}

/// All that the network takes for the object in one frame, as if it moved.
MovingRegion SalientRegion(const Image8& rgb, const AskNetwork& network) {
  MovingRegion region;
  cv::Mat area = MatOf(network(rgb)) > 127;
  const int reach = std::max(3, std::max(rgb.width, rgb.height) / 40);
  cv::dilate(area, area,
             cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * reach + 1, 2 * reach + 1}));
  const cv::Rect box = cv::boundingRect(area);
  region.area = ImageOf(area);
  region.left = box.x;
  region.top = box.y;
  region.right = box.x + box.width;
  region.bottom = box.y + box.height;
  return region;
}

}  // namespace

std::vector<int> FramesToLearnFrom(int frames, const std::vector<ToldFrame>& told) {
  std::vector<int> chosen;
  const int count = std::min(frames, kMostLearnt);
  for (int i = 0; i < count; ++i)
    chosen.push_back(static_cast<int>(static_cast<std::int64_t>(i) * frames / count));
  for (const ToldFrame& t : told)
    if (t.frame >= 0 && t.frame < frames) chosen.push_back(t.frame);
  std::sort(chosen.begin(), chosen.end());
  chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
  return chosen;
}

struct FilmMasker::Impl {
  Impl(FilmSample sample, const std::vector<ToldFrame>& told, const AskNetwork& network,
       const FilmMaskOptions& options)
      : frames(std::move(sample.frames)), usual(MedianOf(sample.pictures)) {
    std::vector<Image8>& rgb = sample.pictures;
    std::vector<Image8> lab(rgb.size());
    std::vector<ExposureGain> gains(rgb.size());
    ParallelFor(std::ssize(rgb), [&](std::int64_t k) {
      gains[k] = ExposureGainOf(rgb[k], usual);
      rgb[k] = WithGain(rgb[k], gains[k]);
      lab[k] = LabOf(rgb[k]);
    });
    for (const ExposureGain& gain : gains)
      exposure_change = std::max(exposure_change, std::abs(std::log2(gain[1])));
    const double radius = ModeRadius(lab);
    PixelModes modes = FindPixelModes(lab, radius);
    FilmHints hints;
    Tell(told, hints);
    ChooseRegion(FindMovingRegions(modes), rgb, hints, network);
    Ask(rgb, network, hints);
    learning = std::make_unique<FilmLearning>(std::move(rgb), std::move(lab), std::move(modes),
                                              radius, region.area, std::move(hints), options);
    TakeOver();
    if (network) LookClosely(network);
  }

  /// Shows the network the actor in some frames, and learns again with what it says of him.
  void LookClosely(const AskNetwork& network) {
    const std::size_t count = std::min(kLooks, frames.size());
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t k = (2 * i + 1) * frames.size() / (2 * count);
      looks.Add(frames[k], learning->rgb()[k], learning->lab()[k], actors[k], network);
    }
    if (!looks.empty()) Listen({});
  }

  /// @param odds  for each frame that is learnt from, beside those of the looks; may be empty
  void Listen(std::vector<ImageF> odds) {
    if (odds.empty()) odds.assign(frames.size(), ImageF(usual.width, usual.height, 1));
    if (!looks.empty())
      ParallelFor(std::ssize(odds), [&](std::int64_t k) {
        AddTo(odds[k], looks.Odds(frames[k], learning->lab()[k], model.radius()));
      });
    learning->Listen(std::move(odds));
    TakeOver();
  }

  void TakeOver() {
    model = learning->model();
    FollowFrom(FirstSample(learning->masks(), learning->hints()), learning->masks(),
               learning->hints());
  }

  void Tell(const std::vector<ToldFrame>& told, FilmHints& hints) const {
    if (told.empty()) return;
    hints.told.resize(frames.size());
    for (const ToldFrame& t : told) {
      const auto at = std::find(frames.begin(), frames.end(), t.frame);
      if (at != frames.end()) hints.told[at - frames.begin()] = t.trimap;
    }
  }

  /// The region in which the actor moves: what a person touched, else what moves most; where
  /// another thing moves about as much, what the network prefers.
  void ChooseRegion(std::vector<MovingRegion> regions, const std::vector<Image8>& rgb,
                    const FilmHints& hints, const AskNetwork& network) {
    std::size_t best = regions.size();
    for (std::size_t i = 0; i < regions.size() && best == regions.size(); ++i)
      for (const Image8& trimap : hints.told)
        if (!trimap.empty() && Holds(regions[i], trimap, kObject)) best = i;
    const Image8& middle = rgb[rgb.size() / 2];
    if (regions.empty()) {
      if (!network) return;
      regions.push_back(SalientRegion(middle, network));
      if (regions[0].right == 0) return;
    }
    if (best == regions.size()) {
      best = 0;
      double highest = 0;
      for (std::size_t i = 0; network && regions.size() > 1 && i < regions.size(); ++i) {
        if (regions[i].amount < kRival * regions[0].amount) break;
        const double weight = regions[i].amount * SalienceOf(regions[i], middle, network);
        if (weight > highest) {
          highest = weight;
          best = i;
        }
      }
    }
    for (std::size_t i = 0; i < regions.size(); ++i)
      if (i != best && regions[i].amount > kRival * regions[best].amount)
        rivals.push_back(PlaceOf(regions[i], middle.width, middle.height));
    region = std::move(regions[best]);
  }

  void Ask(const std::vector<Image8>& rgb, const AskNetwork& network, FilmHints& hints) const {
    if (region.area.empty())
      throw InputError(
          "nothing moves in the film, so the actor cannot be told from the set; put a picture of "
          "the empty set at background/CAMERA.jpg beside the films");
    if (!network) return;
    hints.salience.resize(rgb.size());
    const cv::Rect part = SquareAround(region, rgb[0].width, rgb[0].height);
    for (int i = 0; i < kAsked; ++i) {
      const std::size_t k = (2 * static_cast<std::size_t>(i) + 1) * rgb.size() / (2 * kAsked);
      hints.salience[k] = SalienceIn(part, rgb[k], network);
    }
  }

  /// Where the actor is most surely known: where a person touched it, else where it is largest.
  static std::size_t FirstSample(const std::vector<Image8>& masks, const FilmHints& hints) {
    for (std::size_t k = 0; k < hints.told.size(); ++k)
      if (!hints.told[k].empty() && std::count(hints.told[k].data.begin(), hints.told[k].data.end(),
                                               static_cast<std::uint8_t>(kObject)) > 0)
        return k;
    std::size_t best = 0;
    double most = -1;
    for (std::size_t k = 0; k < masks.size(); ++k) {
      const ActorRegions actor = ChooseActor(masks[k], {});
      const double area = cv::countNonZero(MatOf(actor.mask));
      if (area > most) {
        most = area;
        best = k;
      }
    }
    return best;
  }

  void FollowFrom(std::size_t first, const std::vector<Image8>& masks, const FilmHints& hints) {
    actors.resize(masks.size());
    Image8 zone;
    if (!hints.told.empty() && !hints.told[first].empty()) {
      zone = Image8(usual.width, usual.height, 1);
      for (std::size_t p = 0; p < zone.data.size(); ++p)
        zone.data[p] = hints.told[first].data[p] == kObject ? 255 : 0;
    }
    actors[first] = ChooseActor(masks[first], zone).mask;
    for (std::size_t k = first + 1; k < masks.size(); ++k)
      actors[k] = ChooseActor(masks[k], ZoneAround(actors[k - 1])).mask;
    for (std::size_t k = first; k-- > 0;)
      actors[k] = ChooseActor(masks[k], ZoneAround(actors[k + 1])).mask;
  }

  std::vector<int> frames;
  Image8 usual;  ///< the median of the sample
  MovingRegion region;
  std::unique_ptr<FilmLearning> learning;  ///< until EndLearning
  FilmModel model;
  NetworkLooks looks;
  std::vector<Image8> actors;         ///< the masks of the sample
  double exposure_change = 0;         ///< largest, in stops
  std::vector<std::string> rivals{};  ///< places of other things that move
  Image8 before;                      ///< the mask of the last frame
  int others = 0, other_frame = 0;    ///< frames with another large region; the first of them
};

FilmMasker::FilmMasker(FilmSample sample, const std::vector<ToldFrame>& told,
                       const AskNetwork& network, const FilmMaskOptions& options)
    : impl_(std::make_unique<Impl>(std::move(sample), told, network, options)) {}
FilmMasker::~FilmMasker() = default;
FilmMasker::FilmMasker(FilmMasker&&) noexcept = default;

const std::vector<Image8>& FilmMasker::learnt_masks() const { return impl_->actors; }
const std::vector<int>& FilmMasker::learnt_frames() const { return impl_->frames; }

void FilmMasker::Listen(std::vector<ImageF> odds) { impl_->Listen(std::move(odds)); }

void FilmMasker::EndLearning() { impl_->learning.reset(); }

Image8 FilmMasker::Regions(int frame, const Image8& rgb) const {
  const Impl& film = *impl_;
  const Image8 even = WithGain(rgb, ExposureGainOf(rgb, film.usual)), lab = LabOf(even);
  ImageF odds = film.model.Odds(even, lab);
  if (!film.looks.empty()) AddTo(odds, film.looks.Odds(frame, lab, film.model.radius()));
  return film.model.Regions(even, odds);
}

Image8 FilmMasker::Choose(int frame, const Image8& regions) {
  Impl& film = *impl_;
  const auto learnt = std::lower_bound(film.frames.begin(), film.frames.end(), frame);
  const bool known = learnt != film.frames.end() && *learnt == frame;
  const Image8 expected = known ? film.actors[learnt - film.frames.begin()] : film.before;
  ActorRegions actor = ChooseActor(regions, expected.empty() ? expected : ZoneAround(expected));
  if (actor.other > kOther && film.others++ == 0) film.other_frame = frame;
  film.before = actor.mask;
  return std::move(actor.mask);
}

std::vector<std::string> FilmMasker::Warnings(const std::string& camera) const {
  constexpr double kHardlyShown = 0.5, kExposure = 0.15;
  const Impl& film = *impl_;
  std::vector<std::string> warnings;
  for (const std::string& place : film.rivals)
    warnings.push_back("camera " + camera + ": another thing moves " + place +
                       " and was left out; if it is the actor, say so: --figure '" + camera +
                       "/FRAME:X,Y'");
  if (film.others > 0)
    warnings.push_back("camera " + camera + ": in " + std::to_string(film.others) +
                       " frames from " + std::to_string(film.other_frame) +
                       " on, a region apart from the actor looks like it and was left out; look at "
                       "those masks");
  if (film.model.set_known() < kHardlyShown) {
    char text[160];
    std::snprintf(text, sizeof text,
                  ": the film shows the set behind only %.0f %% of where the actor moves; look at "
                  "its masks",
                  100 * film.model.set_known());
    warnings.push_back("camera " + camera + text);
  }
  if (film.exposure_change > kExposure) {
    char text[160];
    std::snprintf(text, sizeof text,
                  ": its exposure changes by %.1f stops in the course of the film; it was evened, "
                  "but set it to manual next time",
                  film.exposure_change);
    warnings.push_back("camera " + camera + text);
  }
  return warnings;
}

}  // namespace keypose::capture
