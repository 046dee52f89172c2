#include "capture/shoot/session/shot_checks.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "capture/pictures/cv_image.h"
#include "capture/pictures/photograph_quality.h"
#include "capture/pictures/working_image.h"
#include "capture/segmentation/masking.h"
#include "core/numbers/statistics.h"
#include "core/pictures/srgb.h"
#include "core/values/errors.h"
#include "core/values/percent.h"

namespace keypose::capture::shoot {
namespace {

constexpr int kSharpness_px = 1600;  // as in the stage capture
constexpr int kMask_px = 256;
constexpr int kMoved_px = 1024;
constexpr double kLeastMask = 0.002, kLargestMask = 0.85;

/// Mean linear luma of the picture's border where there is no figure: it stays the same while the
/// table turns, whatever colours the figure has.
double LightOfSet(const Image8& image, const Image8& mask) {
  const int band = std::max(2, std::max(image.width, image.height) / 12);
  double sum = 0, count = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const bool inside =
          x >= band && y >= band && x < image.width - band && y < image.height - band;
      if (inside || mask.at(x, y)[0] > 127) continue;
      const std::uint8_t* pixel = image.at(x, y);
      sum += 0.299 * LinearFromSrgb(pixel[0] / 255.0) + 0.587 * LinearFromSrgb(pixel[1] / 255.0) +
             0.114 * LinearFromSrgb(pixel[2] / 255.0);
      count += 1;
    }
  return count > 0 ? sum / count : 0;
}

bool TouchesBorder(const Image8& mask) {
  int touching = 0;
  for (int x = 0; x < mask.width; ++x)
    touching += (mask.at(x, 0)[0] > 127) + (mask.at(x, mask.height - 1)[0] > 127);
  for (int y = 0; y < mask.height; ++y)
    touching += (mask.at(0, y)[0] > 127) + (mask.at(mask.width - 1, y)[0] > 127);
  return touching > std::max(mask.width, mask.height) / 100;
}

MaskOptions QuickMask() {
  MaskOptions options;
  options.working_px = kMask_px;
  return options;
}

Image8 QuickMaskOf(const Image8& image, int working_px) {
  const Image8 small = WorkingImage(image, kMask_px);
  const Image8 mask = SegmentSet({small}, {}, {}, QuickMask()).front();
  const Image8 wanted = WorkingImage(image, working_px);
  return Resized(mask, wanted.width, wanted.height);
}

/// Corners of the figure that are found again, and how far they went [px].
std::vector<double> Displacements(const cv::Mat& before, const cv::Mat& after,
                                  const cv::Mat& mask) {
  std::vector<cv::Point2f> corners, found, back;
  cv::goodFeaturesToTrack(before, corners, 400, 0.01, 6, mask);
  if (corners.empty()) return {};
  std::vector<std::uint8_t> seen, seen_back;
  std::vector<float> unused;
  const cv::Size window(15, 15);
  cv::calcOpticalFlowPyrLK(before, after, corners, found, seen, unused, window, 4);
  cv::calcOpticalFlowPyrLK(after, before, found, back, seen_back, unused, window, 4);
  std::vector<double> moved;
  for (std::size_t i = 0; i < corners.size(); ++i)
    if (seen[i] && seen_back[i] && cv::norm(back[i] - corners[i]) < 0.5)
      moved.push_back(cv::norm(found[i] - corners[i]));
  return moved;
}

double WholeShift(const cv::Mat& before, const cv::Mat& after) {
  cv::Mat a, b, window;
  before.convertTo(a, CV_32F);
  after.convertTo(b, CV_32F);
  cv::createHanningWindow(window, a.size(), CV_32F);
  return cv::norm(cv::phaseCorrelate(a, b, window));
}

/// The photographs of a ring, and what they have in common.
struct Ring {
  std::vector<PhotographEntry*> entries;
  /// medians
  double crispness = 0, sharpness = 0, light = 0, exposure = 0, mask_fraction = 0;
};

class Judge {
 public:
  explicit Judge(SideFile* side) : side_(*side) {}

  void All() {
    std::map<std::pair<int, int>, Ring> rings;
    for (auto& [shot, entry] : side_.photographs) {
      entry.findings.clear();
      if (!entry.readable) {
        entry.findings.push_back(
            {"unreadable", "the file cannot be read to its end", Again(entry)});
        continue;
      }
      rings[{shot.flip, shot.ring}].entries.push_back(&entry);
      ++sizes_[{entry.width, entry.height}];
    }
    for (auto& [key, ring] : rings) JudgeRing(ring);
    for (RingEntry& ring : side_.rings) JudgeWhole(ring);
  }

