#include "capture/pictures/contact_sheet.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "capture/pictures/cv_image.h"
#include "core/pictures/render.h"

namespace keypose::capture {
namespace {

constexpr int kCaption_px = 16;

int HeightAt(const Image8& image, int width) {
  return std::max(
      1, static_cast<int>(std::lround(static_cast<double>(width) * image.height / image.width)));
}

/// A cell of the picture with a caption below.
Image8 Captioned(const cv::Mat& picture, const std::string& caption) {
  Image8 cell(picture.cols, picture.rows + kCaption_px, 3, 255);
  cv::Mat all(cell.height, cell.width, CV_8UC3, cell.data.data());
  picture.copyTo(all(cv::Rect(0, 0, picture.cols, picture.rows)));
  cv::putText(all, caption, {2, cell.height - 4}, cv::FONT_HERSHEY_PLAIN, 0.8, cv::Scalar(0, 0, 0),
              1, cv::LINE_AA);
  return cell;
}

}  // namespace

Image8 ContactCell(const Image8& image, const Image8& mask, const std::string& name, int width) {
  const int height = HeightAt(image, width);
  const cv::Mat source = MatOf(image), source_mask = MatOf(mask);
  cv::Mat small, inside;
  cv::resize(source, small, {width, height}, 0, 0, cv::INTER_AREA);
  cv::resize(source_mask, inside, {width, height}, 0, 0, cv::INTER_AREA);
  inside = inside > 127;
  cv::Mat picture = 0.35 * small + cv::Scalar(150, 0, 150);
  small.copyTo(picture, inside);
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(inside, outlines, cv::RETR_CCOMP, cv::CHAIN_APPROX_NONE);
  cv::drawContours(picture, outlines, -1, cv::Scalar(0, 255, 0));
  return Captioned(picture, name);
}

Image8 LeftOutCell(const Image8& image, const std::string& caption, int width) {
  const cv::Size size(width, HeightAt(image, width));
  cv::Mat small, grey, picture;
  cv::resize(MatOf(image), small, size, 0, 0, cv::INTER_AREA);
  cv::cvtColor(small, grey, cv::COLOR_RGB2GRAY);
  cv::cvtColor(grey, picture, cv::COLOR_GRAY2RGB);
  const cv::Scalar red(220, 30, 30);
  cv::line(picture, {0, 0}, {size.width - 1, size.height - 1}, red, 2, cv::LINE_AA);
  cv::line(picture, {0, size.height - 1}, {size.width - 1, 0}, red, 2, cv::LINE_AA);
  return Captioned(picture, caption);
}

Image8 ContactSheet(const std::vector<Image8>& cells) {
  const double shape =
      cells.empty() ? 1 : static_cast<double>(cells.front().height) / cells.front().width;
  const int columns = std::max(
      1, static_cast<int>(std::ceil(std::sqrt(static_cast<double>(cells.size()) * shape))));
  return TileImages(cells, columns);
}

}  // namespace keypose::capture
