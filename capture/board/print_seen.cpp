#include "capture/board/print_seen.h"

#include <opencv2/imgproc.hpp>

namespace keypose::capture {

Image8 PrintSeen(const BoardOdds& board) {
  if (board.on_board.empty()) return {};
  Image8 print = board.on_board;
  for (std::size_t p = 0; p < print.data.size(); ++p)
    if (board.odds.data[p] > 0) print.data[p] = 0;
  cv::Mat shows(print.height, print.width, CV_8UC1, print.data.data());
  const cv::Mat disc = cv::getStructuringElement(cv::MORPH_ELLIPSE, {5, 5});
  cv::morphologyEx(shows, shows, cv::MORPH_CLOSE, disc);
  cv::morphologyEx(shows, shows, cv::MORPH_OPEN, disc);
  return print;
}

}  // namespace keypose::capture