 private:
  std::string Again(const PhotographEntry& entry) const {
    return "shoot it again: again " + NameOf(side_.plan, entry.shot);
  }

  void JudgeRing(Ring& ring) {
    const auto median = [&](double PhotographEntry::*number) {
      std::vector<double> values;
      for (const PhotographEntry* entry : ring.entries) values.push_back(entry->*number);
      return UpperMedian(values);
    };
    ring.crispness = median(&PhotographEntry::crispness);
    ring.sharpness = median(&PhotographEntry::sharpness);
    ring.light = median(&PhotographEntry::light);
    ring.exposure = median(&PhotographEntry::exposure);
    ring.mask_fraction = median(&PhotographEntry::mask_fraction);
    for (PhotographEntry* entry : ring.entries) JudgeOne(ring, *entry);
  }

  void JudgeOne(const Ring& ring, PhotographEntry& entry) {
    const auto add = [&](const char* code, const std::string& words,
                         const std::string& what_to_do) {
      entry.findings.push_back({code, words, what_to_do});
    };
    JudgeSize(entry);
    if (!ShowsFigure(ring, entry)) {
      add("no-figure", "no figure like that of the ring's other photographs is found",
          "see whether it stands in the middle, lit, and differs from its background; " +
              Again(entry));
      return;  // what else was measured is not of the figure
    }
    if (entry.touches_border)
      add("touches-border", "the figure is cut off by the picture's border",
          "move the camera back or aim it anew, and begin the ring again");
    if (IsBlurred(ring, entry))
      add("blurred", "the photograph is blurred",
          "let the table rest longer (--settle 2), focus by hand, do not touch the table; " +
              Again(entry));
    JudgeLight(ring, entry);
    constexpr double kClipped = 0.05;
    if (entry.clipped > kClipped)
      add("clipped", PercentHalfEven(entry.clipped) + " of the figure is pure white or black",
          "change the exposure for the whole pose, or soften the light");
  }

  /// A figure's outline changes as it turns, but not threefold.
  static bool ShowsFigure(const Ring& ring, const PhotographEntry& entry) {
    constexpr double kTooUnlike = 3;
    const double fraction = entry.mask_fraction;
    return fraction >= kLeastMask && fraction <= kLargestMask &&
           fraction * kTooUnlike > ring.mask_fraction && fraction < kTooUnlike * ring.mask_fraction;
  }

  /// Crispness hardly depends on the texture, but takes noise for detail where a blur has left
  /// nothing else; the variance of the Laplacian depends on the texture, and falls far with a blur.
  static bool IsBlurred(const Ring& ring, const PhotographEntry& entry) {
    constexpr double kBlurred = 0.25, kFarUnderMedian = 0.75;  // in focus it is 0.52 to 0.75
    constexpr double kFlat = 0.2;                              // of the median
    return entry.crispness < kBlurred || entry.crispness < kFarUnderMedian * ring.crispness ||
           entry.sharpness < kFlat * ring.sharpness;
  }

  void JudgeSize(PhotographEntry& entry) {
    const auto usual =
        std::max_element(sizes_.begin(), sizes_.end(),
                         [](const auto& a, const auto& b) { return a.second < b.second; });
    if (usual->first == std::pair(entry.width, entry.height)) return;
    const auto text = [](int width, int height) {
      return std::to_string(width) + " x " + std::to_string(height);
    };
    entry.findings.push_back(
        {"size",
         "it has " + text(entry.width, entry.height) + " pixels, the others have " +
             text(usual->first.first, usual->first.second),
         "set the camera's picture size as before, and do not turn it; " + Again(entry)});
  }

  void JudgeLight(const Ring& ring, PhotographEntry& entry) {
    constexpr double kDrift_stops = 0.17, kDark = 0.002;
    // Before black velvet only the figure tells of the light, and its sides may differ in colour.
    const bool by_set = ring.light > kDark && entry.light > kDark / 16;
    const double own = by_set ? entry.light : LinearFromSrgb(entry.exposure / 255);
    const double usual = by_set ? ring.light : LinearFromSrgb(ring.exposure / 255);
    if (own <= 0 || usual <= 0) return;
    const double stops = std::log2(own / usual);
    if (std::abs(stops) < (by_set ? 1 : 3) * kDrift_stops) return;
    char words[96];
    std::snprintf(words, sizeof words, "it is %.1f stops %s than the ring's other photographs",
                  std::abs(stops), stops > 0 ? "brighter" : "darker");
    entry.findings.push_back(
        {"exposure", words,
         "set exposure, ISO and white balance on the camera by hand, and see that no lamp or "
         "daylight has changed; " +
             Again(entry)});
  }

