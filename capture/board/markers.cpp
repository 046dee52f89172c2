#include "capture/board/markers.h"

#include <algorithm>
#include <cmath>
#include <opencv2/aruco.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "capture/board/board_pattern.h"
#include "capture/board/grey_level.h"

namespace keypose::capture {
namespace {

constexpr double kSearch_px = 2000;  // longer side at which markers are searched
constexpr int kSmall_px = 1000;      // of a picture that is searched at twice its size

cv::Mat MatOf(const Image8& grey) {
  return {grey.height, grey.width, CV_8UC1, const_cast<std::uint8_t*>(grey.data.data())};
}

/// Converts from pixel centres at whole numbers of the resized image to those of the image.
Eigen::Vector2d InPicture(const cv::Point2f& p, double factor) {
  return {(p.x + 0.5) / factor - 0.5, (p.y + 0.5) / factor - 0.5};
}

cv::Ptr<cv::aruco::DetectorParameters> Parameters() {
  auto parameters = cv::aruco::DetectorParameters::create();
  parameters->minMarkerPerimeterRate = 0.012;  // markers in low views are flat
  parameters->polygonalApproxAccuracyRate = 0.05;
  parameters->adaptiveThreshWinSizeMax = 43;
  return parameters;
}

/// Quads found in a resized copy of the picture: markers and what was rejected.
struct Quads {
  std::vector<std::vector<cv::Point2f>> markers, others;
  std::vector<int> ids;
  double factor = 1;
};

Quads Detect(const cv::Mat& grey, int dictionary, double factor) {
  Quads quads;
  quads.factor = factor;
  cv::Mat sized = grey;
  if (factor != 1)
    cv::resize(grey, sized, {}, factor, factor, factor < 1 ? cv::INTER_AREA : cv::INTER_CUBIC);
  cv::aruco::detectMarkers(
      sized, cv::aruco::getPredefinedDictionary(cv::aruco::PREDEFINED_DICTIONARY_NAME(dictionary)),
      quads.markers, quads.ids, Parameters(), quads.others);
  return quads;
}

double SearchFactor(const cv::Mat& grey) {
  return std::min(1.0, kSearch_px / std::max(grey.cols, grey.rows));
}

std::array<Eigen::Vector2d, 4> CornersOf(const std::vector<cv::Point2f>& quad, double factor) {
  std::array<Eigen::Vector2d, 4> corners;
  for (int k = 0; k < 4; ++k) corners[k] = InPicture(quad[k], factor);
  return corners;
}

std::vector<SeenMarker> MarkersOf(const Quads& quads) {
  std::vector<SeenMarker> markers;
  for (std::size_t i = 0; i < quads.ids.size(); ++i)
    markers.push_back({quads.ids[i], CornersOf(quads.markers[i], quads.factor)});
  return markers;
}

/// Mean grey levels of the cells of a quad, cells x cells.
cv::Mat1d CellsOf(const cv::Mat& grey, const MarkerQuad& quad, int cells) {
  constexpr int kSamples = 3;  // each way, in the middle of a cell
  std::vector<cv::Point2f> unit{{0, 0}, {1, 0}, {1, 1}, {0, 1}}, seen;
  for (const Eigen::Vector2d& p : quad.corners)
    seen.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  const cv::Mat h = cv::getPerspectiveTransform(unit, seen);
  const cv::Matx33d map(h.ptr<double>());
  cv::Mat1d levels(cells, cells, 0.0);
  for (int r = 0; r < cells * kSamples; ++r)
    for (int c = 0; c < cells * kSamples; ++c) {
      // samples at 0.3, 0.5 and 0.7 of a cell
      const double u = (c / kSamples + 0.3 + 0.2 * (c % kSamples)) / cells;
      const double v = (r / kSamples + 0.3 + 0.2 * (r % kSamples)) / cells;
      const cv::Vec3d p = map * cv::Vec3d(u, v, 1);
      levels(r / kSamples, c / kSamples) +=
          LevelAt(grey, p[0] / p[2], p[1] / p[2]) / (kSamples * kSamples);
    }
  return levels;
}

/// Bits inside of the border, 1 for white; none where the border is not dark.
std::optional<cv::Mat> BitsOf(const cv::Mat1d& levels) {
  constexpr double kContrast = 25;         // grey levels
  constexpr double kBrightInBorder = 0.1;  // share of its cells
  double low = 0, high = 0;
  cv::minMaxLoc(levels, &low, &high);
  if (high - low < kContrast) return {};
  const double middle = (low + high) / 2;
  const int cells = levels.rows;
  int bright = 0;
  for (int i = 0; i < cells; ++i)
    for (int k = 0; k < cells; ++k)
      if (i == 0 || k == 0 || i == cells - 1 || k == cells - 1) bright += levels(i, k) > middle;
  if (bright > kBrightInBorder * 4 * (cells - 1)) return {};
  cv::Mat bits(cells - 2, cells - 2, CV_8UC1);
  for (int r = 0; r < cells - 2; ++r)
    for (int c = 0; c < cells - 2; ++c) bits.at<std::uint8_t>(r, c) = levels(r + 1, c + 1) > middle;
  return bits;
}

/// A contour runs through the outermost dark pixels; the edge lies half a pixel beyond.
void Grow(double by_px, MarkerQuad* quad) {
  const double side = quad->Side();
  const Eigen::Vector2d middle =
      (quad->corners[0] + quad->corners[1] + quad->corners[2] + quad->corners[3]) / 4;
  for (Eigen::Vector2d& corner : quad->corners)
    corner = middle + (corner - middle) * (side + by_px) / side;
}

}  // namespace

Image8 GreyPicture(const Image8& image, bool inverted) {
  const cv::Mat view(image.height, image.width, CV_8UC(image.channels),
                     const_cast<std::uint8_t*>(image.data.data()));
  Image8 grey(image.width, image.height, 1);
  cv::Mat into = MatOf(grey);
  if (image.channels == 1)
    view.copyTo(into);
  else
    cv::cvtColor(view, into, cv::COLOR_RGB2GRAY);
  if (inverted) cv::bitwise_not(into, into);
  return grey;
}

Image8 MirroredPicture(const Image8& grey) {
  Image8 mirrored(grey.width, grey.height, 1);
  cv::Mat into = MatOf(mirrored);
  cv::flip(MatOf(grey), into, 1);
  return mirrored;
}

double MarkerQuad::Side() const {
  double sum = 0;
  for (int k = 0; k < 4; ++k) sum += (corners[(k + 1) % 4] - corners[k]).norm();
  return sum / 4;
}

std::vector<SeenMarker> FindMarkers(const Image8& grey, int dictionary, bool thorough) {
  const cv::Mat mat = MatOf(grey);
  std::vector<SeenMarker> markers = MarkersOf(Detect(mat, dictionary, SearchFactor(mat)));
  if (!thorough || std::max(grey.width, grey.height) > kSmall_px) return markers;
  std::vector<SeenMarker> enlarged = MarkersOf(Detect(mat, dictionary, 2));
  return enlarged.size() > markers.size() ? enlarged : markers;
}

std::vector<MarkerQuad> FindQuads(const Image8& grey) {
  const cv::Mat mat = MatOf(grey);
  const bool small = std::max(grey.width, grey.height) <= kSmall_px;
  const Quads quads = Detect(mat, LargestDictionaries().front(), small ? 2 : SearchFactor(mat));
  std::vector<MarkerQuad> found;
  for (const auto& list : {quads.markers, quads.others})
    for (const auto& quad : list) {
      found.push_back({CornersOf(quad, quads.factor)});
      Grow(1 / quads.factor, &found.back());
    }
  return found;
}

std::vector<SeenMarker> ReadQuads(const Image8& grey, const std::vector<MarkerQuad>& quads,
                                  int dictionary) {
  const cv::Mat mat = MatOf(grey);
  const auto words =
      cv::aruco::getPredefinedDictionary(cv::aruco::PREDEFINED_DICTIONARY_NAME(dictionary));
  std::vector<SeenMarker> markers;
  for (const MarkerQuad& quad : quads) {
    const std::optional<cv::Mat> bits = BitsOf(CellsOf(mat, quad, words->markerSize + 2));
    int id = 0, turns = 0;
    if (!bits || !words->identify(*bits, id, turns, 0)) continue;
    SeenMarker marker{id, {}};
    // `turns` quarters bring the picture's first corner to the marker's own
    for (int k = 0; k < 4; ++k) marker.corners[k] = quad.corners[(k + 4 - turns) % 4];
    markers.push_back(marker);
  }
  return markers;
}

}  // namespace keypose::capture
