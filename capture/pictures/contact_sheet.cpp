#include "capture/pictures/contact_sheet.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/pictures/render.h"

namespace keypose::capture {

Image8 ContactCell(const Image8& image, const Image8& mask, const std::string& name, int width) {
  const int height = std::max(
      1, static_cast<int>(std::lround(static_cast<double>(width) * image.height / image.width)));
  constexpr int kCaption = 16;
  const cv::Mat source(image.height, image.width, CV_8UC3,
                       const_cast<std::uint8_t*>(image.data.data()));
  const cv::Mat source_mask(mask.height, mask.width, CV_8U,
                            const_cast<std::uint8_t*>(mask.data.data()));
  Image8 cell(width, height + kCaption, 3, 255);
  cv::Mat all(cell.height, cell.width, CV_8UC3, cell.data.data()), small, inside;
  cv::resize(source, small, {width, height}, 0, 0, cv::INTER_AREA);
  cv::resize(source_mask, inside, {width, height}, 0, 0, cv::INTER_AREA);
  inside = inside > 127;
  cv::Mat picture = 0.35 * small + cv::Scalar(150, 0, 150);
  small.copyTo(picture, inside);
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(inside, outlines, cv::RETR_CCOMP, cv::CHAIN_APPROX_NONE);
  cv::drawContours(picture, outlines, -1, cv::Scalar(0, 255, 0));
  picture.copyTo(all(cv::Rect(0, 0, width, height)));
  cv::putText(all, name, {2, height + kCaption - 4}, cv::FONT_HERSHEY_PLAIN, 0.8,
              cv::Scalar(0, 0, 0), 1, cv::LINE_AA);
  return cell;
}

Image8 ContactSheet(const std::vector<Image8>& cells) {
  const double shape =
      cells.empty() ? 1 : static_cast<double>(cells.front().height) / cells.front().width;
  const int columns = std::max(
      1, static_cast<int>(std::ceil(std::sqrt(static_cast<double>(cells.size()) * shape))));
  return TileImages(cells, columns);
}

}  // namespace keypose::capture