  void JudgeWhole(RingEntry& ring) {
    ring.findings.clear();
    ring.missing_deg.clear();
    double width = 0;
    std::vector<double> there;
    for (const Shot& shot : AllShots(side_.plan)) {
      if (shot.flip != ring.flip || shot.ring != ring.ring) continue;
      const auto entry = side_.photographs.find(shot);
      const bool good = entry != side_.photographs.end() && entry->second.readable;
      (good ? there : ring.missing_deg).push_back(AngleOf(side_.plan, shot));
      if (good) width = std::max({width, 1.0 * entry->second.width, 1.0 * entry->second.height});
    }
    JudgeMoved(ring, width);
    if (!ring.missing_deg.empty()) AddMissing(ring, there);
  }

  void JudgeMoved(RingEntry& ring, double longer_px) {
    constexpr double kShare = 0.0015;  // of the picture's longer side; the table comes back closer
    if (!ring.moved_px || *ring.moved_px <= std::max(1.0, kShare * longer_px)) return;
    char words[128];
    std::snprintf(
        words, sizeof words,
        "the figure or the camera has moved by about %.0f pixels while this ring was shot",
        *ring.moved_px);
    ring.findings.push_back(
        {"moved", words,
         "see what has sunk or slipped, and shoot the ring again; if the camera was pushed, that "
         "ring only"});
  }

  void AddMissing(RingEntry& ring, const std::vector<double>& there) {
    double gap = there.empty() ? 360 : there.front() + 360 - there.back();
    for (std::size_t i = 1; i < there.size(); ++i) gap = std::max(gap, there[i] - there[i - 1]);
    std::string angles;
    for (const double angle : ring.missing_deg)
      angles += (angles.empty() ? "" : ", ") + DegreesText(angle);
    constexpr double kTooFar_deg = 30;
    ring.findings.push_back(
        {"missing",
         "angles are missing: " + angles + " degrees; the largest gap is " + DegreesText(gap) +
             " degrees",
         gap > kTooFar_deg
             ? "shoot them while the figure still stands: more than 30 degrees apart, "
               "photographs may not join"
             : "shoot them if you can; the gap is small enough to do without"});
  }

  SideFile& side_;
  std::map<std::pair<int, int>, int> sizes_;
};

}  // namespace

Measured MeasurePhotograph(const Image8& image) {
  Measured measured;
  measured.width = image.width;
  measured.height = image.height;
  const Image8 small = WorkingImage(image, kMask_px);
  const Image8 mask = SegmentSet({small}, {}, {}, QuickMask()).front();
  measured.mask_fraction = Decimal(MaskFraction(mask), 5);
  measured.touches_border = TouchesBorder(mask);
  measured.light = Decimal(LightOfSet(small, mask), 6);
  const Image8 grey = WorkingImage(Grey(image), kSharpness_px);
  const PhotographQuality quality = MeasureQuality(grey, Resized(mask, grey.width, grey.height));
  measured.crispness = Decimal(quality.crispness, 4);
  measured.sharpness = Decimal(quality.laplacian_variance, 2);
  measured.exposure = Decimal(quality.exposure, 2);
  measured.clipped = Decimal(quality.clipped, 5);
  return measured;
}

double MovedBetween(const Image8& before, const Image8& after) {
  if (before.width != after.width || before.height != after.height)
    throw InputError("the photographs of one angle differ in size");
  const Image8 a = WorkingImage(Grey(before), kMoved_px), b = WorkingImage(Grey(after), kMoved_px);
  const Image8 mask = QuickMaskOf(before, kMoved_px);
  const double scale = static_cast<double>(before.width) / a.width;
  std::vector<double> moved = Displacements(MatOf(a), MatOf(b), MatOf(mask));
  constexpr std::size_t kFewest = 12;
  if (moved.size() < kFewest) return Decimal(scale * WholeShift(MatOf(a), MatOf(b)), 2);
  return Decimal(scale * QuantileAbove(std::move(moved), 0.9), 2);
}

void JudgeAll(SideFile* side) { Judge(side).All(); }

}  // namespace keypose::capture::shoot
