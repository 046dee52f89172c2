#include "capture/room/told_by_depths.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "capture/pictures/cv_image.h"
#include "capture/room/floor_picture.h"
#include "core/numbers/parallel.h"
#include "core/values/size_of.h"

namespace keypose::capture {
namespace {

// Of what the network says is the figure, depths may say that so much is the room; and of the
// depths' figure it may leave out so much. Depths are wrong near its outline.
constexpr int kFattened = 4;   // pixels that windows widen the figure by
constexpr float kThin = 0.6F;  // of a thin part's depth: its border
constexpr double kMostRoom = 0.35, kMostLeftOut = 0.1;

/// The kinds of pixels with depths; kNotTold elsewhere.
cv::Mat1b Marked(const Image8& image, const std::vector<DepthSample>& samples,
                 const std::vector<SampleLabel>& labels, double pixel) {
  cv::Mat1b kinds(image.height, image.width, std::uint8_t{kNotTold});
  const int half = std::max(0, static_cast<int>(std::ceil(pixel / 2 - 0.5)));
  for (std::size_t k = 0; k < samples.size(); ++k) {
    Told kind = kToldRoom;
    if (labels[k] == SampleLabel::kFigure) kind = kToldFigure;
    if (labels[k] == SampleLabel::kOpen) kind = kToldOpen;
    const int x = static_cast<int>(std::floor(samples[k].pixel.x())),
              y = static_cast<int>(std::floor(samples[k].pixel.y()));
    const cv::Rect cell = cv::Rect(x - half, y - half, 2 * half + 1, 2 * half + 1) &
                          cv::Rect(0, 0, kinds.cols, kinds.rows);
    if (!cell.empty()) kinds(cell) = std::uint8_t{kind};
  }
  return kinds;
}

/// Lone depths err.
cv::Mat1b WithoutSpecks(const cv::Mat1b& kinds, std::uint8_t kind) {
  cv::Mat1b of = kinds == kind, opened;
  cv::morphologyEx(of, opened, cv::MORPH_OPEN, cv::Mat1b::ones(3, 3));
  return opened;
}

/// How far each pixel is from the figure's points that the picture could show, in pixels.
cv::Mat1f AwayFrom(const std::vector<Eigen::Vector3d>& points, const View& view,
                   const cv::Mat1b& figure) {
  cv::Mat1b shown = figure.clone();
  for (const Eigen::Vector3d& point : points) {
    if ((view.camera_from_world * point).z() <= 0) continue;
    const Eigen::Vector2d p = view.Project(point);
    const int x = static_cast<int>(std::floor(p.x())), y = static_cast<int>(std::floor(p.y()));
    if (x >= 0 && y >= 0 && x < shown.cols && y < shown.rows) shown(y, x) = 255;
  }
  cv::Mat1f away;
  cv::distanceTransform(~shown, away, cv::DIST_L2, cv::DIST_MASK_5);
  return away;
}

/// Shares of a mask that depths say is the room, and of the depths' figure that it leaves out.
bool Contradicts(const Image8& mask, const Image8& kinds) {
  double inside = 0, wrong_inside = 0, figure = 0, left_out = 0;
  for (std::size_t p = 0; p < mask.data.size(); ++p) {
    const bool in = mask.data[p] > 127;
    inside += in;
    wrong_inside += in && kinds.data[p] == kToldRoom;
    figure += kinds.data[p] == kToldFigure;
    left_out += !in && kinds.data[p] == kToldFigure;
  }
  return wrong_inside > kMostRoom * inside || left_out > kMostLeftOut * figure;
}

/// The figure's depths without those near their border, where windows widen it; of thin parts the
/// middle stays.
cv::Mat1b WellInside(const cv::Mat1b& figure) {
  cv::Mat1f depth, deepest;
  cv::distanceTransform(figure, depth, cv::DIST_L2, cv::DIST_MASK_5);
  cv::dilate(depth, deepest, cv::Mat1b::ones(2 * kFattened + 1, 2 * kFattened + 1));
  cv::Mat1b inside(figure.size(), std::uint8_t{0});
  for (int y = 0; y < figure.rows; ++y)
    for (int x = 0; x < figure.cols; ++x)
      if (figure(y, x) && depth(y, x) > std::min<float>(kFattened, kThin * deepest(y, x)))
        inside(y, x) = 255;
  return inside;
}

ToldView Tell(const View& view, const cv::Mat1b& marked, const Image8& floor,
              const StandingFigure& standing, const TellByDepthsOptions& options) {
  const cv::Mat1b plane = MatOf(floor);
  const cv::Mat1b on_plane = WithoutSpecks(plane, kSurelyFloor),
                  maybe_plane = WithoutSpecks(plane, kPerhapsFloor) | on_plane,
                  room = WithoutSpecks(marked, kToldRoom),
                  figure = WithoutSpecks(marked, kToldFigure) & ~on_plane;
  const cv::Mat1b inside = WellInside(figure);
  const int pixels = cv::countNonZero(figure);
  if (pixels < options.fewest * marked.cols * marked.rows) return {};
  const cv::Rect box = cv::boundingRect(figure);
  const double near = options.near * std::max(box.width, box.height);
  const cv::Mat1f away = AwayFrom(standing.points, view, figure);
  ToldView told{Image8(marked.cols, marked.rows, 1, 0),
                Image8(marked.cols, marked.rows, 1, kToldOpen)};
  for (int y = 0; y < marked.rows; ++y)
    for (int x = 0; x < marked.cols; ++x) {
      const bool is_room = figure(y, x) == 0 && ((room(y, x) && away(y, x) > options.fattened_px) ||
                                                 away(y, x) > near || on_plane(y, x));
      if (inside(y, x))
        *told.kinds.at(x, y) = kToldFigure;
      else if (is_room)
        *told.kinds.at(x, y) = kToldRoom;
      else if (maybe_plane(y, x))
        *told.kinds.at(x, y) = kToldLikelyRoom;
      *told.mask.at(x, y) = is_room ? 0 : 255;
    }
  return told;
}

}  // namespace

ToldFigure TellByDepths(const std::vector<Image8>& images, const std::vector<View>& views,
                        const CoarseDepths& depths, const StandingFigure& figure,
                        const std::vector<Image8>& floor, const TellByDepthsOptions& options) {
  ToldFigure told;
  told.in_pieces = true;
  told.views.resize(images.size());
  ParallelFor(std::ssize(images), [&](std::int64_t k) {
    const auto v = static_cast<std::size_t>(k);
    const cv::Mat1b marked = Marked(images[v], depths.views[v], figure.samples[v], depths.pixel);
    told.views[v] = Tell(views[v], marked, floor[v], figure, options);
  });
  for (std::size_t v = 0; v < images.size(); ++v)
    if (!told.views[v].mask.empty()) told.fitting.push_back(static_cast<int>(v));
  return told;
}

ToldFigure ToldByBoth(const ToldFigure& said, const ToldFigure& depths,
                      const FirstMasksOptions& options) {
  // Views that only depths tell of are open in many places: they would make the common space large.
  ToldFigure both;
  both.views.resize(depths.views.size());
  for (const int view : said.fitting) {
    const auto v = static_cast<std::size_t>(view);
    const ToldView& by_depths = depths.views[v];
    ToldView told = said.views[v];
    if (!by_depths.mask.empty() && Contradicts(told.mask, by_depths.kinds)) continue;
    for (std::size_t p = 0; p < by_depths.kinds.data.size(); ++p) {
      const std::uint8_t kind = by_depths.kinds.data[p];
      if (kind != kToldFigure && kind != kToldRoom) continue;
      told.kinds.data[p] = kind;
      told.mask.data[p] = kind == kToldFigure ? 255 : 0;
    }
    both.views[v] = std::move(told);
    both.fitting.push_back(view);
  }
  const int agreeing = SizeOf(both.fitting);
  if (agreeing < options.fewest || 2 * agreeing < SizeOf(said.fitting)) both.fitting.clear();
  return both;
}

void AddStrokes(const std::vector<ViewStrokes>& strokes, ToldFigure& told) {
  for (std::size_t v = 0; v < strokes.size(); ++v) {
    ToldView& view = told.views[v];
    if (view.mask.empty()) continue;
    const auto mark = [&view](const std::vector<Eigen::Vector2i>& pixels, std::uint8_t kind) {
      for (const Eigen::Vector2i& pixel : pixels)
        for (int k = 0; k < 9; ++k) {
          const int x = pixel.x() + k % 3 - 1, y = pixel.y() + k / 3 - 1;
          if (x < 0 || y < 0 || x >= view.mask.width || y >= view.mask.height) continue;
          *view.kinds.at(x, y) = kind;
          *view.mask.at(x, y) = kind == kToldFigure ? 255 : 0;
        }
    };
    mark(strokes[v].figure, kToldFigure);
    mark(strokes[v].other, kToldRoom);
  }
}

BoardOdds KnownOdds(const ToldView& told, double figure, double room) {
  BoardOdds known{Image8(told.kinds.width, told.kinds.height, 1, 0),
                  ImageF(told.kinds.width, told.kinds.height, 1)};
  const auto odds_of = [&](std::uint8_t kind) {
    if (kind == kToldFigure) return figure;
    if (kind == kToldRoom) return -room;
    return kind == kToldLikelyRoom ? -room / 2 : 0;
  };
  for (std::size_t p = 0; p < told.kinds.data.size(); ++p) {
    const double odds = odds_of(told.kinds.data[p]);
    if (odds == 0) continue;
    known.on_board.data[p] = 255;
    known.odds.data[p] = static_cast<float>(odds);
  }
  return known;
}

}  // namespace keypose::capture
